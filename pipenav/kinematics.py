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
    headings = np.cumsum(np.where(robot.hinges, q, 0.0), axis=1)
    along = np.stack([np.cos(headings), np.sin(headings)], axis=-1)  # (n, links, 2)
    # Way points in order: each link's start after its slide, then its end. Hinges add nothing to the first kind.
    ways = np.empty((len(q), 2 * len(robot.links), 2))
    ways[:, 0::2] = np.where(robot.hinges, 0.0, q)[..., None] * along
    ways[:, 1::2] = robot.lengths[:, None] * along
    points = np.cumsum(ways, axis=1)
    return ChainPose(points[:, 0::2], points[:, -1], headings)
