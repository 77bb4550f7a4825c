"""Votes on the first leg: the pipe's radius, and the stretch in which its inner wall ends."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.locating.rays import Rays, ordered, packed, pick, weights

RADII = np.arange(0.020, 0.1505, 0.001)
"""Radii that are tried [m]: radii of the pipes that can be made."""

HIDDEN = 0.1
"""Length of the stretch before the first beam past the inner wall in which that wall may end, if no beam met it [m]."""

LEFTWARDS = 0.05
"""Least sine of a beam's heading that tells where it crosses the inner wall: flatter beams cross it too far away."""


class EdgeRange(NamedTuple):
    """Stretch of the line y = radius in which the inner wall ends, (k, r) [m]; NaN where it can end nowhere."""

    low: Floats
    high: Floats


class _Crossings(NamedTuple):
    """Crossings of beams with the line y = radius, in the order of their x; crossings that tell nothing come last.

    Attributes:
        x: x of each crossing, (k, r, m) [m].
        wall: whether the beam ended there, at the inner wall, (k, r, m).
        free: whether the beam went on, past the inner wall's end, (k, r, m).
    """

    x: Floats
    wall: Flags
    free: Flags


def radius_votes(rays: Rays, radii: Floats, tolerance: float, tee: Flags) -> Floats:
    """Votes for radii: beams that end at the outer wall, y = -radius, less those that end beyond it, (k, r).

    In a tee the outer wall may open before the inner one does. Beams that end at either wall vote there.

    Args:
        rays: rays of k robots.
        radii: radii to vote on, (k, r) or (1, r) [m].
        tolerance: largest distance from a wall of a beam that votes for it [m].
        tee: whether the outer wall can open too, so that a beam may end beyond it, (k,).
    """
    below = -rays.end[..., 1]
    below = packed(below, rays.met & (below > radii.min() - 2 * tolerance))
    off = (below[..., None] - radii[:, None]) / tolerance  # (k, m, r)
    beyond = off > 1.0
    votes = weights(off)
    votes -= beyond & ~tee[:, None, None]
    total = votes.sum(axis=1)
    if tee.any():
        above = packed(rays.end[..., 1], rays.met & tee[:, None])
        total += weights((above[..., None] - radii[:, None]) / tolerance).sum(axis=1)
    return np.asarray(total)


def edge_range(rays: Rays, radii: Floats, tolerance: float, range_min: float) -> EdgeRange:
    """The stretch of the line y = radius in which the inner wall ends: fewest beams contradict it.

    Args:
        rays: rays of k robots.
        radii: radii of the pipe, (k, r) [m].
        tolerance: largest distance from a wall of a beam that ends at it [m].
        range_min: least reading of the laser [m].
    """
    x, wall, free = _crossings(rays, radii, tolerance, range_min)
    walls = wall.sum(axis=-1, keepdims=True)
    walls_before, free_before = np.cumsum(wall, axis=-1), np.cumsum(free, axis=-1)
    # An edge in gap j lies between crossings j - 1 and j: walls behind it and free crossings before it contradict it.
    contradicting = np.concatenate([walls, walls - walls_before + free_before], axis=-1)
    best = contradicting == contradicting.min(axis=-1, keepdims=True)
    first_gap, last_gap = best.argmax(axis=-1), best.shape[-1] - 1 - best[..., ::-1].argmax(axis=-1)
    telling = walls[..., 0] + free.sum(axis=-1)
    high = np.where(last_gap < telling, pick(x, last_gap), np.nan)
    return EdgeRange(np.where(first_gap > 0, pick(x, first_gap - 1), high - HIDDEN), high)


def _crossings(rays: Rays, radii: Floats, tolerance: float, range_min: float) -> _Crossings:
    tip, direction, end, near = rays.tip[:, None], rays.direction[:, None], rays.end[:, None], rays.near[:, None]
    rise = direction[..., 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        length = (radii[..., None] - tip[..., 1]) / rise  # (k, r, m), as all below
        x = tip[..., 0] + length * direction[..., 0]
    height = end[..., 1] - radii[..., None]
    leftwards = (rise > LEFTWARDS) & (length > 0)
    wall = leftwards & np.where(near, length <= range_min, np.abs(height) <= tolerance)
    free = leftwards & ~near & (height > tolerance)
    first_free = np.where(free, x, np.inf).min(axis=-1)
    wall &= x < (first_free + radii)[..., None]  # farther on, it is the second leg's outer wall that crosses y = r
    order = np.where(wall | free, x, np.inf).argsort(axis=-1, kind="stable")
    return _Crossings(ordered(x, order), ordered(wall, order), ordered(free, order))
