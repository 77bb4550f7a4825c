"""Forward kinematics of a planar chain, for n robots at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.robots.robot import BASE, RobotSpec


class ChainPose(NamedTuple):
    """Poses of the links of n robots, in the robot's frame (rear end of the first link at rest, x forwards).

    Attributes:
        joints: points where the links start, (n, links, 2) [m].
        tip: far end of the last link, (n, 2) [m].
        headings: directions of the links, (n, links) [rad].
    """

    joints: Floats
    tip: Floats
    headings: Floats


def forward(robot: RobotSpec, configuration: Floats) -> ChainPose:
    """Poses of all links.

    Args:
        robot: description of the chain.
        configuration: joint positions, before them the first link's pose if the robot is free, (n, coordinates) [rad
            or m].
    """
    values = np.asarray(configuration, float).T  # robots come last, the long axis along which numpy is fast
    start = values[:2] if robot.free else np.zeros((2, values.shape[1]))
    values = values[2 * robot.free :]  # a free robot's heading stands where a mounted one's first joint stands
    turning, lengths = robot.link_turns[:, None], robot.lengths[:, None]
    headings = np.cumsum(np.where(turning, values, 0.0), axis=0)  # (links, n)
    along = np.array([np.cos(headings), np.sin(headings)])  # (2, links, n)
    # Steps in order: along a link's slide, then along the link. Hinges add nothing to the first kind.
    steps = np.empty((2, 2 * len(headings), values.shape[1]))
    steps[:, 0::2] = np.where(turning, 0.0, values) * along
    steps[:, 1::2] = lengths * along
    points = start[:, None] + np.cumsum(steps, axis=1)
    return ChainPose(points[:, 0::2].transpose(2, 1, 0), points[:, -1].T, headings.T)


def waypoints(robot: RobotSpec, configuration: Floats) -> Floats:
    """Rear end, joints and tip of n robots in their own frames, (n, links + 1, 2) [m].

    Args:
        robot: description of the chain.
        configuration: joint positions as `forward` takes them, (n, coordinates) [rad or m].
    """
    pose = forward(robot, configuration)
    return np.concatenate([pose.joints, pose.tip[:, None]], axis=1)


def configuration(robot: RobotSpec, q: Floats, tip: Floats) -> Floats:
    """Configurations from joint positions and, for a free robot, the pose of its tip: (n, coordinates).

    Args:
        robot: description of the chain.
        q: joint positions, (n, joints) [rad or m].
        tip: position and heading of the tip in the robot's frame, (n, 3) [m, m, rad].
    """
    if not robot.free:
        return np.array(q, float)
    seen = np.concatenate([np.zeros((len(q), len(BASE))), q], axis=1)
    pose = forward(robot, seen)  # the first link lies at the origin until the tip is moved to where it is seen
    heading = tip[:, 2] - pose.headings[:, -1]
    cos, sin = np.cos(heading), np.sin(heading)
    x, y = pose.tip.T
    seen[:, 0], seen[:, 1] = tip[:, 0] - (cos * x - sin * y), tip[:, 1] - (sin * x + cos * y)
    seen[:, 2] = heading
    return seen
