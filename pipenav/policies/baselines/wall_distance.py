"""Distance of a robot's links from the walls of a pipe, for many poses at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import frames, kinematics
from pipenav.robots.kinematics import ChainPose
from pipenav.robots.parts import BoxPart, DiscPart
from pipenav.robots.robot import RobotSpec


class _PartPose(NamedTuple):
    """Pose of one part of a link in p poses of the robot.

    Attributes:
        middle: middle of the part in the pipe's frame, (p, 2) [m].
        along: unit vectors along the link, (p, 2).
        across: unit vectors to the left of the link, (p, 2).
    """

    middle: Floats
    along: Floats
    across: Floats


def wall_distance(robot: RobotSpec, pipe: PipeCorner, q: Floats, base: float) -> Floats:
    """Smallest signed distance of any link or wheel to any wall, (...) [m]; negative where they overlap.

    The outer wall bounds a convex space: every point of a part is on the near side of each of its lines. The inner wall
    bounds a convex obstacle: a box and it are as far apart as along the best of their edges' normals. That is the exact
    distance between an edge and a corner, and less than the distance between two corners. Discs are exact.

    Args:
        robot: the robot.
        pipe: the pipe.
        q: configurations in the pipe's turn, (..., coordinates) [m, rad].
        base: origin of the robot's frame on the first leg's axis, x in the pipe's frame [m].
    """
    chain = kinematics.forward(robot, q.reshape(-1, q.shape[-1]))
    distances = []
    for i, link in enumerate(robot.links):
        boxes = [part for part in link.outline if isinstance(part, BoxPart)]
        discs = [part for part in link.outline if isinstance(part, DiscPart)]
        distances += [_box_distance(pipe, _part_pose(chain, i, part, base), part) for part in boxes]
        distances += [_disc_distance(pipe, _part_pose(chain, i, part, base).middle, part) for part in discs]
    return np.asarray(np.min(distances, axis=0).reshape(q.shape[:-1]))


def _part_pose(chain: ChainPose, link: int, part: BoxPart | DiscPart, base: float) -> _PartPose:
    heading = chain.headings[:, link]
    along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    middle = frames.robot_to_pipe(chain.joints[:, link], base) + part.x * along + part.y * across
    return _PartPose(middle, along, across)


def _box_distance(pipe: PipeCorner, pose: _PartPose, part: BoxPart) -> Floats:
    middle, along, across = pose
    half = np.array([part.length, part.width]) / 2
    signs = np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]]) * half
    corners = middle[:, None] + signs[:, :1] * along[:, None] + signs[:, 1:] * across[:, None]  # (p, 4, 2)
    beyond_walls = _inside(corners, pipe.segments)  # (p, 4, segments)
    count = len(pipe.walls.outer) - 1
    outer = beyond_walls[..., :count].min(axis=(1, 2))
    inner = beyond_walls[..., count:].min(axis=1).max(axis=-1)
    to_wall = pipe.walls.inner - middle[:, None]  # (p, points, 2)
    axes = np.stack([along, across], axis=1)  # (p, 2, 2)
    local = np.einsum("pvi,pai->pva", to_wall, axes)
    apart = np.maximum(local.min(axis=1), -local.max(axis=1)) - half  # (p, 2)
    return np.asarray(np.minimum(outer, np.maximum(inner, apart.max(axis=1))))


def _disc_distance(pipe: PipeCorner, middle: Floats, part: DiscPart) -> Floats:
    inside = _inside(middle, pipe.segments)  # (p, segments)
    count = len(pipe.walls.outer) - 1
    start, end = pipe.segments[count:, 0], pipe.segments[count:, 1]
    step = end - start
    share = np.einsum("psi,si->ps", middle[:, None] - start, step) / (step**2).sum(axis=1)
    nearest = start + np.clip(share, 0.0, 1.0)[..., None] * step  # (p, segments, 2)
    to_obstacle = np.linalg.norm(middle[:, None] - nearest, axis=2).min(axis=1)
    inner = np.where(inside[:, count:].max(axis=1) > 0, to_obstacle, inside[:, count:].max(axis=1))
    return np.asarray(np.minimum(inside[:, :count].min(axis=1), inner) - part.diameter / 2)


def _inside(points: Floats, segments: Floats) -> Floats:
    """Distance of points (..., 2) to the lines of segments (s, 2, 2), positive on their left: (..., s)."""
    d = segments[:, 1] - segments[:, 0]
    normal = np.stack([-d[:, 1], d[:, 0]], axis=1) / np.linalg.norm(d, axis=1, keepdims=True)
    return np.asarray(points @ normal.T - (normal * segments[:, 0]).sum(axis=1))
