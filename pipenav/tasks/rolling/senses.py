"""Senses of a robot in space: the angle of its plane and the end of a straight, told from its own sensors.

The pipe's diameter is known, and so is how the straight that the robot is in lies against the weight: both stand in the
pipe's drawing.
"""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.spatial import SpaceReading
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import HALF, axle_offset

STEEPEST = 0.25
"""Share of the weight that must pull across a straight for the accelerometers to tell the robot's plane."""

AHEAD = (0.05, 0.21)
"""Range of distances ahead of the laser [m] in which beams should meet a straight's wall, to tell whether it ends. A
policy starts 60 to 100 mm before a corner."""

LONGER = 1.25
"""Factor by which such a beam must read more than a straight's wall would give, to tell that the wall ends."""


def link_vectors(robot: RobotSpec, bends: Floats) -> Floats:
    """Vectors from one end of each link to the other, in the frame of the first link, (links, 2) [m]."""
    headings = np.cumsum(np.append(0.0, bends))
    return np.asarray(robot.lengths[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=1))


def angle_between(one: Floats, other: Floats) -> float:
    """Angle by which the vector `other` heads to the left of the vector `one`, (2,) each [rad]."""
    return math.atan2(one[0] * other[1] - one[1] * other[0], one @ other)


def heading_from_rear_half(robot: RobotSpec, bends: Floats) -> float:
    """Angle by which the divided link heads to the left of the rear half, from its first wheel to its last [rad].

    In a zigzag those two wheels stand on the same wall, so that the rear half heads along the pipe.
    """
    links = link_vectors(robot, bends)
    in_first = angle_between(links[1], links[1:HALF].sum(axis=0))  # seen from the link between the first two wheels
    return float(bends[1:HALF].sum()) - in_first


def plane_angle(robot: RobotSpec, reading: SpaceReading, axes: Floats) -> float | None:
    """Angle of the robot's plane about a straight, by the accelerometers; None where the straight is too steep [rad].

    Args:
        robot: the robot, clamped or lying along the straight.
        reading: readings of one robot.
        axes: directions along the straight, to the left and upwards as columns, z up; the angle counts from the second.
    """
    down = -axes[2]  # in the straight's frame
    if math.hypot(down[1], down[2]) < STEEPEST or not np.any(reading.down):
        return None
    links = link_vectors(robot, reading.body.q)
    heading = angle_between(links[1:-1].sum(axis=0), links[HALF])  # from the pipe's axis to the divided link
    x, y, z = reading.down.mean(axis=0)
    sideways = math.sin(heading) * x + math.cos(heading) * y
    return math.atan2(down[2], down[1]) - math.atan2(z, sideways)


def sees_end(robot: RobotSpec, reading: SpaceReading, radius: float, zigzag_sign: float) -> bool:
    """Whether a wall ends ahead of a clamped robot, whose last two wheels stand on opposite walls.

    Args:
        robot: the robot.
        reading: readings of one robot.
        radius: radius of the bore [m].
        zigzag_sign: sign of the zigzag in which the robot clamps, see `pipenav.tasks.rolling.clamp`.
    """
    lidar, links = robot.laser, link_vectors(robot, reading.body.q)
    heading = angle_between(links[HALF + 1 : 2 * HALF].sum(axis=0), links[-1])  # from the pipe's axis to the head
    last_wheel = -zigzag_sign * axle_offset(robot, radius)  # distances to the left of the axis
    tip = last_wheel + float(robot.lengths[-1]) * math.sin(heading)
    beams = lidar.angles + heading
    across = np.where(beams > 0, radius - tip, radius + tip)
    straight = across / np.maximum(np.abs(np.sin(beams)), 1e-6)
    ahead = straight * np.cos(beams)
    telling = (ahead >= AHEAD[0]) & (ahead <= AHEAD[1])
    return bool((reading.body.ranges > LONGER * straight)[telling].any())
