"""Primitives of a whole robot: one word for what all its joints and wheels do together."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.messages import Reading
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import RollForward, check_robot

ROLL = "roll"
"""Primitive that turns a robot's plane into that of the next corner, in routes that leave the plane."""

PRIMITIVES = ("clamp", "stretch", "forward", "backward", "turn-in", ROLL)
"""Names of the primitives. `stretch` is step (a) and `turn-in` is step (b) of the turning sequence."""

AS_STEPS = {"stretch": "a", "turn-in": "b"}
"""Steps of the turning sequence that are primitives."""

DIRECTIONS = {"clamp": 0.0, "forward": 1.0, "backward": -1.0}
"""Direction in which a robot rolls that clamps with both halves."""

NO_ROLL = "a roll is for routes that leave the plane, and this pipe lies in one"
"""Why a roll that was asked for did not begin."""

FRONT_FIRST = "the front moves on before it clamps: finish (b) first"
"""Why a clamp that was asked for did not begin."""


class Clamped:
    """A robot that clamps with both halves in a straight, and rolls or stands.

    Args:
        robot: two mirrored halves with a roll joint between them.
        radius: radius of the bore [m].

    Raises:
        PipenavError: the robot is built otherwise.
    """

    def __init__(self, robot: RobotSpec, radius: float) -> None:
        check_robot(robot)
        self._roll, self._radius = RollForward(robot, 1), radius
        self._stands = False

    def begin(self, name: str, reading: Reading, set_points: Floats) -> None:
        """Begin `clamp`, `forward` or `backward`.

        Args:
            name: name of the primitive.
            reading: readings of the robot's sensors, rows of one.
            set_points: set-points of the joints now, (6,) [rad].
        """
        direction = DIRECTIONS[name]
        self._stands = direction == 0.0
        row = np.arange(1)
        self._roll.begin(row, np.array([self._radius]), reading.q, set_points[None], direction or 1.0)

    def goal(self, reading: Reading) -> Floats:
        """Set-points of joints and wheels, (12,) [rad, then rad/s]; readings are rows of one."""
        assert reading.wheel_speeds is not None
        goal = self._roll.act(np.arange(1), reading.q, reading.wheel_speeds)[0]
        if self._stands:
            goal[len(goal) // 2 :] = 0.0
        return np.asarray(goal)
