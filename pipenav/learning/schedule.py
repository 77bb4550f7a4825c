"""The schedules of learning rate and exploration noise, which fall over a training or over part of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from pipenav.learning.config import LearnerConfig

LEARNING_RATE_FLOOR = 0.05
"""Share of the learning rate that is left at the end."""

NOISE_SETTLED = 0.9
"""Share of the steps after which the exploration noise stays at its last value."""


class Schedule(NamedTuple):
    """Part of a training over which learning rate and noise fall, from one number of control steps to another."""

    begin: int
    end: int


class LearningRate:
    """A learning rate that falls linearly to `LEARNING_RATE_FLOOR` of its start.

    It is a class of a module, not a closure: policy files name it, and would otherwise hold its code.

    Args:
        start: learning rate at the start of the schedule.
        schedule: steps over which it falls; None: those of the learner's whole training.
        until: steps at which the learner's training ends.
    """

    offset, slope = 0.0, 1.0
    """Line from the share of the training that remains to that of the schedule; older policy files lack both."""

    def __init__(self, start: float, schedule: Schedule | None = None, until: int = 0) -> None:
        self.start = start
        if schedule is not None:
            length = schedule.end - schedule.begin
            self.offset, self.slope = (schedule.end - until) / length, until / length

    def __call__(self, remaining: float) -> float:
        return self.start * max(self.offset + self.slope * remaining, LEARNING_RATE_FLOOR)


def noise_at(learner: LearnerConfig, schedule: Schedule, steps: int) -> float:
    """Standard deviation of the exploration after so many control steps."""
    done = min((steps - schedule.begin) / (NOISE_SETTLED * (schedule.end - schedule.begin)), 1.0)
    return learner.noise_start + (learner.noise_stop - learner.noise_start) * done
