"""The robot `pirate-strong` clamped in a straight."""

from __future__ import annotations

import numpy as np

from pipenav.robots.robot import load_robot
from pipenav.tasks.rolling.clamp import ZIGZAG, steepness

ROBOT = load_robot("pirate-strong")


def clamped(radius: float, third: float) -> np.ndarray:
    """Joint angles of the robot clamped in a straight; `third` is the sign of the third joint's angle, (6,) [rad]."""
    return third * steepness(ROBOT, radius) * ZIGZAG
