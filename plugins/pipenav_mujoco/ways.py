"""Ways on which robots are expected to move in a control period, and how far they stray from them.

A point is expected on a straight way, to where it gets if it moves as at the end of the period before. How far a robot
strays is estimated from the way's length, from the last time, and from how much its set-points changed. The numbers
below made rolling in 24 routes fastest: a wider way costs time in every physics step, a robot that strays goes twice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints

RECENT = 4
"""Share of a control period, as its inverse, whose motion says where a robot gets in the next one."""

SLACK = 0.010
"""Slack of a robot that goes part of a period again, or for whose usual slack there is no room in its list [m]."""

MOST = 0.017
"""Largest slack [m], also of a robot that was put at rest, of which nothing is known."""

LEAST, LENGTH_SHARE, LAST_SHARE, LEVER = 0.001, 0.2, 0.5, 0.05
"""Estimate of the slack: least value [m], shares of the way's length and of what the robot strayed in the last period,
and length by which a change of set-points counts [m/rad]."""

STEADY, AHEAD, SPARE = 0.0015, 4, 0.001
"""Distance up to which a robot strays that moves steadily [m], periods for which such a robot's way is looked ahead,
and what its slack is larger by, so that the next ways fit into it [m]."""


class Way(NamedTuple):
    """Ways of k robots with p points each.

    Attributes:
        start, end: where the ways begin and end, (k, p, 3) [m].
        slack: distance up to which points may stray, (k,) [m].
    """

    start: Floats
    end: Floats
    slack: Floats

    @classmethod
    def resting(cls, points: Floats) -> Way:
        """Ways of points (k, p, 3) [m] that stay about where they are."""
        return cls(points, points, np.full(len(points), SLACK))

    def rows(self, indices: Ints | Flags) -> Way:
        """Ways of some robots."""
        return Way(*(values[indices] for values in self))

    def strayed(self, tracks: Floats) -> Floats:
        """Largest distance of each robot's points from their ways, (k,) [m].

        Args:
            tracks: where the points were, any number m of times, (p, 3, k, m) [m]; overwritten.
        """
        begin, way = ((v.transpose(1, 2, 0)[..., None]).copy() for v in (self.start, self.end - self.start))
        tracks -= begin
        share = tracks[:, 0] * way[:, 0] + tracks[:, 1] * way[:, 1] + tracks[:, 2] * way[:, 2]  # (p, k, m)
        share /= np.maximum((way**2).sum(axis=1), 1e-12)
        share = np.minimum(np.maximum(share, 0.0, out=share), 1.0, out=share)
        for axis in range(3):  # one after the other, which needs no large array
            tracks[:, axis] -= share * way[:, axis]
        tracks *= tracks
        return np.asarray(np.sqrt((tracks[:, 0] + tracks[:, 1] + tracks[:, 2]).max(axis=0).max(axis=1)))

    def holds(self, inner: Way) -> Flags:
        """Whether all that is nearer to other ways than their slack is nearer to these than theirs, (k,)."""
        ends = np.stack([inner.start, inner.end], axis=-1).transpose(1, 2, 0, 3)
        return np.asarray(self.strayed(ends) + inner.slack <= self.slack)  # as a straight way is nowhere further

    def ahead(self, steady: Flags) -> Way:
        """These ways, lengthened and widened for robots that move steadily, (k,)."""
        end = np.where(steady[:, None, None], self.start + AHEAD * (self.end - self.start), self.end)
        return Way(self.start, end, self.slack + np.where(steady, SPARE, 0.0))


class Expected:
    """Expectations of n robots' ways, with p points each.

    Args:
        n: number of robots.
        points: number of points.
        set_points: number of set-points of the joints.

    Attributes:
        steady: whether each robot moved steadily in the last period, (n,).
    """

    def __init__(self, n: int, points: int, set_points: int) -> None:
        self._before, self._strayed = np.full((n, points, 3), np.nan), np.zeros(n)
        self._told = np.zeros((n, set_points))
        self.steady = np.zeros(n, bool)

    def forget(self, indices: Ints) -> None:
        """Forget how some robots moved, which were put at rest."""
        self._before[indices], self._strayed[indices], self.steady[indices] = np.nan, 0.0, False

    def ways(self, points: Floats, set_points: Floats) -> Way:
        """Ways of all robots in the next period.

        Args:
            points: where their points are, (n, p, 3) [m].
            set_points: what their joints are told, (n, set-points) [rad].
        """
        first = np.isnan(self._before[:, 0, 0])
        step = RECENT * np.where(first[:, None, None], 0.0, points - self._before)
        length = np.sqrt((step**2).sum(axis=2).max(axis=1))
        change = np.abs(set_points - self._told).max(axis=1)
        self._told[:] = set_points
        slack = LEAST + LENGTH_SHARE * length + LAST_SHARE * self._strayed + LEVER * change
        return Way(points, points + step, np.where(first, MOST, np.minimum(slack, MOST)))

    def learn(self, way: Way, strayed: Floats, late: Floats) -> None:
        """Take in how all robots moved.

        Args:
            way: the ways that were expected.
            strayed: how far they strayed, (n,) [m].
            late: where their points were a share of the period (`RECENT`) before its end, (n, p, 3) [m].
        """
        moved_before = ~np.isnan(self._before[:, 0, 0])
        self.steady = np.asarray(moved_before & (strayed < STEADY) & (strayed < way.slack))
        self._before, self._strayed = late, strayed
