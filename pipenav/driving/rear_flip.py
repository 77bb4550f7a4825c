"""A rear half that clamps the other way round before step (a), while the front half keeps the robot in its plane.

Step (a) clamps the rear half with its middle wheel on the corner's inner wall. Where that wheel stands on the other
wall and the front half lets go at the same time, nothing holds a robot in a round bore, and its plane turns.
"""

from __future__ import annotations

from typing import Self

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import LAG, PRESS, ZIGZAG, steepness

REAR, FRONT = 1, 4
"""Joint in the middle of either half, which presses."""

SAME_WALL = np.array([1.0, -2.0, 1.0, 1.0, -2.0, 1.0])
"""Bends of both halves in a left turn, in steepnesses of their links, when both middle wheels are on the inner wall."""

PATIENCE = 60
"""Control steps after which a flip counts as done anyway."""


class RearFlip:
    """Pose with both halves clamped, the rear one as step (a) wants it and the front one as it is.

    Args:
        pose: joint angles of that pose, (6,) [rad].
    """

    def __init__(self, pose: Floats) -> None:
        self._pose, self._steps = pose, 0
        self.done = False

    @classmethod
    def needed(cls, robot: RobotSpec, pipe: PipeCorner, bends: Floats) -> Self | None:
        """The flip that a robot needs before step (a) in a corner; None where its rear half clamps as that step wants.

        Args:
            robot: two mirrored halves.
            pipe: the corner, as it turns for the robot.
            bends: joint angles now, (6,) [rad].
        """
        sign, steep = pipe.turn_sign, float(steepness(robot, pipe.radius))
        if bends[REAR] * sign < 0:
            return None
        front_is_so = bends[FRONT] * sign < 0
        return cls(steep * sign * (SAME_WALL if front_is_so else -ZIGZAG))

    def goal(self, bends: Floats) -> Floats:
        """Set-points of joints and standing wheels for this control step, (12,) [rad, then rad/s].

        Args:
            bends: joint angles now, (6,) [rad].
        """
        self._steps += 1
        away = np.abs(np.delete(self._pose - bends, [REAR, FRONT]))
        self.done = bool(away.max() < LAG) or self._steps > PATIENCE
        press = np.zeros(len(self._pose))
        press[[REAR, FRONT]] = PRESS * np.sign(self._pose[[REAR, FRONT]])
        return np.concatenate([self._pose + press, np.zeros(len(self._pose))])
