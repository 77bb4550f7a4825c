"""Grades of inertial sensors and wheel encoders: how wrong the readings of a part are that robots really carry."""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import Literal, NamedTuple

SensorsName = Literal["ideal", "mems"]
"""Names of the grades that a task may ask for."""


class SensorGrade(NamedTuple):
    """Errors of a gyroscope and an accelerometer in each half of a robot, and of the encoders of its wheels.

    Standard deviations, drawn for each axis or wheel at the start of an episode, unless another is said.

    Attributes:
        gyro_bias: bias before the robot has stood still [rad/s].
        gyro_noise: noise density [rad/s/sqrt(Hz)].
        gyro_drift: growth of the bias, a random walk [rad/s/sqrt(s)].
        gyro_scale: relative error of the sensitivity.
        accel_bias: bias [g].
        accel_noise: noise density [g/sqrt(Hz)].
        accel_drift: growth of the bias, a random walk [g/sqrt(s)].
        accel_scale: relative error of the sensitivity.
        accel_range: largest reading, exactly [g].
        rest: time for which the robot stands before it starts, and takes the gyroscopes' mean for their bias, exactly
            [s].
        encoder_counts: counts of an encoder in a turn of its wheel, exactly.
        tyre: relative error of a tyre's radius, by wear.
    """

    gyro_bias: float
    gyro_noise: float
    gyro_drift: float
    gyro_scale: float
    accel_bias: float
    accel_noise: float
    accel_drift: float
    accel_scale: float
    accel_range: float
    rest: float
    encoder_counts: int
    tyre: float


WARMING = 5.0 / math.sqrt(100.0)
"""Random walk of a sensor's temperature beside motors, chosen: 5 degrees in 100 s [K/sqrt(s)]."""

MEMS = SensorGrade(
    gyro_bias=math.radians(1.0),
    gyro_noise=math.radians(3.8e-3),
    gyro_drift=math.radians(0.010) * WARMING,
    gyro_scale=0.01,
    accel_bias=0.020,
    accel_noise=75e-6,
    accel_drift=0.1e-3 * WARMING,
    accel_scale=0.01,
    accel_range=4.0,
    rest=10.0,
    encoder_counts=4096,
    tyre=0.02,
)
"""A consumer part for telephones and toys: LSM6DSO, data sheet DS12140 of STMicroelectronics, table 2, typical values:
zero-rate level 1 deg/s, rate noise 3.8 mdeg/s/sqrt(Hz), zero-rate over temperature 0.010 deg/s/K, zero-g level 20 mg,
acceleration noise 75 ug/sqrt(Hz) at 4 g, zero-g over temperature 0.1 mg/K, sensitivity tolerance 1 % for both. The
drift is these temperature coefficients times `WARMING`. Chosen: 10 s of rest, magnetic encoders of 12 bits on the
wheels, and tyres whose radius is wrong by 2 %, 0.3 mm of 16 mm."""

GRADES = MappingProxyType({"ideal": None, "mems": MEMS})
"""Grades by the names that tasks give them; None for sensors without errors."""
