"""How far a robot's links stay from the walls of a pipe, exactly, for many poses at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipenav import kinematics
from pipenav.pipe import Pipe
from pipenav.robot import RobotSpec

Array = NDArray[np.float64]


def clearance(robot: RobotSpec, pipe: Pipe, q: Array, base: float) -> Array:
    """Smallest signed distance of any link to any wall, (...) [m]; negative where they overlap.

    Links are rectangles. The outer wall bounds a convex space: every corner of a link is on the near side of each of
    its lines. The inner wall bounds a convex obstacle: link and obstacle are as far apart as along the best of their
    edges' normals. That is the exact distance between an edge and a corner, and less than it between two corners.

    Args:
        robot: the robot.
        pipe: the pipe.
        q: joint positions in the pipe's turn, (..., joints) [m, rad].
        base: where the robot's frame starts on the first leg's axis, x in the pipe's frame [m].
    """
    poses = q.reshape(-1, q.shape[-1])
    chain = kinematics.forward(robot, poses)
    start = chain.joints + np.array([base, 0.0])  # (p, links, 2)
    length = np.array([link.length for link in robot.links])[:, None]
    half = np.array([link.width / 2 for link in robot.links])[:, None]
    along = np.stack([np.cos(chain.headings), np.sin(chain.headings)], axis=-1)  # (p, links, 2)
    across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    sides = [start + half * across, start - half * across]
    corners = np.stack([*sides, *(side + length * along for side in sides)], axis=2)  # (p, links, 4, 2)
    beyond_walls = _inside(corners, pipe.segments)  # (p, links, 4, segments)
    count = len(pipe.walls.outer) - 1
    outer = beyond_walls[..., :count].min(axis=(2, 3))
    inner = beyond_walls[..., count:].min(axis=2).max(axis=-1)
    to_wall = pipe.walls.inner - start[:, :, None]  # (p, links, points, 2)
    x = np.einsum("plvi,pli->plv", to_wall, along)
    y = np.einsum("plvi,pli->plv", to_wall, across)
    ends = np.maximum(x.min(axis=-1) - length[:, 0], -x.max(axis=-1))
    flanks = np.maximum(y.min(axis=-1), -y.max(axis=-1)) - half[:, 0]
    apart = np.maximum(inner, np.maximum(ends, flanks))
    return np.asarray(np.minimum(outer, apart).min(axis=1).reshape(q.shape[:-1]))


def _inside(points: Array, segments: Array) -> Array:
    """Distance of points (..., 2) to the lines of segments (s, 2, 2), positive on their left: (..., s)."""
    d = segments[:, 1] - segments[:, 0]
    normal = np.stack([-d[:, 1], d[:, 0]], axis=1) / np.linalg.norm(d, axis=1, keepdims=True)
    return np.asarray(points @ normal.T - (normal * segments[:, 0]).sum(axis=1))
