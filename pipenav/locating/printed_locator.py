"""The method of approach I as the thesis prints it, eq 3.16 to 3.19.

The head turns towards the corner while the base moves forwards; the first beam that is long enough shows an open space,
and a point on it is the target. The method mistakes a straight pipe ahead for an open space, and presses its head
against the wall of a narrow pipe.
"""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.messages import Reading
from pipenav.locating.locator import LocateConfig, SearchStep, Told, advance
from pipenav.robots import kinematics
from pipenav.robots.robot import RobotSpec


class PrintedLocator:
    """Eq 3.16 to 3.19 as printed. Where several beams are open, the longest counts; of equal beams, the first."""

    def __init__(self, robot: RobotSpec, config: LocateConfig, n: int) -> None:
        self._robot, self._config, self.n = robot, config, n
        self._advance, self._turn_sign = np.full(n, config.v0), np.ones(n)
        self._start = np.zeros((n, len(robot.joints)))

    def start(self, indices: Ints, reading: Reading, told: Told) -> None:
        self._advance[indices], self._start[indices] = self._config.v0, reading.q
        self._turn_sign[indices] = told.turn_sign

    def act(self, reading: Reading) -> SearchStep:
        robot, config = self._robot, self._config
        self._advance = advance(robot, config, self._advance, reading.ranges)
        set_points = self._start.copy()
        set_points[:, 0] = reading.q[:, 0] + self._advance
        set_points[:, -1] = reading.q[:, -1] + config.omega0 * self._turn_sign
        beam = reading.ranges.argmax(axis=1)
        found = reading.ranges.max(axis=1) > config.open_range
        return SearchStep(
            np.where(found[:, None], reading.q, np.clip(set_points, robot.lower, robot.upper)),
            found,
            np.where(found[:, None], point_on_beam(robot, reading.q, beam, config.target_range), np.nan),
            np.where(found, beam, -1),
        )


def point_on_beam(robot: RobotSpec, q: Floats, beam: Ints, distance: float) -> Floats:
    """Points on beams by eq 3.17, with eq 3.16's angles, in the robot's own frame: (n, 2) [m].

    The thesis counts a beam's angle beta from the head's right, the laser's `angles` from straight ahead.

    Args:
        robot: the robot.
        q: joint positions, (n, joints) [rad or m].
        beam: index of each beam, (n,).
        distance: distance L along the beam [m].
    """
    pose = kinematics.forward(robot, q)
    heading = pose.headings[:, -1] + robot.laser.angles[beam]
    return np.asarray(pose.tip + distance * np.stack([np.cos(heading), np.sin(heading)], axis=1))
