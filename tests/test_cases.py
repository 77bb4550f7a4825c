"""Inputs that once ended in a traceback, each through the command that takes it: refused in a sentence."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command import run

from pipenav.errors import PipenavError

CASES = sorted((Path(__file__).parent / "data" / "cases").glob("*-*"))

ROUTE = ["eval", "--policy", "arm", "--episodes", "1", "--pipes"]
COMMANDS = {
    "arm-toml": [["hw-check", "--arm"]],
    "cli-config": [["train", "--out", "r", "--config"]],
    "config-toml": [["train", "--out", "r", "--config"]],
    "cli-robot": [
        ["locate-target", "--d", "100", "--angle", "90", "--robot"],
        ["eval", "--policy", "baseline:sequence-line", "--pipes", "d=110,angle=120", "--episodes", "1", "--robot"],
    ],
    "robot-toml": [["locate-target", "--d", "100", "--angle", "90", "--robot"]],
    "disturbance-toml": [["eval", "--policy", "arm", "--pipes", "d=110,angle=120", "--episodes", "1", "--disturb"]],
    "gen-pipe-run-toml": [["gen-pipe", "--run"]],
    "pipe-set-toml": [ROUTE],
    "pipe-toml": [ROUTE],
}


def kind_of(case: Path) -> str:
    return next((kind for kind in COMMANDS if case.name.startswith(kind)), "")


@pytest.mark.parametrize("case", [case for case in CASES if kind_of(case)], ids=lambda case: case.name)
def test_a_command_refuses_it_in_a_sentence(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for command in COMMANDS[kind_of(case)]:
        assert run(*command, str(case)) == 1
        message = capfd.readouterr().err.strip()
        assert message.startswith("pipenav: error: ")
        assert "\n" not in message
        assert len(message) < 1000
    assert not list(tmp_path.iterdir()), "something was made on disk"


@pytest.mark.parametrize("case", [case for case in CASES if not kind_of(case)], ids=lambda case: case.name)
def test_a_reader_refuses_it_in_a_sentence(case: Path, tmp_path: Path) -> None:
    with pytest.raises(PipenavError) as refused:
        open_case(case, tmp_path)
    assert len(str(refused.value)) < 1000


def open_case(case: Path, folder: Path) -> None:
    from pipenav.export.corner_folder import read_pipe
    from pipenav.export.route_folder import read_route_folder
    from pipenav.learning.training_folder import TrainingFolder
    from pipenav.pipes.route_sets import parse_pipes

    if case.name.startswith("typed-pipe"):
        parse_pipes([case.read_text().splitlines()[-1]])
    elif case.name.startswith("pipe-json"):
        read_pipe(case)
    elif case.name.startswith("run-json"):
        read_route_folder(case)
    else:
        assert case.name.startswith("run-folder-config-json")
        (folder / "config.json").write_bytes(case.read_bytes())
        (folder / "resume.safetensors").touch()
        TrainingFolder.open(folder)
