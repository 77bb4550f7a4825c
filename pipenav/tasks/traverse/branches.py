"""Points of n robots in branches of their pipes: there a robot has taken an exit that its route does not."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.pipes.branch_pipes import reaches_of
from pipenav.pipes.centre_lines import CentreLines
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route import as_route

FALLEN_OUT = 0.5
"""Distance from the route's centre line, straight from corner to corner, past the widest bend: a robot that far away
has fallen out of an open end [m]."""


class Branches(NamedTuple):
    """The branches of n pipes, at most b of each; rows that a pipe leaves over hold no point.

    Attributes:
        start: crossings of the axes, (n, b, 3) [m].
        direction: unit vectors along the branches, (n, b, 3).
        mouth: distance along each branch from which it lies outside the pipes of the route, (n, b) [m].
        length: distance along each branch at which it ends, (n, b) [m].
        radius: radii of the bores, negative in a row that is left over, (n, b) [m].
    """

    start: Floats
    direction: Floats
    mouth: Floats
    length: Floats
    radius: Floats

    @classmethod
    def of(cls, pipes: Sequence[Pipe]) -> Branches:
        """The branches of some pipes."""
        found = [_branches(pipe) for pipe in pipes]
        most = max(one.radius.shape[1] for one in found)
        return cls(*map(np.concatenate, zip(*(one._with_room(most) for one in found), strict=True)))

    def put(self, rows: Ints, others: Branches) -> Branches:
        """These branches with those of some rows, (k,), replaced by others, of k pipes."""
        most = max(self.radius.shape[1], others.radius.shape[1])
        mine = self._with_room(most)
        for own, given in zip(mine, others._with_room(most), strict=True):
            own[rows] = given
        return mine

    def _with_room(self, most: int) -> Branches:
        more = most - self.radius.shape[1]
        if not more:
            return self
        start, direction = (np.pad(field, [(0, 0), (0, more), (0, 0)]) for field in self[:2])
        mouth, length = (np.pad(field, [(0, 0), (0, more)]) for field in self[2:4])
        radius = np.pad(self.radius, [(0, 0), (0, more)], constant_values=-1.0)
        return Branches(start, direction, mouth, length, radius)

    def contain(self, points: Floats, lines: CentreLines) -> Flags:
        """Flags of points in a branch of their pipe, beyond its mouth, or fallen out of its end: (n, m).

        Args:
            points: m points in the frame of each pipe, (n, m, 2) in the plane or (n, m, 3) [m].
            lines: centre lines of the pipes, in as many dimensions.
        """
        if not self.radius.shape[1]:
            return np.zeros(points.shape[:2], bool)
        dimensions = points.shape[-1]
        away = points[:, :, None] - self.start[:, None, :, :dimensions]  # (n, m, b, dimensions)
        along = (away * self.direction[:, None, :, :dimensions]).sum(axis=-1)
        off = np.sqrt(np.maximum((away**2).sum(axis=-1) - along**2, 0.0))
        in_line = (along >= self.mouth[:, None]) & (off <= self.radius[:, None])
        within = in_line & (along <= self.length[:, None])
        found = np.asarray(within.any(axis=-1))
        if (in_line & ~within).any():  # another leg of the route may lie there
            located = lines.locate(points)
            from_axis = np.sqrt((located.local[..., 1:] ** 2).sum(axis=-1))
            found |= in_line.any(axis=-1) & (np.hypot(from_axis, located.beyond) > FALLEN_OUT)
        return found


_NONE = Branches(*np.zeros((2, 1, 0, 3)), *np.zeros((3, 1, 0)))


@lru_cache(maxsize=4096)
def _branches(pipe: Pipe) -> Branches:
    """The branches of one pipe, n = 1; none of a pipe without tees and crosses."""
    if pipe.corner is not None and not pipe.corner.branches:
        return _NONE  # bends too tight for a route among them
    route = as_route(pipe)
    found, bores = route.branches, 2 * route.legs.radius
    if not len(found.radius):
        return _NONE
    mouths = [  # a leg begins with a disc about the crossing, which reaches into a branch by its radius at most
        np.maximum(reaches_of(corner, float(bores[i]), float(bores[i + 1]))[2:], bores[i : i + 2].max() / 2)
        for i, corner in enumerate(route.corners)
        if corner.branches
    ]
    mouth = np.concatenate(mouths)
    return Branches(found.start[None], found.axes[None, :, :, 0], mouth[None], found.length[None], found.radius[None])
