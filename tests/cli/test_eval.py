"""The command `eval`: its folder, and what it refuses in one line."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path

import pytest

from pipenav.cli import main
from pipenav.storage.lock import one_writer

PIPE = "d=100,angle=90"


def run(capsys: pytest.CaptureFixture[str], *args: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as left:
        main(["eval", *args])
    shown = capsys.readouterr()
    code = left.value.code
    assert code is None or isinstance(code, int)
    return code or 0, shown.out, shown.err


def test_the_command_writes_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    code, said, _ = run(capsys, "--policy", "baseline:random", "--pipes", PIPE, "--episodes", "4")
    folder = Path("runs") / "baseline-random" / "eval-d100-angle90-4-episodes"
    assert code == 0
    assert str(folder) in said.replace("\n", "")
    pictures = {"success.png", "map.png", "report.html"}
    assert {path.name for path in folder.iterdir()} == {"eval.json", "eval.csv", "failures.json", *pictures}
    table = json.loads((folder / "eval.json").read_text(encoding="utf-8"))
    assert len(table["pipes"]) == 1
    assert table["pipes"][0]["episodes"] == 4
    with (folder / "eval.csv").open(encoding="utf-8", newline="") as file:
        assert len(list(csv.DictReader(file))) == 1
    for name in ("success.png", "map.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("--policy", "baseline:centerline"), "unknown baseline 'baseline:centerline': did you mean"),
        (("--policy", "no-such-policy"), "unknown policy 'no-such-policy'"),
        (("--policy", "no-such.zip"), "no-such.zip"),
        (("--pipes", "thesi"), "unknown pipe set 'thesi': did you mean 'thesis'"),
        (("--pipes", "d=90"), "pipe 'd=90' is incomplete"),
        (("--backend", "mujocco"), "unknown backend 'mujocco': did you mean 'mujoco'"),
        (("--robot", "basik"), "unknown robot 'basik': did you mean 'basic'?"),
        (("--variant", "thesis"), "--variant would be ignored here: it says how --stage locate or passage"),
        (
            ("--policy", "arm", "--robot", "pirate"),
            "policy arm was made for robot 'basic' and brings it, given",
        ),
        (("--option", "timestep=0.001", "--option", "timestep=0.002"), "option 'timestep' is given twice"),
        (("--require", "0.99"), "--require 0.99 is not a percentage: write it as 99% or 99.5%."),
        (("--require", "many"), "--require many is not a percentage"),
        (("--option", "timestep=nan"), "timestep: input should be a finite number, given nan."),
        (("--option", "timestep=2026-01-01"), "timestep: input should be a valid number"),
        (("--option", "=1"), "option '=1' is not a setting: write it as key=value"),
        (("--policy", "Baseline:random"), "unknown baseline 'Baseline:random': did you mean 'baseline:random'"),
        (("--backend", "MuJoCo"), "unknown backend 'MuJoCo': did you mean 'mujoco'?"),
        (("--pipes", "runs-level"), "'runs-level' names routes: give single corners"),
        (("--option", "timestep"), "option 'timestep' is not a setting: write it as key=value"),
        (("--option", "timstep=1"), "unknown key 'timstep': did you mean 'timestep'"),
        (("--option", "timestep=often"), "timestep: input should be a valid number, given 'often'."),
    ],
)
def test_what_is_wrong_is_said_in_one_line(
    args: tuple[str, ...], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    policy = () if "--policy" in args else ("--policy", "baseline:random")
    code, said, error = run(capsys, *policy, "--out", str(out), *args)
    assert code == 1
    assert error.startswith("pipenav: error: ")
    assert message in error
    assert error.count("\n") == 1
    assert not said
    assert not out.exists()


def test_a_folder_that_cannot_be_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "file"
    file.touch()
    code, _, error = run(capsys, "--policy", "baseline:random", "--out", str(file))
    assert code == 1
    assert error == f"pipenav: error: cannot use the folder {file}: it is a file; choose another place.\n"


QUICK = ("--pipes", PIPE, "--episodes", "2")


def test_a_required_success_decides_the_exit_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ("--out", str(tmp_path / "eval"))
    code, said, error = run(capsys, "--policy", "baseline:random", *QUICK, *out, "--require", "99%")
    assert code == 1
    assert "success 0% is below the required 99%." in error
    assert "evaluation folder" in said
    assert (tmp_path / "eval" / "eval.json").is_file()
    assert run(capsys, "--policy", "baseline:random", *QUICK, *out, "--require", "0")[0] == 0


def test_what_is_piped_on_is_the_result_alone_with_whole_paths(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / ("exp[bold]" + "long-" * 30) / "real[/]1"
    code, said, error = run(capsys, "--policy", "baseline:random", *QUICK, "--out", str(out))
    assert code == 0
    assert f"evaluation folder {out}: eval.json, eval.csv, success.png, map.png, report.html, failures.json\n" in said
    assert "reach: success" in error
    assert "reach: success" not in said


def test_another_evaluation_is_not_replaced_and_the_same_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ("--out", str(tmp_path / "eval"))
    assert run(capsys, "--policy", "baseline:random", *QUICK, *out)[0] == 0
    (tmp_path / "eval" / "notes.txt").write_text("mine")
    before = (tmp_path / "eval" / "eval.json").read_bytes()
    code, _, error = run(capsys, "--policy", "baseline:random", *QUICK, *out, "--seed", "3")
    assert code == 1
    assert "holds another evaluation (seed 0 there, 3 now): choose another --out, or remove it." in error
    assert (tmp_path / "eval" / "eval.json").read_bytes() == before
    assert run(capsys, "--policy", "baseline:random", *QUICK, *out)[0] == 0
    assert (tmp_path / "eval" / "notes.txt").read_text() == "mine"
    assert len(list((tmp_path / "eval").iterdir())) == 7


def test_a_folder_in_use_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with one_writer(tmp_path, "pipenav train --resume here"):
        code, _, error = run(capsys, "--policy", "baseline:random", *QUICK, "--out", str(tmp_path))
    assert code == 1
    assert f"{tmp_path} is in use by process {os.getpid()} (pipenav train --resume here)" in error
    assert list(tmp_path.iterdir()) == []
