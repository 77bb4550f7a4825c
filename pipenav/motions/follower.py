"""Recorded paths played back pose by pose, no faster than the arm follows, with a way to free an arm that is caught."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.robots.robot import RobotSpec

FOLLOWING = 2.0
"""Largest distance of every joint from a pose before the next one is given, as a share of its fastest motion in a tick:
a command may come one tick late, and the arm lags behind it by another. Closer following passed no more corners."""

CAUGHT = 2
"""Ticks without coming so near, after which an arm counts as caught."""

PATIENCE = 3
"""Ticks that a path may take, for each of its poses after the first."""

SLACK = 30
"""Additional ticks that a path may take: the slowest joint of the shipped robots crosses its whole travel in 23."""


class Follower:
    """n arms, each on a path of its own, that sense nothing but their own joints.

    An arm that is caught, on the corner's inner edge say, is freed as a person would do it: it moves a little back
    along the path, each time farther, and then on again.

    Args:
        robot: the robot.
        n: number of arms.
        period: duration of a tick [s].

    Attributes:
        rows: row of the path that each arm was given last, (n,).
        caught: whether each arm counted as caught in the last tick, (n,).
    """

    def __init__(self, robot: RobotSpec, n: int, period: float) -> None:
        self._near = FOLLOWING * robot.speed_limits * period
        self._paths: list[Floats] = [np.zeros((1, len(robot.joints)))] * n
        self.rows, self._last = np.zeros(n, np.intp), np.zeros(n, np.intp)
        self._waited, self._releases = np.zeros(n, np.intp), np.zeros(n, np.intp)
        self.caught = np.zeros(n, bool)

    @property
    def patience(self) -> Ints:
        """Ticks that each arm may take for its path, (n,)."""
        return PATIENCE * self._last + SLACK

    @property
    def at_last(self) -> Flags:
        """Whether each arm was given its path's last pose, (n,)."""
        return np.asarray(self.rows == self._last)

    def start(self, indices: Ints, paths: Sequence[Floats]) -> None:
        """Put some robots at the first poses of new paths.

        Args:
            indices: which robots, (k,).
            paths: joint positions, k arrays (rows, joints) [rad or m].
        """
        for robot, path in zip(indices, paths, strict=True):
            self._paths[robot], self._last[robot] = path, len(path) - 1
        self.rows[indices], self._waited[indices], self._releases[indices] = 0, 0, 0

    def away(self, q: Floats) -> Floats:
        """Distance of each joint from the pose that the arm was given last, (n, joints) [rad or m]."""
        return np.abs(q - self._set_points())

    def act(self, q: Floats) -> Floats:
        """Set-points of the next tick, (n, joints) [rad or m].

        Args:
            q: joint positions now, (n, joints) [rad or m].
        """
        near = (self.away(q) <= self._near).all(axis=1)
        self._waited = np.where(near, 0, self._waited + 1)
        self.caught = self._waited >= CAUGHT
        self._releases[self.caught] += 1
        self._waited[self.caught] = 0
        rows = np.where(self.caught, self.rows - self._releases, np.where(near, self.rows + 1, self.rows))
        self.rows = np.clip(rows, 0, self._last)
        return self._set_points()

    def _set_points(self) -> Floats:
        return np.array([path[row] for path, row in zip(self._paths, self.rows.tolist(), strict=True)])
