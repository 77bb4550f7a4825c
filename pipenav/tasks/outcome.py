"""How an episode stands or ended, the parts of a passage, and which outcome wins where several hold."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum, StrEnum

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags


class PassageStage(StrEnum):
    """A part of a passage: locate a target, reach it with the front half, bring the rear half after; or all in one."""

    LOCATE = "locate"
    REACH = "reach"
    REAR = "rear"
    TRAVERSE = "traverse"


class Outcome(IntEnum):
    """How an episode stands or ended."""

    RUNNING = 0
    REACHED = 1
    LIMIT = 2
    PENETRATION = 3
    TIMEOUT = 4
    MISPLACED = 5
    SLID_BACK = 6
    JAM = 7
    SLIP = 8
    FOLD = 9

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
    Outcome.PENETRATION,
)
"""Outcomes from the weakest to the strongest: where several hold in one control step, the later one counts."""


def decide(n: int, holds: Mapping[Outcome, Flags]) -> NDArray[np.int8]:
    """The outcome of n episodes, an `Outcome` each, (n,); `RUNNING` where nothing holds.

    Args:
        n: number of episodes.
        holds: for each outcome that may hold, in which episodes it does, (n,).
    """
    outcome = np.full(n, Outcome.RUNNING.value, np.int8)
    for candidate in LADDER:
        if candidate in holds:
            outcome[holds[candidate]] = candidate.value
    return outcome
