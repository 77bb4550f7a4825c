"""Trainings that are stopped or killed from outside leave whole files."""

from __future__ import annotations

import csv
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from helpers.waiting import GENEROUS, wait_until

from pipenav.cli.signals import STOPPING
from pipenav.learning.progress import PROGRESS_COLUMNS
from pipenav.learning.train import train
from pipenav.learning.training_folder import TrainingFolder
from pipenav.policies.policy import load_policy

pytestmark = pytest.mark.slow

SETTINGS = (
    "learner.robots=16",
    "learner.rollout_steps=16",
    "learner.batch_size=64",
    "learner.epochs=2",
    "check.episodes=4",
)


def options(every: int) -> list[str]:
    """A training without end, checked every so many steps."""
    settings = [f"--set={setting}" for setting in (*SETTINGS, f"check.every={every}")]
    return ["--steps", "10000000", "--pipes", "d=100,angle=90", *settings]


def require_whole_progress(folder: TrainingFolder) -> None:
    with folder.progress.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert all(tuple(row) == PROGRESS_COLUMNS and None not in row.values() for row in rows)


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts long trainings as processes of their own, and ends them after the test."""
    started: list[subprocess.Popen[str]] = []

    def starter(name: str, every: int) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "pipenav", "train", "--out", str(tmp_path / name), *options(every)]
        environment = os.environ | {"OMP_NUM_THREADS": "1", "COLUMNS": "500"}
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment
        )
        started.append(process)
        return process

    yield starter
    for process in started:
        process.kill()
        process.communicate()


def test_stop_signals_are_answered_save_and_give_the_exit_code(
    start: Callable[..., subprocess.Popen[str]], tmp_path: Path
) -> None:
    runs = {number: start(number.name, 10_000_000) for number in STOPPING}
    for number in runs:
        checkpoint = TrainingFolder(tmp_path / number.name).checkpoint
        wait_until(checkpoint.exists, f"{number.name}'s training has something to save")
    for number, process in runs.items():
        process.send_signal(number)
    for number, process in runs.items():
        said, _ = process.communicate(timeout=GENEROUS)
        folder = TrainingFolder(tmp_path / number.name)
        assert process.returncode == 128 + number, said
        assert said.count("stopping, saving ...") == (number != signal.SIGHUP)  # then nobody is there to read it
        assert f"pipenav train --resume {folder.path}" in said.replace("\n", "")
        assert "Traceback" not in said
        load_policy(folder.best)
        load_policy(folder.last)
        require_whole_progress(folder)
        _, config = TrainingFolder.open(folder.path)
        assert config.steps == 10_000_000
        assert not [path for path in folder.path.iterdir() if path.name.startswith(".")]


FORKS = """
import os, sys
import pipenav.learning.callback, pipenav.learning.train  # once for all: this takes longer than what is tested
from pipenav.cli import main

for out in sys.argv[1].split(":"):
    if not (child := os.fork()):
        sys.stdout = sys.stderr
        main(["train", "--out", out, *sys.argv[2:]])
    print(child, flush=True)
    sys.stdin.readline()
"""
"""Starts one training after the other, each after a line that says that the one before has been killed."""


def test_kill_leaves_whole_files(tmp_path: Path) -> None:
    moments = random.Random(0)
    folders = [TrainingFolder(tmp_path / f"run-{i}") for i in range(3)]
    command = [sys.executable, "-c", FORKS, ":".join(str(folder.path) for folder in folders)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with subprocess.Popen([*command, *options(256)], text=True, **pipes) as parent:  # type: ignore[call-overload]
        assert parent.stdin and parent.stdout
        for folder in folders:
            child = int(parent.stdout.readline())
            try:
                wait_until(folder.checkpoint.exists, f"{folder.path.name} is saved")
                time.sleep(moments.uniform(0.0, 1.0))
            finally:
                os.kill(child, signal.SIGKILL)
            parent.stdin.write("next\n")
            parent.stdin.flush()
    for folder in folders:
        load_policy(folder.last)
        if folder.best.exists():
            load_policy(folder.best)
        if folder.progress.exists():
            require_whole_progress(folder)
        opened, config = TrainingFolder.open(folder.path)
        assert train(config, opened, resumed=True, should_stop=lambda: True).stopped
        load_policy(folder.best)
