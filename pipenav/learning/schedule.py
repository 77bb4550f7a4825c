"""The schedules of learning rate and exploration noise, which fall over a training."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pipenav.learning.config import TrainConfig

LEARNING_RATE_FLOOR = 0.05
"""Share of the learning rate that is left at the end."""

NOISE_SETTLED = 0.9
"""Share of the steps after which the exploration noise stays at its last value."""


class LearningRate:
    """A learning rate that falls linearly to `LEARNING_RATE_FLOOR` of its start.

    It is a class of a module, not a closure: policy files name it, and would otherwise hold its code.
    """

    def __init__(self, start: float) -> None:
        self.start = start

    def __call__(self, remaining: float) -> float:
        return self.start * max(remaining, LEARNING_RATE_FLOOR)


def noise_at(config: TrainConfig, steps: int) -> float:
    """Standard deviation of the exploration after so many control steps."""
    done = min(steps / (NOISE_SETTLED * config.steps), 1.0)
    return config.learner.noise_start + (config.learner.noise_stop - config.learner.noise_start) * done
