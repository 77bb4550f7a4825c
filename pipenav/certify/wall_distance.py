"""Distances of boxes and points to wall segments, by which motions are tested."""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""Corners of a box of half size 1 in order around it."""


def placed(points: Floats, headings: Floats, centre: Floats) -> Floats:
    """Places of a point of a link, (2,) in its frame, in n poses of the link, (n, 2) [m]."""
    cos, sin = np.cos(headings), np.sin(headings)
    x, y = centre
    return np.asarray(points + np.stack([x * cos - y * sin, x * sin + y * cos], axis=-1))


def to_segments(points: Floats, segments: Floats) -> Floats:
    """Smallest distance of points, (n, 2), to segments, (s, 2, 2): (n,) [m]."""
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    away = points[:, None] - start
    share = np.clip((away * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
    return np.asarray(np.hypot(*np.moveaxis(away - share[..., None] * along, -1, 0)).min(axis=1))


def box_to_segments(segments: Floats, half: Floats) -> Floats:
    """Smallest distance of a box about the origin to segments, (n, s, 2, 2): (n,) [m]; 0 where one enters it.

    Segments that are further from the box's middle than the nearest one by more than half its diagonal do not count.
    """
    start, along = segments[..., 0, :], segments[..., 1, :] - segments[..., 0, :]
    share = np.clip(-(start * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
    away = start + share[..., None] * along
    middle = np.hypot(away[..., 0], away[..., 1])
    near = middle <= middle.min(axis=1, keepdims=True) + math.hypot(*half)
    least = np.full(near.shape, np.inf)
    least[near] = _box_to_each(segments[near], half)
    return np.asarray(least.min(axis=1))


def _box_to_each(segments: Floats, half: Floats) -> Floats:
    """Distance of a box about the origin to segments, (n, 2, 2): (n,) [m]; 0 where it enters.

    The two are nearest at an end of the segment or at a corner of the box, unless they meet.
    """
    ends = np.maximum(np.abs(segments) - half, 0.0)
    least = np.hypot(ends[..., 0], ends[..., 1]).min(axis=1)
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    for corner in SQUARE * half:
        away = corner - start
        share = np.clip((away * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
        gap = away - share[..., None] * along
        least = np.minimum(least, np.hypot(gap[..., 0], gap[..., 1]))
    # A segment meets the box where its stretches inside of the two pairs of sides have something in common.
    with np.errstate(divide="ignore", invalid="ignore"):
        bounds = np.sort(np.stack([(-half - start) / along, (half - start) / along]), axis=0)
    parallel = np.abs(along) < 1e-15
    within = np.abs(start) <= half
    enter = np.where(parallel, np.where(within, -np.inf, np.inf), bounds[0]).max(axis=-1)
    leave = np.where(parallel, np.where(within, np.inf, -np.inf), bounds[1]).min(axis=-1)
    meets = np.maximum(enter, 0.0) <= np.minimum(leave, 1.0)
    return np.asarray(np.where(meets, 0.0, least))
