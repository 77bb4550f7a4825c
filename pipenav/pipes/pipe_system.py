"""Pipes with branches as strands and fittings: what a route with tees and a whole network have in common as solids.

A strand is a row of legs that bends, mitres and reducers join. It runs from one fitting or end to the next. A fitting,
a tee or a cross, is where strands begin and end; its pipes are halves of cylinders from the crossing of their axes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.branch_pipes import reaches
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_legs import Legs


class StrandEnd(NamedTuple):
    """End of a strand.

    Attributes:
        direction: unit vector along the strand's axis, out of it, (3,).
        fitting: number of the fitting there; None for an end of the whole.
        pipe: which of the fitting's pipes the strand is there.
        closed: whether a cap closes it.
    """

    direction: Floats
    fitting: int | None = None
    pipe: int = 0
    closed: bool = False


class Strand(NamedTuple):
    """Legs from one fitting or end to the next, and the two ends."""

    legs: Legs
    start: StrandEnd
    end: StrandEnd


class Fitting(NamedTuple):
    """A tee or a cross.

    Attributes:
        centre: crossing of the axes, (3,) [m].
        axes: unit vectors away from it, to the left and upwards as columns, (pipes, 3, 3).
        radius: radius of each pipe's bore, (pipes,) [m].
    """

    centre: Floats
    axes: Floats
    radius: Floats

    def reach(self, pipe: int, wall: float) -> float:
        """Reach of the other pipes' openings along one pipe, in walls of a thickness [m]."""
        return float(reaches(self.axes[:, :, 0], self.radius + wall)[pipe])


class PipeSystem(NamedTuple):
    """Strands, the fittings that join them, and the wall's thickness [m]."""

    strands: list[Strand]
    fittings: list[Fitting]
    wall: float


def system_of(route: PipeRoute) -> PipeSystem:
    """A route as a system: its own strands in order, then its branches."""
    legs, branches = route.legs, route.branches
    corners = np.flatnonzero(legs.taper == 0).tolist()
    strands, fittings = [], []
    for number, (first, last) in enumerate(zip([-1, *corners], [*corners, len(legs.bend)], strict=True)):
        ends = [StrandEnd(-legs.axes[first + 1, :, 0]), StrandEnd(legs.axes[last, :, 0], closed=route.capped)]
        if number > 0:
            ends[0] = ends[0]._replace(fitting=number - 1, pipe=1)
        if number < len(corners):
            ends[1] = ends[1]._replace(fitting=number, pipe=0, closed=False)
        strands.append(Strand(legs.part(first + 1, last), *ends))
    for number, corner in enumerate(corners):
        here = np.flatnonzero(branches.corner == corner)
        before = legs.axes[corner] * np.array([-1.0, 1.0, 1.0])  # its left and up stay: bores know no handedness
        axes = np.array([before, legs.axes[corner + 1], *branches.axes[here]])
        radius = np.concatenate([legs.radius[corner : corner + 2], branches.radius[here]])
        fittings.append(Fitting(legs.start[corner + 1], axes, radius))
        for pipe, b in enumerate(here.tolist(), 2):
            out = branches.axes[b, :, 0]
            stub = straight_leg(branches.start[b], branches.axes[b], branches.length[b], branches.radius[b])
            far = StrandEnd(out, closed=bool(branches.closed[b]))
            strands.append(Strand(stub, StrandEnd(-out, number, pipe), far))
    return PipeSystem(strands, fittings, route.wall)


def straight_leg(start: Floats, axes: Floats, length: float, radius: float) -> Legs:
    """A single leg without corners.

    Args:
        start: point where it begins, (3,) [m].
        axes: unit vectors along it, to its left and upwards as columns, (3, 3).
        length: its length [m].
        radius: radius of its bore [m].
    """
    none = np.zeros(0)
    single = np.array([length]), start[None], axes[None]
    return Legs(*single, none, none, np.zeros((0, 3)), none, none, np.array([radius]), none)


def stations(legs: Legs, outside: float, around: Floats, tolerance: float, to_corner: float = 1.0) -> Floats:
    """Lines along a strand's surface, so much wider than its bore, (lines, stations, 3) [m].

    Args:
        legs: the strand's legs.
        outside: distance from the bore [m].
        around: angles of the lines, (lines,) [rad].
        tolerance: largest distance of a bend's outermost line from its chords [m].
        to_corner: factor on the radius.
    """
    widest = float(legs.radius.max()) + outside
    chords = legs.chords(widest, tolerance)
    return legs.lines((legs.radius + outside)[None] * to_corner, around, chords)


def polygon_angles(facets: int) -> Floats:
    """Angles of the corners of a regular polygon, whose first side faces the left, (facets,) [rad]."""
    return np.asarray((np.arange(facets) - 0.5) * 2 * math.pi / facets)
