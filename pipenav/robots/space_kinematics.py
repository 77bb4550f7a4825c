"""Poses of robots in space: the planar chain, whose front half is turned by the roll joint, in a free frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.robots import kinematics
from pipenav.robots.robot import BASE, RobotSpec


class SpacePose(NamedTuple):
    """Poses of n robots in the route's frame.

    Attributes:
        points: rear end, joints and tip, (n, links + 1, 3) [m].
        halves: axes of the halves of the divided link as columns, (n, halves, 3, 3).
        tip: axes of the last link as columns, (n, 3, 3).
    """

    points: Floats
    halves: Floats
    tip: Floats


def placed(q: Floats, base: Floats, plane: Floats) -> Floats:
    """Position [m] and quaternion of the first link of robots that lie in a plane, (k, 7).

    Args:
        q: configurations in the robots' frames, (k, coordinates) [rad or m].
        base: origin of each robot's frame on the first leg's axis, (k,) [m].
        plane: angle of each robot's plane about that axis, (k,) [rad].
    """
    x, y, heading = q[:, : len(BASE)].T
    (cx, sx), (cz, sz) = ((np.cos(angle / 2), np.sin(angle / 2)) for angle in (plane, heading))
    position = [x + base, y * np.cos(plane), y * np.sin(plane)]
    return np.stack(
        [*position, cx * cz, sx * cz, -sx * sz, cx * sz], axis=1
    )  # turned about x, and then about its own z


def forward(robot: RobotSpec, base: Floats, q: Floats, roll: Floats) -> SpacePose:
    """Poses of all links.

    Args:
        robot: the robot, with a roll joint.
        base: position [m] and quaternion of each first link, (n, 7).
        q: joint positions, (n, joints) [rad or m].
        roll: positions of the roll joints, (n,) [rad].
    """
    assert robot.roll is not None
    divided = [link.name for link in robot.links].index(robot.roll.link)
    flat = kinematics.forward(robot, np.concatenate([np.zeros((len(q), len(BASE))), q], axis=1))
    points = np.zeros((len(q), len(robot.links) + 1, 3))
    points[:, :-1, :2], points[:, -1, :2] = flat.joints, flat.tip
    body, rear, head = rotation(base[:, 3:]), _about_z(flat.headings[:, divided]), _about_z(flat.headings[:, -1])
    turn = rear @ _about_x(roll) @ rear.swapaxes(1, 2)  # of the front half, about the divided link
    pivot = points[:, divided, None].copy()
    front = points[:, divided + 1 :]
    points[:, divided + 1 :] = pivot + (front - pivot) @ turn.swapaxes(1, 2)
    return SpacePose(
        base[:, None, :3] + points @ body.swapaxes(1, 2),
        np.stack([body @ rear, body @ turn @ rear], axis=1),
        body @ turn @ head,
    )


def rotation(quaternion: Floats) -> Floats:
    """Rotations of quaternions of any length, (n, 4) -> (n, 3, 3)."""
    w, x, y, z = (quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def _about_x(angle: Floats) -> Floats:
    c, s, zero, one = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.moveaxis(np.array([[one, zero, zero], [zero, c, -s], [zero, s, c]]), -1, 0)


def _about_z(angle: Floats) -> Floats:
    c, s, zero, one = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.moveaxis(np.array([[c, -s, zero], [s, c, zero], [zero, zero, one]]), -1, 0)
