"""Outline of a robot in its plane, for many poses at once."""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.robots import kinematics
from pipenav.robots.parts import BoxPart, DiscPart
from pipenav.robots.robot import RobotSpec

DISC_POINTS = 48
"""Points that stand for a disc: chords between them stay within 0.04 mm of a disc of 36 mm."""


def link_outlines(robot: RobotSpec, q: Floats) -> list[list[Floats]]:
    """Convex polygons of the parts and the wheel of every link, each (n, points, 2) [m] in the robot's frame.

    Args:
        robot: description of the robot.
        q: configurations, (n, coordinates) [rad or m].
    """
    pose = kinematics.forward(robot, q)
    along = np.stack([np.cos(pose.headings), np.sin(pose.headings)], axis=-1)  # (n, links, 2)
    across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    outlines = []
    for i, link in enumerate(robot.links):
        polygons = []
        for x, y in map(_part_outline, link.outline):
            from_joint = x[:, None] * along[:, i, None] + y[:, None] * across[:, i, None]
            polygons.append(pose.joints[:, i, None] + from_joint)  # (n, points, 2)
        outlines.append(polygons)
    return outlines


def _part_outline(part: BoxPart | DiscPart) -> Floats:
    """Corners of a part in its link's frame, x and y, (2, points) [m], counter-clockwise."""
    if isinstance(part, BoxPart):
        corners = np.array([[-1, 1, 1, -1], [-1, -1, 1, 1]]) / 2 * [[part.length], [part.width]]
    else:
        phi = np.arange(DISC_POINTS) * 2 * math.pi / DISC_POINTS
        corners = part.diameter / 2 * np.stack([np.cos(phi), np.sin(phi)])
    return np.asarray(corners + np.array([[part.x], [part.y]]))


def foremost(robot: RobotSpec, q: Floats) -> Floats:
    """Largest x of any point of the robot, in its own frame, (n,) [m]."""
    polygons = [polygon for link in link_outlines(robot, q) for polygon in link]
    return np.asarray(np.max([polygon[..., 0].max(axis=1) for polygon in polygons], axis=0))
