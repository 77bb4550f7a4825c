"""Overlap of a robot with the walls of a pipe in the plane, by geometry alone: no simulator takes part.

The overlap of two shapes is the depth of the deepest corner of one in the other: the least way that one of them must
move for that corner to come out. A disc's is its radius less the distance of its middle to the wall.
"""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.certify.shapes import Shapes

TOGETHER = 1 << 18
"""Most pairs of a pose and a wall segment that are looked at together: some tens of megabytes."""

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""Corners of a box, in halves of its sides, (4, 2)."""

SAME_POINT = 1e-9
"""Distance below which two ends of segments are one corner of the wall [m]."""


def overlaps(shapes: Shapes, segments: Floats, joints: Floats, headings: Floats) -> Floats:
    """Deepest overlap of any part with any wall in n poses, (n,) [m]; 0 where they do not meet.

    Beyond its open ends a pipe has no walls.

    Args:
        shapes: parts of the robot.
        segments: wall segments, free space on the left of each, as `Pipe.segments`, (s, 2, 2) [m].
        joints: points where the links start, in the pipe's frame, (n, links, 2) [m].
        headings: directions of the links, (n, links) [rad].
    """
    deepest, step = np.zeros(len(joints)), max(1, TOGETHER // len(segments))
    boxes, discs = shapes.boxes, shapes.discs
    for first in range(0, len(joints), step):
        rows = slice(first, first + step)
        for link, centre, radius in zip(discs.link, discs.centre, discs.radius, strict=True):
            middle = _placed(joints[rows, link], headings[rows, link], centre[None])[:, 0]
            deepest[rows] = np.maximum(deepest[rows], radius + _outside(middle, segments))
        for link, centre, half in zip(boxes.link, boxes.centre, boxes.half, strict=True):
            at, heading = joints[rows, link], headings[rows, link]
            corners = _placed(at, heading, centre + CORNERS * half)
            outside = np.stack([_outside(corner, segments) for corner in corners.transpose(1, 0, 2)]).max(axis=0)
            middle = _placed(at, heading, centre[None])
            inside = _in_box(_turned(segments[None] - middle[:, None], -heading), half)
            deepest[rows] = np.maximum(deepest[rows], np.maximum(outside, inside))
    return deepest


def _placed(joints: Floats, headings: Floats, points: Floats) -> Floats:
    """Points of a link, (p, 2), in n poses: (n, p, 2)."""
    every = np.broadcast_to(points, (len(joints), *points.shape))
    return np.asarray(joints[:, None] + _turned(every[:, :, None], headings)[:, :, 0])


def _turned(points: Floats, angles: Floats) -> Floats:
    """Points (n, a, b, 2) turned by an angle each, (n,) [rad]."""
    cos, sin = np.cos(angles)[:, None, None], np.sin(angles)[:, None, None]
    x, y = points[..., 0], points[..., 1]
    return np.stack([x * cos - y * sin, x * sin + y * cos], axis=-1)


def _outside(points: Floats, segments: Floats) -> Floats:
    """Distance of points to the nearest wall, positive in the wall, negative in the free space, (n,) [m].

    At a corner two segments are equally near: the one that is seen more from the side says where the point is. A point
    beyond an open end is in no wall.
    """
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    length = np.hypot(along[:, 0], along[:, 1])
    away = points[:, None] - start  # (n, s, 2)
    share = (away * along).sum(axis=-1) / length**2
    nearest = away - np.clip(share, 0.0, 1.0)[..., None] * along
    distance = np.hypot(nearest[..., 0], nearest[..., 1])
    right = (along[:, 1] * away[..., 0] - along[:, 0] * away[..., 1]) / length  # positive on the wall's side
    least = distance.min(axis=1, keepdims=True)
    near = distance <= least + SAME_POINT
    which = np.where(near, np.abs(right), -1.0).argmax(axis=1)[:, None]
    side = np.take_along_axis(right, which, axis=1)[:, 0]
    at = np.take_along_axis(share, which, axis=1)[:, 0]
    before, after = _open_ends(segments)
    beyond = ((at < 0) & before[which[:, 0]]) | ((at > 1) & after[which[:, 0]])
    return np.asarray(np.where((side > 0) & ~beyond, least[:, 0], -least[:, 0]))


def _open_ends(segments: Floats) -> tuple[Flags, Flags]:
    """Flags of the segments whose first end, and of those whose last end, no other segment has, (s,) each."""
    first, last = segments[:, 0], segments[:, 1]
    apart = np.hypot(*np.moveaxis(first[:, None] - last, -1, 0)) > SAME_POINT  # (s, s)
    return apart.all(axis=1), apart.all(axis=0)


def _in_box(segments: Floats, half: Floats) -> Floats:
    """Depth of the deepest point of any segment in a box about the origin, (n,) [m]; 0 where none enters it.

    Along a segment the distance to each side of the box is linear, and the depth is the least of the four: it is
    largest at an end, or where two of them are equal.

    Args:
        segments: segments in the frames of n boxes, (n, s, 2, 2) [m].
        half: half sides of the box, (2,) [m].
    """
    reach = np.hypot(*half)
    low, high = segments.min(axis=2), segments.max(axis=2)
    pose, which = np.nonzero(((low < reach) & (high > -reach)).all(axis=-1))
    deepest = np.zeros(len(segments))
    if not len(pose):
        return deepest
    near = segments[pose, which]  # (m, 2, 2)
    start, along = near[:, 0], near[:, 1] - near[:, 0]
    room = np.concatenate([half - start, half + start], axis=1)  # (m, 4): to each side, at the segment's first end
    slope = np.concatenate([-along, along], axis=1)
    one, other = np.triu_indices(4, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        equal = (room[:, other] - room[:, one]) / (slope[:, one] - slope[:, other])
    share = np.concatenate([np.zeros((len(near), 1)), np.ones((len(near), 1)), np.nan_to_num(equal)], axis=1)
    share = np.clip(share, 0.0, 1.0)  # (m, 8)
    depth = (room[:, None] + share[..., None] * slope[:, None]).min(axis=-1).max(axis=1)
    np.maximum.at(deepest, pose, np.maximum(depth, 0.0))
    return deepest
