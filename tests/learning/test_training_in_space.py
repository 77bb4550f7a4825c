"""Real, short trainings in routes that leave the plane."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.tiny_training import TINY, weights

from pipenav.learning.config import TrainConfig, load_config
from pipenav.learning.train import train
from pipenav.learning.training_folder import TrainingFolder
from pipenav.policies.policy import load_policy

pytestmark = pytest.mark.slow

MIXED = ["runs-rolled-train:1", "runs-train:1", "d=90,angle=90"]
"""A route in space, one in the plane and a corner."""


def config(**more: Any) -> TrainConfig:
    """Settings of a training of 256 steps in space, or others; nothing can be passed in its time."""
    short = {"pipes": MIXED, "steps": 256, "check.episodes": 3, "task.max_steps": 4}
    return load_config("pirate-strong-gravity", options={**TINY, **short, **more})


def trained(path: Path, **more: Any) -> TrainingFolder:
    folder = TrainingFolder.create(path, config(**more), "pipenav train")
    train(config(**more), folder)
    return folder


def test_a_training_in_space_is_saved_loaded_and_resumed(tmp_path: Path) -> None:
    folder = trained(tmp_path / "run")
    header = load_policy(folder.best).header
    assert header.train_pipes == tuple(MIXED)
    assert header.task == config().task
    before = weights(folder.last)
    outcome = train(config(steps=512), TrainingFolder.open(folder.path).folder, resumed=True)
    assert outcome.steps == 512
    assert weights(folder.last) != before


def test_a_training_in_space_gives_the_same_weights_on_any_number_of_threads(tmp_path: Path) -> None:
    one, many = (trained(tmp_path / str(threads), **{"options.threads": threads}) for threads in (1, 3))
    assert weights(one.last) == weights(many.last)
