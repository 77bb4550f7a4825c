"""Forward kinematics of a planar chain, for n robots at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.robots.robot import BASE, RobotSpec


class ChainPose(NamedTuple):
    """Where the links of n robots are, in the robot's frame (rear end of the first link at rest, x forwards).

    Attributes:
        joints: where each link starts, (n, links, 2) [m].
        tip: the last link's far end, (n, 2) [m].
        headings: direction of each link, (n, links) [rad].
    """

    joints: Floats
    tip: Floats
    headings: Floats


def forward(robot: RobotSpec, configuration: Floats) -> ChainPose:
    """Pose of every link.

    Args:
        robot: the chain.
        configuration: joint positions, of a free robot its first link's pose before them, (n, coordinates) [rad or m].
    """
    values = np.asarray(configuration, float).T  # robots come last, the long axis along which numpy is fast
    start = values[:2] if robot.free else np.zeros((2, values.shape[1]))
    values = values[2 * robot.free :]  # a free robot's heading stands where a mounted one's first joint stands
    turning, lengths = robot.link_turns[:, None], robot.lengths[:, None]
    headings = np.cumsum(np.where(turning, values, 0.0), axis=0)  # (links, n)
    along = np.array([np.cos(headings), np.sin(headings)])  # (2, links, n)
    # Way points in order: each link's start after its slide, then its end. Hinges add nothing to the first kind.
    ways = np.empty((2, 2 * len(headings), values.shape[1]))
    ways[:, 0::2] = np.where(turning, 0.0, values) * along
    ways[:, 1::2] = lengths * along
    points = start[:, None] + np.cumsum(ways, axis=1)
    return ChainPose(points[:, 0::2].transpose(2, 1, 0), points[:, -1].T, headings.T)


def waypoints(robot: RobotSpec, configuration: Floats) -> Floats:
    """Rear end, joints and tip of n robots in their own frames, (n, links + 1, 2) [m].

    Args:
        robot: the chain.
        configuration: as `forward` takes it, (n, coordinates) [rad or m].
    """
    pose = forward(robot, configuration)
    return np.concatenate([pose.joints, pose.tip[:, None]], axis=1)


def configuration(robot: RobotSpec, q: Floats, tip: Floats) -> Floats:
    """Configurations from joint positions and, of a free robot, the pose of its tip: (n, coordinates).

    Args:
        robot: the chain.
        q: joint positions, (n, joints) [rad or m].
        tip: position and heading of the tip in the robot's frame, (n, 3) [m, m, rad].
    """
    if not robot.free:
        return np.array(q, float)
    seen = np.concatenate([np.zeros((len(q), len(BASE))), q], axis=1)
    pose = forward(robot, seen)  # as it lies from the first link, which is turned to where the tip is seen
    heading = tip[:, 2] - pose.headings[:, -1]
    cos, sin = np.cos(heading), np.sin(heading)
    x, y = pose.tip.T
    seen[:, 0], seen[:, 1] = tip[:, 0] - (cos * x - sin * y), tip[:, 1] - (sin * x + cos * y)
    seen[:, 2] = heading
    return seen
