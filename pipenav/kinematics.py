"""Forward kinematics of a planar chain, for n robots at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.robot import RobotSpec

Array = NDArray[np.float64]


class ChainPose(NamedTuple):
    """Where the links of n robots are, in the robot's frame (rear end of the first link at rest, x forwards).

    Attributes:
        joints: where each link starts, (n, links, 2) [m].
        tip: the last link's far end, (n, 2) [m].
        headings: direction of each link, (n, links) [rad].
    """

    joints: Array
    tip: Array
    headings: Array


def forward(robot: RobotSpec, q: Array) -> ChainPose:
    """Pose of every link.

    Args:
        robot: the chain.
        q: joint positions, (n, joints) [rad or m].
    """
    q = np.asarray(q, float)
    n = len(q)
    joints = np.empty((n, len(robot.links), 2))
    headings = np.empty((n, len(robot.links)))
    point = np.zeros((n, 2))
    heading = np.zeros(n)
    for i, link in enumerate(robot.links):
        if link.joint.type == "slide":
            point = point + q[:, i, None] * _direction(heading)
        else:
            heading = heading + q[:, i]
        joints[:, i] = point
        headings[:, i] = heading
        point = point + link.length * _direction(heading)
    return ChainPose(joints, point, headings)


def _direction(heading: Array) -> Array:
    return np.stack([np.cos(heading), np.sin(heading)], axis=-1)
