"""Clamping of a robot of two mirrored halves in a straight pipe, and rolling forward when clamped.

A robot clamps in its plane as a zigzag: its wheels stand on the left wall and on the right wall alternately, and the
joint in the middle of each half presses. There are two such zigzags, mirror images of each other. The zigzag's sign
tells them apart: +1 where wheel 3 stands on the left wall, -1 where it stands on the right one.
"""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats, Ints
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


def axle_offset(robot: RobotSpec, radius: Floats | float) -> Floats:
    """Distance from the axis of a round bore to the axle of a wheel whose tread's edges stand on the wall, (...) [m].

    Args:
        robot: the robot.
        radius: radius of the bore, (...) [m].
    """
    wheel = robot.wheels[0]
    return np.asarray(np.sqrt(np.square(radius) - (wheel.height / 2) ** 2) - wheel.radius)


def steepness(robot: RobotSpec, radius: Floats | float) -> Floats:
    """Angle between the links of a clamped robot and the pipe's axis, (...) [rad]; `radius` as for `axle_offset`."""
    return np.asarray(np.arcsin(np.minimum(2 * axle_offset(robot, radius) / float(robot.lengths[HALF]), 0.999)))


def nearest_zigzag(bends: Floats) -> Floats:
    """Sign of the zigzag that each robot's joints, (n, 6) [rad], are nearer to, (n,)."""
    return np.where((bends * ZIGZAG).sum(axis=1) >= 0, 1.0, -1.0)


def forward_directions(bends: Floats) -> Floats:
    """Directions in which the wheels roll forwards, (n, 6), in [-1, 1]: a bend presses its wheel outwards."""
    return -np.clip(bends / STRAIGHT, -1.0, 1.0)


def rolled_distance(robot: RobotSpec, bends: Floats, wheel_speeds: Floats) -> Floats:
    """Distance that the wheels rolled forwards in a control period: their median, as some may slip, (n,) [m]."""
    rolled = np.median(wheel_speeds * forward_directions(bends), axis=1)
    return np.asarray(CONTROL_PERIOD * robot.wheels[0].radius * rolled)


class RollForward:
    """Motion of n robots that clamp and roll along a straight, each from when it begins.

    Args:
        robot: the robot, as `check_robot` accepts it.
        n: number of robots.

    Attributes:
        zigzag_sign: sign of the zigzag in which each robot clamps, (n,).
        distance: distance rolled so far, by the odometry of the wheels; negative backwards, (n,) [m].
        clamped: whether the set-points have reached the zigzag, and the joints are near it, (n,).
    """

    def __init__(self, robot: RobotSpec, n: int) -> None:
        self._robot = robot
        self.zigzag_sign, self.distance, self.clamped = np.ones(n), np.zeros(n), np.zeros(n, bool)
        self._zigzag, self._press, self._set_points = np.zeros((3, n, 2 * HALF))
        self._step = SPEED * robot.speed_limits * CONTROL_PERIOD
        self._speed = np.zeros(n)

    def begin(self, rows: Ints, radius: Floats, bends: Floats, set_points: Floats, direction: float = 1.0) -> None:
        """Let some robots begin.

        Args:
            rows: which robots, (k,).
            radius: radius of the bore, (k,) [m].
            bends: joint positions now, (k, 6) [rad].
            set_points: set-points of the joints now, (k, 6) [rad].
            direction: +1 to roll forwards, -1 to roll backwards.
        """
        sign = nearest_zigzag(bends)
        self.zigzag_sign[rows], self.distance[rows], self.clamped[rows] = sign, 0.0, False
        self._zigzag[rows] = (sign * steepness(self._robot, radius))[:, None] * ZIGZAG
        self._press[rows] = (sign * PRESS)[:, None] * PRESSING
        self._set_points[rows] = set_points - self._press[rows]
        self._speed[rows] = direction * SPEED * self._robot.actuators[self._robot.wheels[0].actuator].speed_limit

    def act(self, rows: Ints, bends: Floats, wheel_speeds: Floats) -> Floats:
        """Set-points of joints and wheels of some robots for one control period, (k, 12) [rad, then rad/s].

        Args:
            rows: which robots, (k,).
            bends: joint positions, (k, 6) [rad].
            wheel_speeds: wheel speeds, (k, 6) [rad/s].
        """
        self.distance[rows] += rolled_distance(self._robot, bends, wheel_speeds)
        zigzag, before = self._zigzag[rows], self._set_points[rows]
        set_points = before + np.clip(zigzag - before, -self._step, self._step)
        away = np.abs(zigzag - bends).max(axis=1)
        self.clamped[rows] = (away < LAG) & np.isclose(set_points, zigzag).all(axis=1)
        self._set_points[rows] = set_points
        speed = self._speed[rows] * np.maximum(CREEP, 1.0 - (1.0 - CREEP) * away / LAG)
        return np.concatenate([set_points + self._press[rows], speed[:, None] * forward_directions(bends)], axis=1)
