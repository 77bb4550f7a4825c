"""Pipes with branches as strands and fittings: what a route with tees and a whole network have in common as solids.

A strand is a row of legs that bends, mitres and reducers join. It runs from one fitting or end to the next. A fitting,
a tee or a cross, is where strands begin and end; its pipes are halves of cylinders from the crossing of their axes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.branch_pipes import reaches
from pipenav.pipes.network import PipeNetwork, first_axes
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


def network_system(network: PipeNetwork) -> PipeSystem:
    """A whole network as a system."""
    names = [name for name in network.nodes if len(network.pipes_at(name)) > 2]
    pipes: dict[str, list[_FittingPipe]] = {name: [] for name in names}
    strands = []
    for way in network.strands:
        legs = _placed(network, way)
        ends = []
        for name, leg, sign in ((way[0], 0, -1.0), (way[-1], len(way) - 2, 1.0)):
            end = StrandEnd(sign * legs.axes[leg, :, 0], closed=network.nodes[name].capped)
            if name in pipes:
                end = end._replace(fitting=names.index(name), pipe=len(pipes[name]))
                pipes[name].append(_FittingPipe(legs.axes[leg] * np.array([-sign, 1.0, 1.0]), float(legs.radius[leg])))
            ends.append(end)
        strands.append(Strand(legs, *ends))
    fittings = [
        Fitting(
            np.array(network.nodes[name].position),
            np.array([pipe.axes for pipe in found]),
            np.array([pipe.radius for pipe in found]),
        )
        for name, found in pipes.items()
    ]
    return PipeSystem(strands, fittings, network.wall)


class _FittingPipe(NamedTuple):
    """A pipe of a fitting: its axes as columns, (3, 3), and the radius of its bore [m]."""

    axes: Floats
    radius: float


def _placed(network: PipeNetwork, way: Sequence[str]) -> Legs:
    """The legs of a way, in the network's frame."""
    start, second = (np.array(network.nodes[name].position) for name in way[:2])
    length = float(np.linalg.norm(second - start))
    frame = first_axes((second - start) / length)
    if len(way) == 2:
        return straight_leg(start, frame, length, network.pipe_between(*way).diameter / 2)
    legs = network.laid(way).legs
    return legs._replace(start=second + legs.start @ frame.T, axes=frame @ legs.axes, mitre=legs.mitre @ frame.T)


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


def stations(legs: Legs, outside: float, around: Floats, tolerance: float) -> Floats:
    """Lines along a strand's surface, so much wider than its bore, (lines, stations, 3) [m].

    Args:
        legs: the strand's legs.
        outside: distance from the bore [m].
        around: angles of the lines, (lines,) [rad].
        tolerance: largest distance of a bend's outermost line from its chords [m].
    """
    widest = float(legs.radius.max()) + outside
    chords = legs.chords(widest, tolerance)
    return legs.lines((legs.radius + outside)[None], around, chords)


class Polygon(NamedTuple):
    """Section of a bore of flat sides.

    Attributes:
        sides: number of sides.
        turned: angle from where a side faces the left of the first leg, as a share of the angle of a side.
        inside: distance by which the middles of the sides lie inside the round bore, as a share of its radius.
    """

    sides: int
    turned: float = 0.0
    inside: float = 0.0

    @property
    def corners(self) -> Floats:
        """Angles of its corners around the axis, (sides,) [rad]; the first side lies between the first two."""
        return np.asarray((np.arange(self.sides) - 0.5 + self.turned) * 2 * math.pi / self.sides)

    @property
    def middles(self) -> Floats:
        """Angles of the middles of its sides, (sides,) [rad]."""
        return np.asarray((np.arange(self.sides) + self.turned) * 2 * math.pi / self.sides)

    @property
    def to_corner(self) -> float:
        """Distance of its corners from the axis, in radii of the bore."""
        return (1 - self.inside) / math.cos(math.pi / self.sides)


def bend_chords(legs: Legs, deviation: float) -> list[int]:
    """Number of chords of each corner, which leave the bend by a share of the bore's radius at most."""
    return legs.chords(float(legs.radius.max()), deviation * float(legs.radius.min()))


def leg_rings(legs: Legs, polygon: Polygon, thickness: float, deviation: float) -> Floats:
    """Sections of the prisms behind the sides of a polygon around legs, (stations, sides, 4, 3) [m].

    The four corners lie on the bore and behind it, each time around the section. Walls end before the axis of the
    tightest bend, so they can be thinner than asked.

    Args:
        legs: the legs.
        polygon: section of the bore.
        thickness: thickness of the wall [m].
        deviation: see `bend_chords`.
    """
    bent = legs.bend > 0
    before_axis = 0.99 / polygon.to_corner * legs.bend[bent] - legs.radius[:-1][bent]  # (bends,)
    outside = legs.radius + min([thickness, *before_axis])
    chords = bend_chords(legs, deviation)
    near, far = (legs.lines(r[None] * polygon.to_corner, polygon.corners, chords) for r in (legs.radius, outside))
    ring = np.stack([near, np.roll(near, -1, axis=0), np.roll(far, -1, axis=0), far], axis=2)  # (sides, stations, 4, 3)
    return np.asarray(ring.swapaxes(0, 1))
