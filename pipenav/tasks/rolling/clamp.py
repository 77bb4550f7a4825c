"""How a robot of two mirrored halves clamps in a straight pipe and drives: wheels by turns on either wall.

A robot clamps in its plane with its wheels on the left wall and on the right one by turns; the joint in the middle of
each half presses. There are two such zigzags: `third` is the wall on which wheel 3 stands, +1 for the left one.
"""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.errors import PipenavError
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.traverse.observation import STRAIGHT

HALF = 3
"""Bending joints, and wheels, of either half."""

PRESS = 0.3
"""How far beyond the bend that fits the set-point of the joint lies that presses a clamp [rad]."""

SPEED = 0.8
"""Speed of set-points and of rolling, as a share of the motors' no-load speed."""

LAG, CREEP = 0.25, 0.3
"""A driving robot slows down as joints are away from their set-points, at this distance [rad] to this share of its
speed: a wheel that is caught comes free as the robot goes on."""

ZIGZAG = np.array([-1.0, 2.0, -2.0, 2.0, -2.0, 1.0])
"""Bends of the zigzag with wheel 3 on the left wall, in steepnesses of its links."""

PRESSING = np.array([0.0, 1.0, 0.0, 0.0, -1.0, 0.0])
"""Which of its joints press, and to which side."""


def check_robot(robot: RobotSpec) -> None:
    """Refuse a robot that cannot do it.

    Raises:
        PipenavError: it is not made of two mirrored halves with a roll joint between them.
    """
    lengths = robot.lengths
    halves = len(robot.joints) == len(robot.wheels) == 2 * HALF and bool(robot.hinges.all())
    if not (robot.free and robot.roll and halves and np.allclose(lengths, lengths[::-1])):
        raise PipenavError(
            f"robot {robot.name!r} cannot roll: that takes two mirrored halves of three bending joints with a wheel at "
            "each, and a roll joint between them: choose --robot pirate."
        )


def room(robot: RobotSpec, radius: float) -> float:
    """How far off the axis of a round bore a wheel's axle is that stands on the wall with its tread's edges [m]."""
    wheel = robot.wheels[0]
    return math.sqrt(radius**2 - (wheel.height / 2) ** 2) - wheel.radius


def steepness(robot: RobotSpec, radius: float) -> float:
    """Angle between the links of a clamped robot and the pipe's axis [rad]."""
    return math.asin(min(2 * room(robot, radius) / float(robot.lengths[HALF]), 0.999))


def nearest(bends: Floats) -> float:
    """Which of the two zigzags the joints are nearer to: `third`."""
    return 1.0 if float(bends @ ZIGZAG) >= 0 else -1.0


def forwards(bends: Floats) -> Floats:
    """Which way round each wheel rolls forwards, (6,): its bend presses it to the wall on the outside."""
    return -np.clip(bends / STRAIGHT, -1.0, 1.0)


def rolled(robot: RobotSpec, bends: Floats, wheel_speeds: Floats) -> float:
    """How far the wheels rolled forwards in a control period, their median, as some may slip [m]."""
    return CONTROL_PERIOD * robot.wheels[0].radius * float(np.median(wheel_speeds * forwards(bends)))


class RollForward:
    """A clamped robot rolls along a straight.

    Attributes:
        gone: how far, by its wheels' odometry [m].
        third: see above.
    """

    def __init__(
        self, robot: RobotSpec, radius: float, bends: Floats, set_points: Floats, direction: float = 1.0
    ) -> None:
        self._robot, self.third, self.gone = robot, nearest(bends), 0.0
        self._goal = self.third * steepness(robot, radius) * ZIGZAG
        self._press = self.third * PRESS * PRESSING
        self._set_points, self._near = set_points - self._press, False
        self._step = SPEED * robot.speed_limits * CONTROL_PERIOD
        self._speed = direction * SPEED * robot.actuators[robot.wheels[0].actuator].speed_limit

    @property
    def clamped(self) -> bool:
        """Whether its set-points have arrived, and the joints at them."""
        return self._near and bool(np.allclose(self._set_points, self._goal))

    def act(self, bends: Floats, wheel_speeds: Floats) -> Floats:
        """Set-points of joints and wheels for one control period, (12,).

        Args:
            bends: joint positions, (6,) [rad].
            wheel_speeds: (6,) [rad/s].
        """
        self.gone += rolled(self._robot, bends, wheel_speeds)
        self._set_points = self._set_points + np.clip(self._goal - self._set_points, -self._step, self._step)
        away = float(np.abs(self._goal - bends).max())
        self._near = away < LAG
        speed = self._speed * max(CREEP, 1.0 - (1.0 - CREEP) * away / LAG)
        return np.concatenate([self._set_points + self._press, speed * forwards(bends)])
