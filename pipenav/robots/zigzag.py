"""The pose of a clamped robot: a zigzag between two walls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.robots.robot import RobotSpec

STEEPEST = 0.95
"""Sine of the largest angle between a link and the pipe's axis: a steeper one would be hard to clamp."""


class Zigzag(NamedTuple):
    """Poses of k robots whose joints lie on alternating sides of the axis.

    Attributes:
        first_link: y and heading of the first link, (k, 2) [m, rad].
        bends: joint positions, (k, joints) [rad].
    """

    first_link: Floats
    bends: Floats


def zigzag(robot: RobotSpec, offset: Floats) -> Zigzag:
    """Poses with joints at +offset and -offset alternately and the end links along the axis; `offset` is (k,) [m]."""
    links = len(robot.links)
    signs = np.ones(links)
    signs[2::2] = -1.0  # the first link is as far off the axis as the first joint
    sideways = offset[:, None] * signs  # y of each link's rear end, (k, links)
    rise = np.diff(sideways, axis=1)[:, 1:] / robot.lengths[1:-1]
    headings = np.zeros((len(offset), links))
    headings[:, 1:-1] = np.arcsin(np.clip(rise, -STEEPEST, STEEPEST))
    first_link = np.stack([sideways[:, 0], headings[:, 0]], axis=1)
    return Zigzag(first_link, np.diff(headings, axis=1))
