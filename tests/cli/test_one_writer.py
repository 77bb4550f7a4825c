"""A folder in use is refused by every command that would write into it; killed commands leave whole folders."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.command import run
from helpers.waiting import wait_until

from pipenav.evaluation.report import FILES
from pipenav.evaluation.results import read_evaluation
from pipenav.export.corner_folder import read_pipe
from pipenav.storage.lock import LOCK_FILE, one_writer

TRAINING = ("train", "--steps", "1000000", "--pipes", "d=100,angle=90", "--set", "check.every=1000000")
QUICK = ("--pipes", "d=100,angle=90", "--episodes", "1")


def commands_into(folder: Path) -> list[tuple[str, ...]]:
    """Commands that write into a folder."""
    out = ("--out", str(folder))
    return [
        ("eval", "--policy", "arm", *QUICK, *out),
        ("experiment", "e", "--seeds", "1", "--episodes", "1", *out),
        ("tune", *out),
        ("locate-target", "--d", "100", "--angle", "90", *out),
        ("compare-backends", "--other", "mujoco", *out),
    ]


@pytest.fixture
def training(tmp_path: Path) -> Iterator[Path]:
    """The folder of a training that goes on."""
    folder = tmp_path / "training"
    process = subprocess.Popen([sys.executable, "-m", "pipenav", *TRAINING, "--out", str(folder)])
    wait_until(lambda: (folder / "resume.safetensors").exists(), "the training saved")
    yield folder
    process.kill()
    process.wait()


@pytest.mark.slow
def test_a_training_keeps_its_folder(training: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (training / "config.json").read_bytes()
    for command in [("train", "--resume", str(training), "--steps", "5"), *commands_into(training)]:
        assert run(*command) == 1
        said = capsys.readouterr().err
        assert f"{training} is in use by process " in said
        assert "(pipenav train --steps 1000000" in said
    assert run(*TRAINING, "--out", str(training)) == 1
    assert "already holds a training" in capsys.readouterr().err
    assert (training / "config.json").read_bytes() == before
    assert run("eval", "--policy", str(training / "last.zip"), *QUICK) == 0  # it has a folder of its own


def test_every_command_is_refused_before_it_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with one_writer(tmp_path, "somebody"):
        for command in [(*TRAINING, "--out", str(tmp_path)), *commands_into(tmp_path)]:
            assert run(*command) == 1
            assert f"in use by process {os.getpid()} (somebody)" in capsys.readouterr().err
            assert [path.name for path in tmp_path.iterdir()] == [LOCK_FILE]


@pytest.mark.parametrize(
    ("work", "command"),
    [
        ("pipenav.recording.record.record_locate", ("locate-target", "--d", "100", "--angle", "90")),
        ("pipenav.comparison.agreement.compare", ("compare-backends", "--other", "mujoco")),
    ],
)
def test_a_command_that_is_stopped_leaves_no_empty_folder(
    work: str, command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(work, interrupted)
    assert run(*command, "--out", str(tmp_path / "some" / "where")) == 128 + signal.SIGTERM
    assert not list(tmp_path.iterdir())


def test_resuming_what_is_no_training_makes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("train", "--resume", str(tmp_path / "nothing")) == 1
    assert "holds no training" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_killed_commands_leave_the_older_folder_or_the_new_one(tmp_path: Path) -> None:
    pipe = ("gen-pipe", "--d", "100", "--angle", "75", "--out", str(tmp_path))
    measured = ("eval", "--policy", "arm", *QUICK, "--out", str(tmp_path / "eval"))
    rng = random.Random(1)
    for command in (pipe, measured):
        assert run(*command) == 0
        started = time.monotonic()
        assert subprocess.call([sys.executable, "-m", "pipenav", *command], stdout=subprocess.DEVNULL) == 0
        takes = time.monotonic() - started
        for number in (signal.SIGTERM, signal.SIGINT, *8 * [signal.SIGKILL]):
            process = subprocess.Popen([sys.executable, "-m", "pipenav", *command], stderr=subprocess.DEVNULL)
            time.sleep(takes * rng.uniform(0.5, 1.0))
            process.send_signal(number)
            process.wait()
            read_pipe(tmp_path / "corner-d100-a75-left")
            if command is measured:
                assert read_evaluation(tmp_path / "eval").episodes == 1
                assert {path.name for path in (tmp_path / "eval").iterdir()} >= set(FILES)
        assert run(*command) == 0
    names = {path.name for path in [*tmp_path.iterdir(), *(tmp_path / "eval").iterdir()]}
    assert not [name for name in names if name.startswith(".")]
