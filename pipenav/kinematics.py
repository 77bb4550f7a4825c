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
    q = np.asarray(q, float).T  # robots come last, the long axis along which numpy is fast
    hinges, lengths = robot.hinges[:, None], robot.lengths[:, None]
    headings = np.cumsum(np.where(hinges, q, 0.0), axis=0)  # (links, n)
    along = np.array([np.cos(headings), np.sin(headings)])  # (2, links, n)
    # Way points in order: each link's start after its slide, then its end. Hinges add nothing to the first kind.
    ways = np.empty((2, 2 * len(headings), q.shape[1]))
    ways[:, 0::2] = np.where(hinges, 0.0, q) * along
    ways[:, 1::2] = lengths * along
    points = np.cumsum(ways, axis=1)
    return ChainPose(points[:, 0::2].transpose(2, 1, 0), points[:, -1].T, headings.T)
