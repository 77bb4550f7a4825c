"""The robot `pirate` clamped in a straight, and what it reads there."""

from __future__ import annotations

import numpy as np

from pipenav.backends.messages import Reading
from pipenav.backends.spatial import SpaceReading
from pipenav.robots.robot import load_robot
from pipenav.tasks.rolling.clamp import ZIGZAG, steepness

ROBOT = load_robot("pirate")


def clamped(radius: float, third: float) -> np.ndarray:
    """Joint angles of the robot clamped in a straight; `third` is the sign of the third joint's angle, (6,) [rad]."""
    return third * steepness(ROBOT, radius) * ZIGZAG


def reading(bends: np.ndarray, ranges: np.ndarray | None = None, down: np.ndarray | None = None) -> SpaceReading:
    """The reading of one robot that stands still."""
    seen = np.full(ROBOT.laser.beams, 0.5) if ranges is None else ranges
    body = Reading(bends, np.zeros(6), seen, np.zeros(()), np.zeros(6), np.zeros(12))
    return SpaceReading(body, np.zeros(()), np.zeros((2, 3)) if down is None else down, np.zeros((2, 3)))
