"""A training that takes a second, and the weights that come of it."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import safetensors.numpy

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


def weights(path: Path) -> dict[str, list[float]]:
    """The actor's tensors, to the bit."""
    with zipfile.ZipFile(path) as policy:
        tensors = safetensors.numpy.load(policy.read("policy.safetensors"))
    return {name: values.ravel().tolist() for name, values in tensors.items()}
