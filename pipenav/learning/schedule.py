"""How the learning rate falls over a training."""

from __future__ import annotations

LEARNING_RATE_FLOOR = 0.05
"""Share of the learning rate that is left at the end."""


class LearningRate:
    """A learning rate that falls linearly to `LEARNING_RATE_FLOOR` of its start.

    It is a class of a module, not a closure: policy files name it, and would otherwise hold its code.
    """

    def __init__(self, start: float) -> None:
        self.start = start

    def __call__(self, remaining: float) -> float:
        return self.start * max(remaining, LEARNING_RATE_FLOOR)
