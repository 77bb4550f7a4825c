"""Clamping of a robot of two mirrored halves in a straight pipe, and rolling forward when clamped.

A robot clamps in its plane as a zigzag: its wheels stand on the left wall and on the right wall alternately, and the
joint in the middle of each half presses. There are two such zigzags, mirror images of each other. The zigzag's sign
tells them apart: +1 where wheel 3 stands on the left wall, -1 where it stands on the right one.
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
"""Number of bending joints, and of wheels, of either half."""

PRESS = 0.3
"""Distance of the pressing joint's set-point beyond the bend that fits the bore [rad]."""

SPEED = 0.8
"""Speed of set-points and of rolling, as a share of the motors' no-load speed."""

LAG, CREEP = 0.25, 0.3
"""A robot that rolls forward slows down while joints are away from their set-points: at the distance `LAG` [rad] to the
share `CREEP` of its speed. It does not stop, because a caught wheel comes free as the robot goes on."""

ZIGZAG = np.array([-1.0, 2.0, -2.0, 2.0, -2.0, 1.0])
"""Bends of the zigzag of sign +1, in steepnesses of its links."""

PRESSING = np.array([0.0, 1.0, 0.0, 0.0, -1.0, 0.0])
"""Directions in which the joints of that zigzag press; 0 for joints that do not press."""


def check_robot(robot: RobotSpec) -> None:
    """Refuse a robot that cannot roll.

    Raises:
        PipenavError: the robot is not made of two mirrored halves with a roll joint between them.
    """
    lengths = robot.lengths
    halves = len(robot.joints) == len(robot.wheels) == 2 * HALF and bool(robot.hinges.all())
    if not (robot.free and robot.roll and halves and np.allclose(lengths, lengths[::-1])):
        raise PipenavError(
            f"robot {robot.name!r} cannot roll: that takes two mirrored halves of three bending joints with a wheel at "
            "each, and a roll joint between them: choose --robot pirate."
        )


def axle_offset(robot: RobotSpec, radius: float) -> float:
    """Distance from the axis of a round bore to the axle of a wheel whose tread's edges stand on the wall [m]."""
    wheel = robot.wheels[0]
    return math.sqrt(radius**2 - (wheel.height / 2) ** 2) - wheel.radius


def steepness(robot: RobotSpec, radius: float) -> float:
    """Angle between the links of a clamped robot and the pipe's axis [rad]."""
    return math.asin(min(2 * axle_offset(robot, radius) / float(robot.lengths[HALF]), 0.999))


def nearest_zigzag(bends: Floats) -> float:
    """Sign of the zigzag that the joints are nearer to."""
    return 1.0 if float(bends @ ZIGZAG) >= 0 else -1.0


def forward_directions(bends: Floats) -> Floats:
    """Directions in which the wheels roll forwards, (6,), in [-1, 1]: a bend presses its wheel to the outside wall."""
    return -np.clip(bends / STRAIGHT, -1.0, 1.0)


def rolled_distance(robot: RobotSpec, bends: Floats, wheel_speeds: Floats) -> float:
    """Distance that the wheels rolled forwards in a control period: their median, as some may slip [m]."""
    directions = forward_directions(bends)
    return CONTROL_PERIOD * robot.wheels[0].radius * float(np.median(wheel_speeds * directions))


class RollForward:
    """Motion of one robot that clamps and rolls along a straight.

    Args:
        robot: the robot, as `check_robot` accepts it.
        radius: radius of the bore [m].
        bends: joint positions now, (6,) [rad].
        set_points: set-points of the joints now, (6,) [rad].
        direction: +1 to roll forwards, -1 to roll backwards.

    Attributes:
        zigzag_sign: sign of the zigzag in which the robot clamps.
        distance: distance rolled so far, by the odometry of the wheels; negative backwards [m].
    """

    def __init__(
        self, robot: RobotSpec, radius: float, bends: Floats, set_points: Floats, direction: float = 1.0
    ) -> None:
        self._robot, self.zigzag_sign, self.distance = robot, nearest_zigzag(bends), 0.0
        self._zigzag = self.zigzag_sign * steepness(robot, radius) * ZIGZAG
        self._press = self.zigzag_sign * PRESS * PRESSING
        self._set_points, self._near = set_points - self._press, False
        self._step = SPEED * robot.speed_limits * CONTROL_PERIOD
        self._speed = direction * SPEED * robot.actuators[robot.wheels[0].actuator].speed_limit

    @property
    def clamped(self) -> bool:
        """Whether the set-points have reached the zigzag, and the joints are near it."""
        return self._near and bool(np.allclose(self._set_points, self._zigzag))

    def act(self, bends: Floats, wheel_speeds: Floats) -> Floats:
        """Set-points of joints and wheels for one control period, (12,) [rad, then rad/s].

        Args:
            bends: joint positions, (6,) [rad].
            wheel_speeds: wheel speeds, (6,) [rad/s].
        """
        self.distance += rolled_distance(self._robot, bends, wheel_speeds)
        self._set_points = self._set_points + np.clip(self._zigzag - self._set_points, -self._step, self._step)
        away = float(np.abs(self._zigzag - bends).max())
        self._near = away < LAG
        speed = self._speed * max(CREEP, 1.0 - (1.0 - CREEP) * away / LAG)
        return np.concatenate([self._set_points + self._press, speed * forward_directions(bends)])
