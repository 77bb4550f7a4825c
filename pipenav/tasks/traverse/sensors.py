"""Readings of gyroscopes, accelerometers and wheel encoders with the errors of their grade, for n robots at once.

An accelerometer feels each acceleration of the robot beside its weight. So a robot does what is usual: its gyroscope
turns its direction of down along, and the accelerometer pulls it slowly to what it reads (a complementary filter).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.robots.inertial import SensorGrade
from pipenav.tasks.traverse.episode import GRAVITY

FUSION = 2.0
"""Time in which the accelerometer pulls the direction of down to its reading [s]: long beside the jerks of a robot that
moves at 0.1 m/s, whose mean over this time is 0.005 g, and short beside the drift of its gyroscope."""


class Motion(NamedTuple):
    """True motion of the links with sensors at the end of a control period.

    Attributes:
        down: direction of down in the frame of each sensor, as shares of the weight, (n, sensors, 3).
        turned: rotation of each sensor about its axes in the period, (n, sensors, 3) [rad].
        centre: place of the sensors, all in one link, in the pipe's frame, (n, 3) [m].
        axes: axes of each sensor's frame as columns, in the pipe's frame, (n, sensors, 3, 3).
    """

    down: Floats
    turned: Floats
    centre: Floats
    axes: Floats

    def rows(self, indices: Ints) -> Motion:
        """Motion of some robots."""
        return Motion(*(column[indices] for column in self))


class Sensed(NamedTuple):
    """Readings of the sensors.

    Attributes:
        down: direction of down as the robots estimate it, as shares of the weight, (n, sensors, 3).
        turned: rotation of each sensor by its gyroscope in the control period, (n, sensors, 3) [rad].
        wheel_speeds: speeds of the wheels by their encoders, (n, wheels) [rad/s].
    """

    down: Floats
    turned: Floats
    wheel_speeds: Floats


class Sensors:
    """Sensors of n robots.

    The errors of an episode depend on its seed alone: each robot draws from a generator of its own.

    Args:
        grade: sizes of the errors.
        n: number of robots.
        sensors: number of gyroscopes and accelerometers of each robot.
        wheels: number of wheels of each robot.
    """

    def __init__(self, grade: SensorGrade, n: int, sensors: int, wheels: int) -> None:
        self._grade, self._shape = grade, (sensors, 3)
        self._generators = [np.random.default_rng(0) for _ in range(n)]
        self._gyro_bias, self._gyro_scale, self._accel_bias, self._accel_scale = np.zeros((4, n, sensors, 3))
        self._tyre, self._wheel_angle = np.ones((n, wheels)), np.zeros((n, wheels))
        self._down, self._places = np.zeros((n, sensors, 3)), np.zeros((2, n, 3))

    def start(self, indices: Ints, seeds: Ints, motion: Motion) -> Sensed:
        """Begin anew with some robots, which have stood still so far, and return their readings.

        Args:
            indices: which robots, (k,).
            seeds: seeds of their errors, (k,).
            motion: motion of these robots, at rest, k of them.
        """
        grade, shape = self._grade, self._shape
        for i, seed in zip(indices, seeds, strict=True):
            rng = self._generators[i] = np.random.default_rng(int(seed))
            unknown = rng.normal(0.0, grade.gyro_bias, shape)
            at_rest = unknown + rng.normal(0.0, grade.gyro_noise / math.sqrt(grade.rest), shape)
            self._gyro_bias[i] = unknown - at_rest
            self._gyro_scale[i] = 1.0 + rng.normal(0.0, grade.gyro_scale, shape)
            self._accel_bias[i] = rng.normal(0.0, grade.accel_bias, shape)
            self._accel_scale[i] = 1.0 + rng.normal(0.0, grade.accel_scale, shape)
            self._tyre[i] = 1.0 + rng.normal(0.0, grade.tyre, self._tyre.shape[1])
        self._wheel_angle[indices], self._places[:, indices] = 0.0, motion.centre
        self._down[indices] = motion.down * self._accel_scale[indices] + self._accel_bias[indices]
        still = np.zeros((len(indices), *shape)), np.zeros((len(indices), self._tyre.shape[1]))
        return Sensed(self._down[indices], *still)

    def sense(self, motion: Motion, wheel_speeds: Floats) -> Sensed:
        """Readings of all robots after a control period.

        Args:
            motion: motion of the robots.
            wheel_speeds: true speeds of their wheels, (n, wheels) [rad/s].
        """
        grade, period = self._grade, CONTROL_PERIOD
        drawn = np.array([rng.standard_normal((4, *self._shape)) for rng in self._generators]).swapaxes(0, 1)
        self._gyro_bias += grade.gyro_drift * math.sqrt(period) * drawn[0]
        self._accel_bias += grade.accel_drift * math.sqrt(period) * drawn[1]
        noise = grade.gyro_noise * math.sqrt(period) * drawn[2]
        turned = motion.turned * self._gyro_scale + self._gyro_bias * period + noise
        felt = motion.down - self._acceleration(motion) / GRAVITY
        noise = self._accel_bias + grade.accel_noise / math.sqrt(period) * drawn[3]
        read = np.clip(felt * self._accel_scale + noise, -grade.accel_range, grade.accel_range)
        along = turned_back(self._down, turned)
        self._down = along + period / FUSION * (read - along)
        return Sensed(self._down.copy(), turned, self._encoders(wheel_speeds))

    def _acceleration(self, motion: Motion) -> Floats:
        """Acceleration of the sensors in their frames, (n, sensors, 3) [m/s^2], its mean over two control periods."""
        before, last = self._places
        with np.errstate(invalid="ignore"):  # a world that blew up is at infinity
            change = (motion.centre - 2 * last + before) / CONTROL_PERIOD**2
        self._places = np.stack([last, motion.centre])
        return np.asarray(np.nan_to_num(change)[:, None, None] @ np.nan_to_num(motion.axes))[:, :, 0]

    def _encoders(self, wheel_speeds: Floats) -> Floats:
        """Speeds by the counts of a control period, (n, wheels) [rad/s]; a worn tyre turns faster than is known."""
        step, before = 2 * math.pi / self._grade.encoder_counts, self._wheel_angle
        self._wheel_angle = before + CONTROL_PERIOD * wheel_speeds * self._tyre
        return np.asarray((np.floor(self._wheel_angle / step) - np.floor(before / step)) * step / CONTROL_PERIOD)


def turned_back(vectors: Floats, turned: Floats) -> Floats:
    """Vectors (..., 3) in frames that have turned by rotation vectors (..., 3) [rad] since, by Rodrigues' formula."""
    angle = np.linalg.norm(turned, axis=-1, keepdims=True)
    axis = turned / np.maximum(angle, 1e-12)
    along = axis * (axis * vectors).sum(axis=-1, keepdims=True)
    return np.asarray(np.cos(angle) * (vectors - along) - np.sin(angle) * np.cross(axis, vectors) + along)
