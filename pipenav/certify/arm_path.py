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

COARSE = tuple(math.radians(step) for step in (12.0, 6.0, 3.0))
"""Steps of the lattices over all headings, the next one where the one before has no way [rad]."""

FINEST = math.radians(0.4)
"""Step below which no finer lattice is laid around a way [rad]."""

BEYOND = math.radians(50.0)
"""Angle by which headings may lie outside of those of the two legs [rad]."""

DENSE = math.radians(0.75)
"""Largest change of a heading between two waypoints [rad]."""

SLACK = 0.15
"""Room that may be missing at a point of a lattice, for its step [m/rad]: less than the room changes within it."""

WIDE = 0.005
"""Room above which more of it makes a way no better, and which slides keep from the ends of their interval [m]."""

AROUND = (2, 2, 1)
"""Steps of the finer lattice around a way, at its first halvings and at all others."""


def arm_path(spans: ArmSpans) -> Floats | None:
    """A motion from the start to a target that both tests find free; None where none was found.

    Args:
        spans: free slides of the arm, with the start and the targets.

    Returns:
        Configurations in the robot's own frame, (rows, joints).
    """
    for step in COARSE:
        lattice = _Lattice.over_all(spans, step)
        for halvings in itertools.count():
            way = lattice.way(spans)
            if way is None:
                break
            if (motion := _motion(spans, lattice.headings(way))) is not None:
                return motion
            if lattice.step < 2 * FINEST:
                break
            lattice = lattice.finer(spans, way, AROUND[min(halvings, len(AROUND) - 1)])
    return None


class _Lattice(NamedTuple):
    """Points of a lattice of headings.

    Attributes:
        step: distance of its points along each axis [rad].
        index: whole numbers of steps, (n, axes), in the order of their keys.
        room: length of the interval of free slides, negative where there is none, (n,) [m].
        goal: whether a target can be reached with these headings, (n,).
    """

    step: float
    index: Ints
    room: Floats
    goal: Flags

    @classmethod
    def over_all(cls, spans: ArmSpans, step: float) -> _Lattice:
        """The points between both legs' headings and somewhat beyond."""
        low, high = math.floor(-BEYOND / step), math.ceil((spans.model.turn + BEYOND) / step)
        every = np.stack(np.meshgrid(*[np.arange(low, high + 1)] * spans.axes, indexing="ij"), -1)
        return cls._kept(spans, step, every.reshape(-1, spans.axes))

    def finer(self, spans: ArmSpans, way: Ints, around: int) -> _Lattice:
        """Points of the lattice of half the step that lie around a way, rows of this one."""
        offsets = np.stack(np.meshgrid(*[np.arange(-around, around + 1)] * spans.axes, indexing="ij"), -1)
        points = 2 * self.index[way]
        middles = (points[:-1] + points[1:]) // 2
        every = (np.concatenate([points, middles])[:, None] + offsets.reshape(-1, spans.axes)).reshape(-1, spans.axes)
        return self._kept(spans, self.step / 2, np.unique(every, axis=0))

    @classmethod
    def _kept(cls, spans: ArmSpans, step: float, index: Ints) -> _Lattice:
        """The points that have room, or miss little."""
        headings = index * step
        index = index[spans.within_limits(headings)]
        free = spans.interval(index * step)
        with np.errstate(invalid="ignore"):
            room = free.high - free.low
        kept = room >= -SLACK * step
        index, free, room = index[kept], Interval(free.low[kept], free.high[kept]), room[kept]
        at = spans.target_slides(index * step)
        missing = np.maximum(free.low, at.low) - np.minimum(free.high, at.high)
        return cls(step, index, room, missing <= 0)

    def way(self, spans: ArmSpans) -> Ints | None:
        """Rows of the points on the way with most room from the start to a target; None where there is none."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import dijkstra

        start = np.flatnonzero((self.index == np.round(spans.ends.start / self.step).astype(int)).all(axis=1))
        if not len(start) or not self.goal.any():
            return None
        narrow = 1.0 / (0.05 + np.clip(self.room / WIDE, 0.0, 1.0)) + 200.0 * np.maximum(-self.room, 0.0) / WIDE
        pairs, lengths = self._neighbours()
        n = len(self.index)
        graph = coo_array((lengths * narrow[pairs].mean(axis=1), (pairs[:, 0], pairs[:, 1])), shape=(n, n)).tocsr()
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
        low = self.index.min(axis=0) - 1
        span = self.index.max(axis=0) - low + 2
        weights = np.concatenate([np.cumprod(span[::-1])[::-1][1:], [1]])
        keys = (self.index - low) @ weights
        found, lengths = [], []
        for offset in itertools.product((-1, 0, 1), repeat=len(span)):
            if offset <= (0,) * len(span):
                continue
            wanted = keys + np.array(offset) @ weights
            at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
            here = np.flatnonzero(keys[at] == wanted)
            found.append(np.stack([here, at[here]], axis=1))
            lengths.append(np.full(len(here), math.sqrt(np.abs(offset).sum())))
        return np.concatenate(found), np.concatenate(lengths)

    def headings(self, way: Ints) -> Floats:
        """Headings of points, (n, axes) [rad]."""
        return np.asarray(self.index[way] * self.step)


def _motion(spans: ArmSpans, way: Floats) -> Floats | None:
    """Motion through headings, (n, axes), that both tests find free; None where they do not."""
    headings = _dense(np.concatenate([spans.ends.start[None], way]))
    free = spans.interval(headings)
    if (free.low > free.high).any() or not spans.within_limits(headings).all():
        return None
    at = spans.target_slides(headings[-1:])
    end = float(np.clip((at.low[0] + at.high[0]) / 2, free.low[-1], free.high[-1]))
    if not at.low[0] <= end <= at.high[0]:
        return None
    slides = [float(np.mean(spans.ends.start_slide))]
    for low, high in zip(free.low.tolist(), free.high.tolist(), strict=True):
        spare = min(WIDE, (high - low) / 2)
        slides.append(min(max(slides[-1], low + spare), high - spare))
    every, rows = np.array([*slides, end]), np.concatenate([headings[:1], headings, headings[-1:]])
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
