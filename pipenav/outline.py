"""The robot's outline in its plane, for many poses at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipenav import kinematics
from pipenav.robot import RobotSpec

Array = NDArray[np.float64]


def link_outlines(robot: RobotSpec, q: Array) -> list[list[Array]]:
    """For every link the convex polygons that make it up, each (n, points, 2) [m] in the robot's frame.

    Args:
        robot: the robot.
        q: joint positions, (n, joints) [rad or m].
    """
    pose = kinematics.forward(robot, q)
    along = np.stack([np.cos(pose.headings), np.sin(pose.headings)], axis=-1)  # (n, links, 2)
    across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    outlines = []
    for i, link in enumerate(robot.links):
        x, y = (np.array([[0, -1], [1, -1], [1, 1], [0, 1]]) * [link.length, link.width / 2]).T
        sides = x[:, None] * along[:, i, None] + y[:, None] * across[:, i, None]
        outlines.append([pose.joints[:, i, None] + sides])
    return outlines


def foremost(robot: RobotSpec, q: Array) -> Array:
    """The largest x of any point of the robot, in its own frame, (n,) [m]."""
    polygons = [polygon for link in link_outlines(robot, q) for polygon in link]
    return np.asarray(np.max([polygon[..., 0].max(axis=1) for polygon in polygons], axis=0))
