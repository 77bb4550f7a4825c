"""The search for servos that do not answer where arm.toml has them: at every id and every speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from pipenav.errors import PipenavError
from pipenav_hardware import table
from pipenav_hardware.arm_config import ArmConfig
from pipenav_hardware.dynamixel import Bus

LIKELY_IDS = tuple(range(9))
"""Ids that people give to an arm's servos."""

ALL_IDS = tuple(range(table.ID.high + 1))

PATIENCE = 0.004
"""Latency of an adapter that the search allows for [s]: it asks some thousand times, mostly in vain."""


class Stray(NamedTuple):
    """A servo that is not where arm.toml has it: the speed at which it answers, and its id."""

    baud: int
    id: int


def search(arm: ArmConfig, bus: Bus, missing: int) -> list[Stray]:
    """Servos that arm.toml does not have, until as many are found as are missing.

    What is likely comes first: at every speed the arm's own ids and the first few, then all ids at the arm's speed,
    then all ids at every speed, which takes about a minute.

    Args:
        arm: the arm's description.
        bus: its bus; the speed is the arm's again afterwards.
        missing: number of servos that do not answer.
    """
    found: list[Stray] = []
    try:
        bus.expect(PATIENCE)
        asked: set[Stray] = set()
        unable: set[int] = set()
        for place in _places(arm):
            if place.baud not in unable and place.baud != bus.baud:
                try:
                    bus.open(place.baud)
                except PipenavError:
                    unable.add(place.baud)  # the adapter's business; its other speeds are tried all the same
            if place.baud in unable or place in asked:
                continue
            if bus.ping(place.id).data is not None:
                found.append(place)
            asked.add(place)
            if len(found) == missing:
                break
    finally:
        bus.open(arm.baud)
    return found


def _places(arm: ArmConfig) -> Iterator[Stray]:
    """Places at which a servo may be, the likely ones first; without those of arm.toml."""
    speeds = sorted(table.BAUD_VALUES, key=lambda baud: (baud != arm.baud, -baud))
    likely: Sequence[int] = sorted({*arm.ids, *LIKELY_IDS})
    stages: list[tuple[Sequence[int], Sequence[int]]] = [(speeds, likely), (speeds[:1], ALL_IDS), (speeds[1:], ALL_IDS)]
    for bauds, ids in stages:
        for baud in bauds:
            yield from (Stray(baud, servo) for servo in ids if baud != arm.baud or servo not in arm.ids)
