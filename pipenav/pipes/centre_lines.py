"""Centre lines of n pipes at once, in plane or space: the leg that a point belongs to, and its distance along."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints

if TYPE_CHECKING:
    from pipenav.pipes.pipe import Pipe


STRAIGHT = 1e-6
"""Difference of 1 and the cosine of a turn that counts as none: less than 0.1 deg."""


class LegCoordinates(NamedTuple):
    """Points of n pipes' frames, m of each, seen from the legs that they belong to.

    Attributes:
        leg: leg of each point, counted from 0, (n, m).
        local: position from the leg's start: along it, to its left and, in space, upwards, (n, m, dimensions) [m].
        beyond: distance past an open end, 0 for most points, (n, m) [m].
    """

    leg: Ints
    local: Floats
    beyond: Floats


class CentreLines(NamedTuple):
    """The centre lines of n pipes of at most `legs` straight legs, in the plane (dimensions 2) or in space (3).

    Rows that a shorter pipe leaves over are 0. A row of `mitre`, `end` and `turn_sign` describes the corner at the
    leg's end; for the last leg, which ends in no corner, it is 0.

    Attributes:
        start: points where the legs begin, (n, legs, dimensions) [m].
        axes: unit vectors along the leg, to its left and upwards as columns, (n, legs, dimensions, dimensions).
        mitre: normals of the planes that part each leg from the next, forwards, (n, legs, dimensions); the planes
            halve the angle between the legs, whatever fitting joins them.
        offset: distance along the centre line at which each leg begins; 0 is the first corner, (n, legs) [m].
        low, high: the part of the centre line that is the leg's, from its start, (n, legs) [m].
        ahead, behind: distance from the leg's start to an open end; far away where there is none, (n, legs) [m].
        end: distance along the centre line at which each corner's inner wall stops bending, (n, legs) [m].
        turn_sign: +1 for each corner that turns left, -1 for a right one, 0 for all in space, (n, legs).
        radius: radius of the bore, (n, legs) [m].
    """

    start: Floats
    axes: Floats
    mitre: Floats
    offset: Floats
    low: Floats
    high: Floats
    ahead: Floats
    behind: Floats
    end: Floats
    turn_sign: Floats
    radius: Floats

    @classmethod
    def of(cls, pipes: Sequence[Pipe], dimensions: int = 2) -> CentreLines:
        """The centre lines of some pipes.

        Args:
            pipes: n pipes.
            dimensions: 2 for the plane, 3 for space.

        Raises:
            PipenavError: a pipe leaves the plane, and 2 dimensions were asked for.
        """
        lines = [_centre_line(pipe, dimensions) for pipe in pipes]
        legs = max(line.offset.shape[1] for line in lines)
        return cls(*map(np.concatenate, zip(*(line._with_room(legs) for line in lines), strict=True)))

    def put(self, rows: Ints, lines: CentreLines) -> CentreLines:
        """These centre lines with some rows replaced, in place where there is room for all legs."""
        legs = max(self.offset.shape[1], lines.offset.shape[1])
        mine = self._with_room(legs)
        for own, given in zip(mine, lines._with_room(legs), strict=True):
            own[rows] = given
        return mine

    def _with_room(self, legs: int) -> CentreLines:
        """The same centre lines with rows for so many legs."""
        more = legs - self.offset.shape[1]
        if not more:
            return self
        return CentreLines(*(np.pad(field, [(0, 0), (0, more), *[(0, 0)] * (field.ndim - 2)]) for field in self))

    @property
    def corners(self) -> Ints:
        """Number of corners of each pipe in the plane, (n,)."""
        return np.asarray(np.count_nonzero(self.turn_sign, axis=1))

    def turn_signs(self, corner: Ints) -> Floats:
        """Turns around one corner of each pipe: +1 or -1 for the corner, the one before and the one after; (n, 3).

        Args:
            corner: corner of each pipe, counted from 0, (n,). Where the pipe has no corner the turn is 0.
        """
        around = np.pad(self.turn_sign, [(0, 0), (1, 0)])  # the last leg's 0 stands behind the last corner
        return np.asarray(np.take_along_axis(around, corner[:, None] + np.array([1, 0, 2]), axis=1))

    def straight_on(self, corner: Ints) -> Floats:
        """1 where the pipe goes straight on at one corner of each, else 0, (n,).

        Args:
            corner: corner of each pipe, counted from 0, (n,).
        """
        every, direction = np.arange(len(corner)), self.axes[..., 0]
        following = np.minimum(corner + 1, direction.shape[1] - 1)
        parallel = (direction[every, corner] * direction[every, following]).sum(axis=-1)
        return np.where(parallel > 1 - STRAIGHT, 1.0, 0.0)

    @property
    def turned(self) -> Floats:
        """Sum of the turns before each leg, all counted as positive, (n, legs) [rad]; of no use in rows left over."""
        direction = self.axes[..., 0]
        turns = np.arccos(np.clip((direction[:, 1:] * direction[:, :-1]).sum(axis=-1), -1.0, 1.0))
        return np.pad(np.cumsum(turns, axis=1), [(0, 0), (1, 0)])

    def locate(self, points: Floats) -> LegCoordinates:
        """Legs of points (n, m, dimensions) [m], and the points' coordinates in them.

        A point belongs to the leg in whose bore it lies, and where it lies in none to the nearest of those between
        whose mitres it lies. The first and the last leg have one mitre, and go on past their open ends. A point in a
        mitre belongs to the leg before.
        """
        from_start = points[:, :, None] - self.start[:, None]  # (n, m, legs, dimensions)
        axes = np.moveaxis(self.axes[:, None], -1, 0)  # (dimensions, n, 1, legs, dimensions)
        local = [(from_start * axis).sum(axis=-1) for axis in axes]  # (n, m, legs) each
        off_axis = np.abs(local[1]) if len(local) == 2 else np.hypot(local[1], local[2])
        from_corner = points[:, :, None] - self.start[:, None, 1:]
        past = (from_corner * self.mitre[:, None, :-1]).sum(axis=-1) > 0  # (n, m, legs - 1)
        always = np.ones_like(past[..., :1])
        between = np.concatenate([always, past], axis=-1) & np.concatenate([~past, always], axis=-1)
        beyond = np.maximum(np.maximum(self.behind[:, None] - local[0], local[0] - self.ahead[:, None]), 0.0)
        in_bore = (off_axis <= self.radius[:, None]) & (beyond == 0)
        away = np.where(between, np.where(in_bore, 0.0, np.hypot(off_axis, beyond)), np.inf)
        leg = away.argmin(axis=-1)  # (n, m)

        def in_leg(values: Floats) -> Floats:
            return np.asarray(np.take_along_axis(values, leg[..., None], axis=-1)[..., 0])

        return LegCoordinates(leg, np.stack([in_leg(values) for values in local], axis=-1), in_leg(beyond))

    def distance(self, points: Floats) -> Floats:
        """Distance along the centre line of points (n, m, dimensions) [m], 0 at the first corner: (n, m) [m].

        A point counts to the nearest point of its leg's part of the centre line, which goes on past the open ends. So
        the distance jumps where a point passes a mitre by its inner edge, and rests where it passes farther out.
        """
        leg, local, _ = self.locate(points)
        rows = np.arange(len(leg))[:, None]
        reached = np.clip(local[..., 0], self.low[rows, leg], self.high[rows, leg])
        return np.asarray(self.offset[rows, leg] + reached)


@lru_cache(maxsize=4096)  # every pipe of the largest shipped training set
def _centre_line(pipe: Pipe, dimensions: int) -> CentreLines:
    """The centre line of one pipe, n = 1."""
    if dimensions == 2:
        _ = pipe.segments  # raises where the pipe leaves the plane
    start, axes, length, radius = pipe.leg_frames
    legs, d = len(length), dimensions
    direction = axes[:, :d, 0]
    first, last = np.arange(legs) == 0, np.arange(legs) == legs - 1
    mitre = direction[:-1] + direction[1:]
    turn_signs = pipe.turn_signs if pipe.planar else np.zeros(legs - 1)
    return CentreLines(
        start=start[None, :, :d],
        axes=axes[None, :, :d, :d],
        mitre=np.concatenate([mitre, np.zeros((1, d))])[None],
        offset=(np.cumsum(length) - length - length[0])[None],
        low=np.where(first, -np.inf, 0.0)[None],
        high=np.where(last, np.inf, length)[None],
        ahead=np.where(last, length, np.inf)[None],
        behind=np.where(first, 0.0, -np.inf)[None],
        end=np.append(np.cumsum(length)[:-1] - length[0] + pipe.inner_edges, 0.0)[None],
        turn_sign=np.append(turn_signs, 0.0)[None],
        radius=radius[None],
    )
