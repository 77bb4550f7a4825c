"""A training that takes a second."""

from __future__ import annotations

from typing import Any

from pipenav.learning.config import TrainConfig, load_config

TINY = {
    "pipes": ["d=100,angle=90"],
    "learner.robots": 16,
    "learner.rollout_steps": 16,
    "learner.batch_size": 64,
    "learner.epochs": 2,
    "check.episodes": 4,
}


def tiny(**more: Any) -> TrainConfig:
    """Settings of a training of 2,048 steps, or others."""
    return load_config(options={**TINY, "steps": 2048, **more})
