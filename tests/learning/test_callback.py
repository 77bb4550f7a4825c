"""Checks, savings and stops of a training, and the end of one whose update leaves the finite numbers."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import pytest
from helpers.tiny_training import tiny

from pipenav.learning import callback as module
from pipenav.learning.callback import TrainingCallback
from pipenav.learning.config import TrainConfig
from pipenav.learning.divergence import TrainingDiverged
from pipenav.learning.train import train
from pipenav.learning.training_folder import TrainingFolder
from pipenav.policies.policy import load_policy


def new_folder(path: Path, config: TrainConfig) -> TrainingFolder:
    return TrainingFolder.create(path, config, "pipenav train")


@pytest.mark.slow
@pytest.mark.parametrize(("rate", "every"), [(1e3, 1024), (1e20, 100_000), (1e30, 256), (1e38, 256), (1e300, 100_000)])
def test_an_update_that_leaves_the_finite_numbers_is_said_and_kept(rate: float, every: int, tmp_path: Path) -> None:
    config = tiny(**{"learner.learning_rate": rate, "check.every": every})
    folder = new_folder(tmp_path / "run", config)
    try:
        train(config, folder)
    except TrainingDiverged as error:
        assert "at a value that is not finite" in str(error)
        assert json.loads(folder.diverged.read_text(encoding="utf-8"))["steps"] > 0
    else:
        assert rate < 1e20
    load_policy(folder.last)


class Clock:
    """Time that passes only as it is set."""

    def __init__(self) -> None:
        self.now = 0.0

    def monotonic(self) -> float:
        return self.now


@pytest.mark.slow
def test_a_long_check_does_not_keep_the_training_from_saving(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    clock, saved = Clock(), [0.0]
    save, during_check = TrainingCallback.save, TrainingCallback._during_check

    def counted(self: TrainingCallback) -> None:
        save(self)
        saved.append(clock.now)

    def slow(self: TrainingCallback) -> None:
        clock.now += 3.0
        during_check(self)

    monkeypatch.setattr(module, "time", clock)
    monkeypatch.setattr(TrainingCallback, "save", counted)
    monkeypatch.setattr(TrainingCallback, "_during_check", slow)
    config = tiny(**{"steps": 512, "check.every": 256})
    train(config, new_folder(tmp_path / "run", config))
    assert saved[-1] > 60.0
    assert max(b - a for a, b in pairwise(saved)) <= module.SAVE_EVERY_S + 3.0


@pytest.mark.slow
def test_a_stop_gives_up_a_check_and_saves(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    checking: list[bool] = []
    during_check = TrainingCallback._during_check

    def noted(self: TrainingCallback) -> None:
        checking.append(True)
        during_check(self)

    monkeypatch.setattr(TrainingCallback, "_during_check", noted)
    config = tiny(**{"check.every": 512})
    folder = new_folder(tmp_path / "run", config)
    summary = train(config, folder, should_stop=lambda: len(checking) > 3)
    assert summary.stopped
    assert summary.steps < 1024
    assert len(checking) == 4
    load_policy(folder.best)
    opened, _ = TrainingFolder.open(folder.path)
    again = train(config, opened, resumed=True)
    assert not again.stopped
    assert again.check_success >= 0  # a policy that was never checked is no best one
