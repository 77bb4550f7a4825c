"""Motions of an arm found on lattices of headings: the way with most room on a coarse one, then finer ones around it.

Free slides of given headings are one interval, so a motion is a way through headings whose interval is not empty. The
difference of its ends, the room, is negative where there is none; coarse lattices may lead through such headings if a
finer one finds a way around them.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.certify.arm import ArmSpans, configuration
from pipenav.certify.motion_check import check_by_distance, check_by_shapely
from pipenav.certify.slide_interval import Interval

COARSE = math.radians(12.0)
"""Step of the lattice over all headings [rad]."""

HALVED = 2
"""Number of times that the step of the lattice over all headings is halved where it has no way."""

FINEST = math.radians(0.1)
"""Step below which no finer lattice is laid around a way [rad]."""

BEYOND = math.radians(50.0)
"""Angle by which headings may lie outside of those of the two legs [rad]."""

DENSE = math.radians(0.75)
"""Largest change of a heading between two waypoints [rad]."""

SLACK = 0.15
"""Room that may be missing at a point of a lattice, for its step [m/rad]: less than the room changes within it."""

WIDE = 0.005
"""Room above which more of it makes a way no better, and which slides keep from the ends of their interval [m]."""

WIDEST, MISSING = 0.05, 1e4
"""Length of a way per step, what room and missing room, in units of `WIDE`, are divided into and multiplied by."""

AROUND = (3, 3, 2)
"""Steps of the finer lattice around a way, at its first halvings and at all others."""


def arm_path(spans: ArmSpans) -> Floats | None:
    """A motion from the start to a target that both tests find free; None where none was found.

    Args:
        spans: free slides of the arm, with the start and the targets.

    Returns:
        Configurations in the robot's own frame, (rows, joints).
    """
    every = _Lattice.over_all(spans)
    for halved in range(HALVED + 1):
        if not len(every.place):  # a part is wider than the pipe at any heading
            return None
        if halved:
            every = every.finer(spans, every.place, 1)
        if (motion := _refined(spans, every)) is not None:
            return motion
    return None


def _refined(spans: ArmSpans, lattice: _Lattice) -> Floats | None:
    """A motion along the way through a lattice, or along one through finer lattices around it."""
    for halvings in itertools.count():
        way = lattice.way(spans)
        if way is None:
            return None
        points = lattice.place[way]
        if (motion := _motion(spans, np.asarray(points * lattice.step))) is not None:
            return motion
        if lattice.step < 2 * FINEST:
            return None
        around = AROUND[min(halvings, len(AROUND) - 1)]
        lattice = lattice.finer(spans, np.concatenate([points, (points[:-1] + points[1:]) / 2]), around)
    return None


class _Lattice(NamedTuple):
    """Points of a lattice of headings.

    Attributes:
        step: distance of its points along each axis [rad].
        place: whole numbers of steps, (n, axes), in the order of their keys.
        free: interval of free slides, upside down where there is none, (n,) each [m].
        goal: whether a target can be reached with these headings, (n,).
    """

    step: float
    place: Ints
    free: Interval
    goal: Flags

    @classmethod
    def over_all(cls, spans: ArmSpans) -> _Lattice:
        """The points between both legs' headings and somewhat beyond."""
        low, high = math.floor(-BEYOND / COARSE), math.ceil((spans.model.turn + BEYOND) / COARSE)
        every = np.stack(np.meshgrid(*[np.arange(low, high + 1)] * spans.axes, indexing="ij"), -1)
        return cls._kept(spans, COARSE, every.reshape(-1, spans.axes))

    def finer(self, spans: ArmSpans, points: Floats | Ints, around: int) -> _Lattice:
        """Points of the lattice of half the step around some points, in steps of this one, (n, axes)."""
        offsets = np.stack(np.meshgrid(*[np.arange(-around, around + 1)] * spans.axes, indexing="ij"), -1)
        every = np.floor(2 * points).astype(np.intp)[:, None] + offsets.reshape(-1, spans.axes)
        return self._kept(spans, self.step / 2, _distinct(every.reshape(-1, spans.axes)))

    @classmethod
    def _kept(cls, spans: ArmSpans, step: float, index: Ints) -> _Lattice:
        """The points that have room, or miss little."""
        headings = np.asarray(index * step)
        index = index[spans.within_limits(headings)]
        free = spans.interval(np.asarray(index * step))
        with np.errstate(invalid="ignore"):
            room = free.high - free.low
        kept = room >= -SLACK * step
        index, free = index[kept], Interval(free.low[kept], free.high[kept])
        at = spans.target_slides(np.asarray(index * step))
        missing = np.maximum(free.low, at.low) - np.minimum(free.high, at.high)
        return cls(step, index, free, missing <= 0)

    def way(self, spans: ArmSpans) -> Ints | None:
        """Rows of the points on the way with most room from the start to a target; None where there is none."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import dijkstra

        start = np.flatnonzero((self.place == np.round(spans.ends.start / self.step).astype(int)).all(axis=1))
        if not len(start) or not self.goal.any():
            return None
        pairs, lengths = self._neighbours()
        one, other = pairs.T
        # Room to go from one point to the other: slides that are free at both.
        room = np.minimum(self.free.high[one], self.free.high[other])
        room -= np.maximum(self.free.low[one], self.free.low[other])
        possible = room >= -2 * SLACK * self.step
        room, n = room[possible], len(self.place)
        narrow = 1.0 / (WIDEST + np.clip(room / WIDE, 0.0, 1.0)) + MISSING * np.maximum(-room, 0.0) / WIDE
        graph = coo_array((lengths[possible] * narrow, (one[possible], other[possible])), shape=(n, n)).tocsr()
        far, before = dijkstra(graph, directed=False, indices=int(start[0]), return_predecessors=True)
        at = int(np.where(self.goal, far, np.inf).argmin())
        if not math.isfinite(far[at]):
            return None
        way = []
        while at >= 0:
            way.append(at)
            at = int(before[at])
        return np.array(way[::-1])

    def _neighbours(self) -> tuple[Ints, Floats]:
        """Pairs of points that are neighbours, (pairs, 2), and their distances in steps, (pairs,)."""
        keys, weights, _ = _keys(self.place)
        found, lengths = [], []
        for offset in itertools.product((-1, 0, 1), repeat=len(weights)):
            if offset <= (0,) * len(weights):
                continue
            wanted = keys + np.array(offset) @ weights
            at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
            here = np.flatnonzero(keys[at] == wanted)
            found.append(np.stack([here, at[here]], axis=1))
            lengths.append(np.full(len(here), math.sqrt(np.abs(offset).sum())))
        return np.concatenate(found), np.concatenate(lengths)


def _keys(index: Ints) -> tuple[Ints, Ints, Ints]:
    """A number for each point, (n,), the weights of its axes, (axes,), and the index of number 0, (axes,)."""
    low = index.min(axis=0) - 1
    span = index.max(axis=0) - low + 2
    weights = np.concatenate([np.cumprod(span[::-1])[::-1][1:], [1]])
    return (index - low) @ weights, weights, low


def _distinct(index: Ints) -> Ints:
    """Distinct rows in the order of their keys, (m, axes)."""
    return np.asarray(index[np.unique(_keys(index)[0], return_index=True)[1]])


def _motion(spans: ArmSpans, way: Floats) -> Floats | None:
    """Motion through headings, (n, axes), that both tests find free; None where they do not."""
    headings = _dense(np.concatenate([spans.ends.start[None], way]))
    free = spans.interval(headings)
    apart = np.maximum(free.low[:-1], free.low[1:]) > np.minimum(free.high[:-1], free.high[1:])
    if (free.low > free.high).any() or apart.any() or not spans.within_limits(headings).all():
        return None
    at = spans.target_slides(headings[-1:])
    end = float(np.clip((at.low[0] + at.high[0]) / 2, free.low[-1], free.high[-1]))
    if not at.low[0] <= end <= at.high[0]:
        return None
    spare = np.minimum(WIDE, (free.high - free.low) / 2)
    least, most = free.low + spare, free.high - spare
    slides = [spans.ends.base]
    for low, high in zip(least.tolist(), most.tolist(), strict=True):
        slides.append(min(max(slides[-1], low), high))
    # With all headings standing, the slide goes as far as it may towards where it is to be with the next ones.
    arrive, leave = np.array(slides[1:]), np.clip(np.array([*slides[2:], end]), least, most)
    every = np.concatenate([slides[:1], np.stack([arrive, leave], axis=1).ravel(), [end]])
    rows = np.concatenate([headings[:1], np.repeat(headings, 2, axis=0), headings[-1:]])
    q = configuration(spans.model, spans.ends.base, every, rows)
    q = q[np.concatenate([[True], np.abs(np.diff(q, axis=0)).max(axis=1) > 0])]
    if len(q) < 2 or not check_by_distance(spans.model, q, spans.ends.base).free:
        return None
    return q if check_by_shapely(spans.model, q, spans.ends.base).free else None


def _dense(headings: Floats) -> Floats:
    """Headings with so many between them that none changes by more than `DENSE`, (rows, axes) [rad]."""
    parts = np.maximum(np.ceil(np.abs(np.diff(headings, axis=0)).max(axis=1) / DENSE), 1)
    at = np.concatenate([[0.0], np.cumsum(parts)])
    every = np.arange(at[-1] + 1)
    return np.stack([np.interp(every, at, column) for column in headings.T], axis=1)
