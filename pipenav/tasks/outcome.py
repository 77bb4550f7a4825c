"""How an episode stands or ended."""

from __future__ import annotations

from enum import IntEnum


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
        return self.name.lower()
