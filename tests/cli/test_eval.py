"""The command `eval`: its folder, and what it refuses in one line."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from pipenav.cli import main

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
    folder = Path("runs") / "baseline-random" / "eval-d100-angle90"
    assert code == 0
    assert str(folder) in said.replace("\n", "")
    assert {path.name for path in folder.iterdir()} == {"eval.json", "eval.csv", "success.png", "map.png"}
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
        (("--option", "timestep"), "option 'timestep' has no value: write it as key=value"),
        (("--option", "timstep=1"), "unknown key 'timstep': did you mean 'timestep'"),
        (("--option", "timestep=often"), "timestep: input should be a valid number, given 'often'."),
    ],
)
def test_what_is_wrong_is_said_in_one_line(
    args: tuple[str, ...], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    code, said, error = run(capsys, *("--policy", "baseline:random", "--out", str(out), *args))
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
    assert error == f"pipenav: error: cannot use the folder {file}: it is a file.\n"
