"""Stages of a passage, outcomes of an episode, and which outcome wins where several hold."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum, StrEnum

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags


class PassageStage(StrEnum):
    """A part of a robot's passage through a pipe."""

    LOCATE = "locate"
    """The robot finds a target beyond the corner from its own laser (approach I)."""
    REACH = "reach"
    """The front half brings its tip to the target."""
    REAR = "rear"
    """The rear half follows: the front half's motion, mirrored and reversed (approach II)."""
    TRAVERSE = "traverse"
    """A whole robot passes in one motion."""


class Outcome(IntEnum):
    """State of an episode: still running, or why it ended."""

    RUNNING = 0
    """The episode goes on."""
    REACHED = 1
    """The stage is done: the target is located or reached, or the tail is through."""
    LIMIT = 2
    """A joint came to its limit; a robot that traverses is stuck besides."""
    PENETRATION = 3
    """The robot sank into the wall by more than the task allows."""
    TIMEOUT = 4
    """The time was up."""
    MISPLACED = 5
    """The target was located, but in a wrong place."""
    SLID_BACK = 6
    """The robot fell too far behind its furthest distance along the pipe."""
    JAM = 7
    """The robot is stuck, and its wheels stand."""
    SLIP = 8
    """The robot is stuck, and its wheels spin."""
    FOLD = 9
    """The robot is stuck with its tip behind its middle."""
    WRONG_EXIT = 10
    """The robot's middle is in a branch that its route does not take, or it is stuck with its tip in one."""

    FORCE = 11
    """The wall pressed on a link harder than an evaluation allows."""

    @property
    def label(self) -> str:
        """Name of the outcome in files, tables and pictures."""
        return self.name.lower()


LADDER = (
    Outcome.TIMEOUT,
    Outcome.JAM,
    Outcome.SLIP,
    Outcome.MISPLACED,
    Outcome.REACHED,
    Outcome.LIMIT,
    Outcome.FOLD,
    Outcome.SLID_BACK,
    Outcome.WRONG_EXIT,
    Outcome.FORCE,
    Outcome.PENETRATION,
)
"""Outcomes from the weakest to the strongest: where several hold in one control step, the strongest counts."""


def strongest_outcome(n: int, holds: Mapping[Outcome, Flags]) -> NDArray[np.int8]:
    """Outcome of each of n episodes by `LADDER`, (n,); `RUNNING` where none holds.

    Args:
        n: number of episodes.
        holds: for each outcome that can hold, the episodes in which it does, (n,); the others hold nowhere.
    """
    outcome = np.full(n, Outcome.RUNNING.value, np.int8)
    for candidate in LADDER:
        if candidate in holds:
            outcome[holds[candidate]] = candidate.value
    return outcome
