"""Senses of robots in space: the angle of its plane and the end of a straight, told from their own sensors.

The pipe's diameter is known, and so is how the straight that a robot is in lies against the weight: both stand in the
pipe's drawing.
"""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import HALF, axle_offset

STEEPEST = 0.25
"""Share of the weight that must pull across a straight for the accelerometers to tell the robot's plane."""

WEIGHT = 0.5
"""Share of the weight that both halves must feel for something to weigh: more than an accelerometer is wrong by."""

AHEAD = (0.05, 0.21)
"""Range of distances ahead of the laser [m] in which beams should meet a straight's wall, to tell whether it ends. A
policy starts 60 to 100 mm before a corner."""

LONGER = 1.25
"""Factor by which such a beam must read more than a straight's wall would give, to tell that the wall ends."""


def link_vectors(robot: RobotSpec, bends: Floats) -> Floats:
    """Vectors from one end of each link to the other, in the frame of the first link, (n, links, 2) [m].

    Args:
        robot: the robot.
        bends: joint positions, (n, joints) [rad].
    """
    headings = np.cumsum(np.pad(bends, [(0, 0), (1, 0)]), axis=1)
    return np.asarray(robot.lengths[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=2))


def angle_between(one: Floats, other: Floats) -> Floats:
    """Angle by which each vector `other` heads to the left of the vector `one`, (n, 2) each: (n,) [rad]."""
    across = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    return np.asarray(np.arctan2(across, one[:, 0] * other[:, 0] + one[:, 1] * other[:, 1]))


def heading_from_rear_half(robot: RobotSpec, bends: Floats) -> Floats:
    """Angle by which the divided link heads to the left of the rear half, from its first wheel to its last, (n,) [rad].

    In a zigzag those two wheels stand on the same wall, so that the rear half heads along the pipe.
    """
    links = link_vectors(robot, bends)
    in_first = angle_between(links[:, 1], links[:, 1:HALF].sum(axis=1))  # seen from the link between the first wheels
    return np.asarray(bends[:, 1:HALF].sum(axis=1) - in_first)


def plane_angle(robot: RobotSpec, bends: Floats, down: Floats, axes: Floats) -> Floats:
    """Angle of each robot's plane about its straight, by the accelerometers, (n,) [rad]; NaN where that is too steep.

    Args:
        robot: the robot, clamped or lying along the straight.
        bends: joint positions, (n, joints) [rad].
        down: direction of down in each half's frame, as `SpaceReading.down`, (n, halves, 3).
        axes: directions along the straight, to the left and upwards as columns, z up, (n, 3, 3); the angle counts from
            the second.
    """
    straight = -axes[:, 2]  # down in the straight's frame
    links = link_vectors(robot, bends)
    heading = angle_between(links[:, 1:-1].sum(axis=1), links[:, HALF])  # from the pipe's axis to the divided link
    x, y, z = down.mean(axis=1).T
    sideways = np.sin(heading) * x + np.cos(heading) * y
    angle = np.arctan2(straight[:, 2], straight[:, 1]) - np.arctan2(z, sideways)
    told = (np.hypot(straight[:, 1], straight[:, 2]) >= STEEPEST) & (np.linalg.norm(down, axis=2).min(axis=1) > WEIGHT)
    return np.where(told, angle, np.nan)


def sees_end(robot: RobotSpec, bends: Floats, ranges: Floats, radius: Floats, zigzag_sign: Floats) -> Flags:
    """Whether a wall ends ahead of each clamped robot, whose last two wheels stand on opposite walls, (n,).

    Args:
        robot: the robot.
        bends: joint positions, (n, joints) [rad].
        ranges: laser readings from right to left, (n, beams) [m].
        radius: radius of the bore, (n,) [m].
        zigzag_sign: sign of the zigzag in which each robot clamps, (n,), see `pipenav.tasks.rolling.clamp`.
    """
    links, radius = link_vectors(robot, bends), radius[:, None]
    heading = angle_between(links[:, HALF + 1 : 2 * HALF].sum(axis=1), links[:, -1])  # from the pipe's axis to the head
    last_wheel = -zigzag_sign[:, None] * axle_offset(robot, radius)  # distances to the left of the axis
    tip = last_wheel + float(robot.lengths[-1]) * np.sin(heading)[:, None]
    beams = robot.laser.angles + heading[:, None]
    across = np.where(beams > 0, radius - tip, radius + tip)
    straight = across / np.maximum(np.abs(np.sin(beams)), 1e-6)
    ahead = straight * np.cos(beams)
    telling = (ahead >= AHEAD[0]) & (ahead <= AHEAD[1])
    return np.asarray((telling & (ranges > LONGER * straight)).any(axis=1))
