"""What a robot in space finds out from its own sensors: how it is bent, how its plane lies, whether a straight ends.

The pipe's diameter is known, and how the straight that the robot is in lies against the weight, as a drawing says.
"""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.spatial import SpaceReading
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import HALF, room

STEEPEST = 0.25
"""Share of the weight that must pull across a straight for the accelerometers to tell how the robot's plane lies."""

AHEAD = (0.05, 0.21)
"""Beams that meet a straight's wall so far ahead of the laser tell that it ends [m]; a policy starts 60 to 100 mm
before a corner."""

LONGER = 1.25
"""They do by readings that are so many times as long as a straight would give."""


def ways(robot: RobotSpec, bends: Floats) -> Floats:
    """From one end of each link to the other, (links, 2) [m], in the frame of the first link."""
    headings = np.cumsum(np.append(0.0, bends))
    return np.asarray(robot.lengths[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=1))


def angle_between(one: Floats, other: Floats) -> float:
    """By how much the other way heads to the left of the one, (2,) each [rad]."""
    return math.atan2(one[0] * other[1] - one[1] * other[0], one @ other)


def from_rear_half(robot: RobotSpec, bends: Floats) -> float:
    """By how much the divided link heads to the left of the rear half, from its first wheel to its last [rad].

    In a zigzag those two wheels stand on the same wall, so that the rear half heads along the pipe.
    """
    way = ways(robot, bends)
    in_first = angle_between(way[1], way[1:HALF].sum(axis=0))  # seen from the link between the first two wheels
    return float(bends[1:HALF].sum()) - in_first


def plane_of(robot: RobotSpec, reading: SpaceReading, axes: Floats) -> float | None:
    """How the robot's plane is turned about a straight, from the accelerometers; None where that is too steep [rad].

    Args:
        robot: clamped or lying along the straight.
        reading: one robot's.
        axes: along the straight, to the left and upwards as columns, z up; the plane is turned from the second one.
    """
    down = -axes[2]  # in the straight's frame
    if math.hypot(down[1], down[2]) < STEEPEST or not np.any(reading.down):
        return None
    way = ways(robot, reading.body.q)
    heading = angle_between(way[1:-1].sum(axis=0), way[HALF])  # of the divided link, from the pipe's axis
    x, y, z = reading.down.mean(axis=0)
    sideways = math.sin(heading) * x + math.cos(heading) * y
    return math.atan2(down[2], down[1]) - math.atan2(z, sideways)


def sees_end(robot: RobotSpec, reading: SpaceReading, radius: float, third: float) -> bool:
    """Whether a wall ends ahead of a clamped robot, whose last two wheels stand on either wall.

    Args:
        robot: the robot.
        reading: one robot's.
        radius: of the bore [m].
        third: the wall on which wheel 3 stands, see `pipenav.tasks.rolling.clamp`.
    """
    lidar, way = robot.laser, ways(robot, reading.body.q)
    heading = angle_between(way[HALF + 1 : 2 * HALF].sum(axis=0), way[-1])  # of the head, from the pipe's axis
    offset = -third * room(robot, radius) + float(robot.lengths[-1]) * math.sin(heading)  # of the tip, to the left
    beams = lidar.angles + heading
    across = np.where(beams > 0, radius - offset, radius + offset)
    straight = across / np.maximum(np.abs(np.sin(beams)), 1e-6)
    ahead = straight * np.cos(beams)
    telling = (ahead >= AHEAD[0]) & (ahead <= AHEAD[1])
    return bool((reading.body.ranges > LONGER * straight)[telling].any())
