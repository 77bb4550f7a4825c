"""An S-bend: the same corner twice, first to one side, then to the other."""

from __future__ import annotations

import math
from typing import Literal

from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import CornerSetFile
from pipenav.pipes.pipe import Turn
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import shortest_straights
from pipenav.pipes.route_corner import Corner
from pipenav.units import m_to_mm, mm_to_m


class SBendSetFile(CornerSetFile):
    """A set of S-bends as TOML: one of every corner of the set."""

    s_bend: Literal[True]
    between_mm: float | None = None

    def draw(self) -> list[PipeRoute]:
        """The S-bends, in the order of their corners."""
        return [s_bend(corner, self.between_mm) for corner in self.make()]


def s_bend(corner: PipeCorner, between_mm: float | None = None) -> PipeRoute:
    """The S-bend of a corner: its legs are the first and the last straight.

    Args:
        corner: first corner; the second one turns to the other side.
        between_mm: length of the straight between the two, from corner to corner; by default the shortest in whole mm.

    Raises:
        OutOfRange: the straight is too short for the corners, or the bend is tighter than a route allows.
    """
    other: Turn = "right" if corner.turn == "left" else "left"
    corners = tuple(
        Corner(angle=corner.angle, turn=turn, bend_radius=corner.bend_radius) for turn in (corner.turn, other)
    )
    between = mm_to_m(between_mm) if between_mm is not None else _shortest_between(corner, corners)
    straights = (corner.leg, between, corner.leg)
    return PipeRoute(diameter=corner.diameter, corners=corners, straights=straights, wall=corner.wall)


def _shortest_between(corner: PipeCorner, corners: tuple[Corner, ...]) -> float:
    return mm_to_m(math.ceil(m_to_mm(shortest_straights(corner.diameter, corners, corner.wall)[1]) - 1e-6))
