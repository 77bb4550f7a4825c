"""Routes of n robots as their drawings say: what the robots know of the pipes before they move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipenav.arrays import Ints
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import MAX_CORNERS
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import HALF, steepness

MARGIN = 0.03
"""Distance to leave between a corner and the robot before it rolls, besides what it stretches backwards [m]."""


class Drawings:
    """Routes of n robots, corner by corner; what a shorter route leaves over is meaningless.

    Args:
        robot: the robot, as `check_robot` accepts it.
        n: number of robots.

    Attributes:
        corners: number of corners, (n,).
        turn_angle: change of direction in each corner, (n, corners) [rad].
        inside: direction of each corner's inside, counted around the straights without twist, (n, corners) [rad].
        axes: directions along the straight before each corner, to its left and upwards as columns,
            (n, corners, 3, 3).
        radius: radius of the bore before each corner, (n, corners) [m].
        room: distance to roll on from a corner that is behind, until the robot can turn its plane, (n,) [m].
    """

    def __init__(self, robot: RobotSpec, n: int) -> None:
        self._robot = robot
        self.corners = np.ones(n, np.intp)
        self.turn_angle, self.inside, self.radius = np.zeros((3, n, MAX_CORNERS))
        self.axes = np.zeros((n, MAX_CORNERS, 3, 3))
        self.room = np.zeros(n)

    def put(self, rows: Ints, routes: Sequence[PipeRoute]) -> None:
        """Overwrite the routes of some robots, k of them."""
        for row, route in zip(rows, routes, strict=True):
            legs, corners = route.legs, len(route.corners)
            self.corners[row], self.turn_angle[row, :corners] = corners, np.pi - route.interior_angles
            self.inside[row, :corners], self.axes[row, :corners] = legs.inside, legs.axes[:-1]
            self.radius[row, :corners] = legs.radius[:-1]
            stretch = 2 * self._robot.lengths[HALF] * (1 - np.cos(steepness(self._robot, route.radius)))
            self.room[row] = self._robot.lengths[0] + stretch + MARGIN
