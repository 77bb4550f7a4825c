"""A pipe's walls as boxes around a robot that stands at the origin: what a rigid-body simulator collides with."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.refusals import TooManyWalls
from pipenav.pipes.pipe import Pipe

WALL_HALF_HEIGHT = 0.05
"""Half height of a wall box [m]: taller than any robot, so that contacts lie in the plane."""

OUTER_THICKNESS = 0.02
"""Thickness of a wall box behind its face [m]: enough that nothing is pushed out at its back."""

INNER_THICKNESS = 1e-4
"""Thickness of the boxes next to a convex edge [m].

At an acute corner the square end of a box sticks out through the other leg's wall by thickness x cos(angle); a tenth
of a millimetre keeps that below the tolerance of the geometry. A link is pushed out on the side of its centre, so a
thin wall stops it as a thick one does until half the link is through.
"""

PARKED = 100.0
"""Height at which the wall boxes stand that a pipe does not need [m]."""


class WallBoxes(NamedTuple):
    """Walls of k robots in the robots' frames.

    Attributes:
        position, quaternion, half_size: pose and size of the boxes, (k, slots, 3), (k, slots, 4), (k, slots, 3) [m].
        segments: faces of the boxes, a pipe's last one repeated in the slots that are left over, (k, slots, 2, 2) [m].
    """

    position: Floats
    quaternion: Floats
    half_size: Floats
    segments: Floats


class Edge(NamedTuple):
    """Ends of boxes at a convex edge: their thickness there, and the gap between them and the edge [m]."""

    thickness: float = INNER_THICKNESS
    gap: float = 0.0


SHARP = Edge()
"""Boxes that meet at the edge itself."""


def wall_boxes(pipes: Sequence[Pipe], slots: int, base: Floats, edge: Edge = SHARP) -> WallBoxes:
    """Wall segments of each robot's pipe as boxes behind their faces; slots that are left over are parked far away.

    A robot's mount never moves, the walls come to it: `base` (k,), the origin of the robot's frame on the first leg's
    axis, is subtracted.

    Raises:
        TooManyWalls: a pipe has more wall segments than there are slots.
    """
    rows = np.array([_boxes(pipe, slots, edge) for pipe in pipes]).reshape(len(pipes), slots, -1)
    walls = WallBoxes(rows[..., :3], rows[..., 3:7], rows[..., 7:10], rows[..., 10:].reshape(len(pipes), slots, 2, 2))
    walls.position[..., 0] -= base[:, None]
    walls.segments[..., 0] -= base[:, None, None]
    return walls


@lru_cache(maxsize=4096)  # every pipe of the largest shipped training set
def _boxes(pipe: Pipe, slots: int, edge: Edge) -> Floats:
    """Boxes of one pipe in its own frame, one row each: position, quaternion, half size, both ends of the face.

    Where the free space is convex (the outer wall's vertices) a box runs on past the vertex by its thickness, so that
    no gap opens between neighbours; at an inner edge boxes end at the vertex and are thin.
    """
    if len(pipe.segments) > slots:
        raise TooManyWalls(pipe, slots)
    used = np.arange(slots) < len(pipe.segments)
    edges = np.ones((slots, 2), bool)
    edges[used] = pipe.edges
    segments = np.tile(pipe.segments[-1], (slots, 1, 1))
    segments[used] = pipe.segments
    start, end = segments[:, 0], segments[:, 1]  # (slots, 2)
    length = np.linalg.norm(end - start, axis=1)
    along = (end - start) / length[:, None]
    behind = np.stack([along[:, 1], -along[:, 0]], axis=1)  # the free space lies to the left
    thickness = np.where(edges.any(axis=1), edge.thickness, OUTER_THICKNESS)
    overlap = np.where(edges, -edge.gap, OUTER_THICKNESS)  # (slots, 2) past the start and past the end
    centre = (start + end + along * (overlap[:, 1:] - overlap[:, :1])) / 2 + behind * thickness[:, None] / 2
    yaw = np.arctan2(along[:, 1], along[:, 0])
    zero = np.zeros(slots)
    position = [centre, np.where(used, 0.0, PARKED)]
    quaternion = [np.cos(yaw / 2), zero, zero, np.sin(yaw / 2)]
    half_size = [length / 2 + overlap.mean(axis=1), thickness / 2, zero + WALL_HALF_HEIGHT]
    return np.column_stack([*position, *quaternion, *half_size, start, end])
