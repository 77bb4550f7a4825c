"""An arm driven by its tip: the tip goes where it is steered, and the links behind it follow the way that it took.

So a person steers one point around a corner and need not think of hinges: what the tip has passed, the links pass too.
Backwards the tip goes back along its way.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.errors import PipenavError
from pipenav.robots import kinematics
from pipenav.robots.robot import RobotSpec

SPEED = 0.05
"""Fastest speed of a tip that a person steers [m/s]: a bore's width in two seconds."""

GRAIN = 0.001
"""Distance between points of the way [m]."""

BEHIND = 1.0
"""Length of the way before the arm's first hinge, along the first leg [m]: more than any slide travels."""


class TipDriver:
    """The way of one arm's tip, and the joints that lie along it.

    Args:
        robot: a slide followed by hinges.
        q: joint positions at the start, (joints,) [m, rad].

    Raises:
        PipenavError: the robot is no such arm.
    """

    def __init__(self, robot: RobotSpec, q: Floats) -> None:
        if robot.free or robot.joints[0].type != "slide" or not robot.hinges[1:].all():
            raise PipenavError(
                f"robot {robot.name!r} cannot be driven by its tip, as a slide followed by hinges can: drive it joint "
                "by joint, or by steps."
            )
        self._robot = robot
        self.restart(q)

    def restart(self, q: Floats) -> None:
        """Begin a new way where the links lie now, at joint positions (joints,): someone else moved the arm."""
        points = kinematics.waypoints(self._robot, q[None])[0][1:]
        self._way = _dense(np.concatenate([points[:1] - [BEHIND, 0.0], points]))

    @property
    def tip(self) -> Floats:
        """End of the way, where the tip is to be, in the robot's frame, (2,) [m]."""
        return np.asarray(self._way[-1])

    def move(self, along: float, left: float, heading: float) -> Floats:
        """Joint positions after one control period, (joints,) [m, rad]; at a joint's limit the tip stays.

        Args:
            along: speed along the heading as a share of the fastest, in [-1, 1]; below 0 the tip goes back on its way.
            left: speed to the left of it, as such a share.
            heading: heading of the tip in the robot's frame [rad].
        """
        before = self._way
        distance = SPEED * CONTROL_PERIOD
        if along < 0:
            self._back(-along * distance)
        ahead = distance * max(along, 0.0)
        forwards, sideways = (
            np.array([math.cos(heading), math.sin(heading)]),
            np.array([-math.sin(heading), math.cos(heading)]),
        )
        moved = self.tip + ahead * forwards + distance * left * sideways
        if ahead > 0:
            self._way = np.concatenate([self._way, _dense(np.stack([self.tip, moved]))[1:]])
        elif left:
            self._way = np.concatenate([self._way[:-1], moved[None]])
        q = self.joints()
        inside = (q >= self._robot.lower) & (q <= self._robot.upper)
        if not inside.all():
            self._way = before
            return np.clip(self.joints(), self._robot.lower, self._robot.upper)
        return q

    def joints(self) -> Floats:
        """Joint positions with the hinges on the way, the first one on the first leg's axis, (joints,) [m, rad]."""
        lengths, way = self._robot.lengths, self._way
        points = [way[-1]]
        last = len(way) - 1
        for length in lengths[:1:-1]:
            last = _before(way, points[-1], last, float(length))
            points.append(_crossing(way[last], way[last + 1], points[-1], float(length)))
        x, y = points[-1]
        first = float(lengths[1])
        y = float(np.clip(y, -first, first))
        points.append(np.array([x - math.sqrt(first**2 - y**2), 0.0]))
        steps = np.diff(np.array(points[::-1]), axis=0)
        headings = np.arctan2(steps[:, 1], steps[:, 0])
        bends = np.diff(np.concatenate([[0.0], headings]))
        bends = np.mod(bends + math.pi, 2 * math.pi) - math.pi
        return np.concatenate([[points[-1][0] - lengths[0]], bends])

    def _back(self, distance: float) -> None:
        """Shorten the way at its end, by a distance [m]."""
        lengths = np.hypot(*np.diff(self._way, axis=0).T)
        gone = np.cumsum(lengths[::-1])
        count = int(np.searchsorted(gone, distance, side="right"))
        self._way = self._way[: max(len(self._way) - count, 2)]


def _before(way: Floats, point: Floats, last: int, length: float) -> int:
    """Index of the last point of the way, up to that with the index `last`, that is a link's length from a point."""
    distance = np.hypot(*(way[:last] - point).T)
    far = np.flatnonzero(distance >= length)
    return int(far[-1]) if len(far) else 0


def _crossing(far: Floats, near: Floats, point: Floats, length: float) -> Floats:
    """Point between two points of the way, (2,), at a link's length from another point; all (2,) [m]."""
    d, from_point = near - far, far - point
    dd, df = float(d @ d), float(d @ from_point)
    root = math.sqrt(max(df**2 - dd * (float(from_point @ from_point) - length**2), 0.0))
    return np.asarray(far + min(max((-df - root) / dd, 0.0), 1.0) * d)


def _dense(points: Floats) -> Floats:
    """Points of a line at most `GRAIN` apart, (m, 2) [m], through the given ones, (k, 2)."""
    parts = [points[:1]]
    for a, b in itertools.pairwise(points):
        count = max(math.ceil(math.hypot(*(b - a)) / GRAIN), 1)
        parts.append(a + np.linspace(0.0, 1.0, count + 1)[1:, None] * (b - a))
    return np.concatenate(parts)
