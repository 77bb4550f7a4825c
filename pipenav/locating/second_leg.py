"""Votes on the second leg: its heading, by the beams that end at its outer wall."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.locating.rays import Rays, weights

HEADINGS = np.deg2rad(np.arange(15.0, 151.0, 3.0))
"""Headings of the second leg that are tried [rad]."""

SIN, COS = np.sin(HEADINGS), np.cos(HEADINGS)
"""Sines and cosines of the headings, (headings,)."""


class WallVotes(NamedTuple):
    """Votes on walls, (r, edges, headings) each.

    Attributes:
        agree: votes of the beams that end at a wall.
        beyond: number of beams that end beyond it.
    """

    agree: Floats
    beyond: Ints


class SecondLegVotes(NamedTuple):
    """Votes on the second leg's outer wall, (k, r, edges, headings) each.

    Attributes:
        agree: votes of the beams that end at it.
        against: number of beams that end beyond it.
        share: share of `agree` in all beams that end past the first leg's walls.
    """

    agree: Floats
    against: Ints
    share: Floats


class OuterWall(NamedTuple):
    """Places where the second leg's outer wall may be.

    Attributes:
        edges: inner edges that are tried, (k, r, edges) [m].
        high: end of the inner wall at the latest, (k, r) [m].
        tee: whether the inner wall's line may be a wall again behind the opening, (k,).
    """

    edges: Floats
    high: Floats
    tee: Flags


def second_leg_votes(rays: Rays, radii: Floats, outer: OuterWall, tolerance: float) -> SecondLegVotes:
    """Votes on the second leg's outer wall.

    Args:
        rays: rays of k robots.
        radii: radii of the pipe, (k, r) [m].
        outer: where the wall may be.
        tolerance: largest distance from a wall of a beam that votes for it [m].
    """
    x, y = rays.end[:, None, :, 0], rays.end[:, None, :, 1]  # (k, 1, m)
    edges, before_edge = outer.edges, x <= outer.high[..., None]
    inner = (np.abs(y - radii[..., None]) <= tolerance) & (before_edge | outer.tee[:, None, None])
    ahead = rays.met[:, None] & ~inner & (y > tolerance - radii[..., None])  # (k, r, m)
    wall = edges[..., None] * SIN + radii[..., None, None] * (2 - COS)  # (k, r, edges, headings)
    agree, against = np.empty_like(wall), np.empty_like(wall, np.intp)
    for i, asked in enumerate(ahead):
        seen = np.flatnonzero(asked.any(axis=0))
        end = rays.end[i, seen]
        across = end[:, :1] * SIN - end[:, 1:] * COS  # (beams, headings)
        agree[i], against[i] = wall_votes(across, asked[:, seen], wall[i], tolerance)
    return SecondLegVotes(agree, against, agree / np.maximum(ahead.sum(axis=-1), 1)[..., None, None])


def wall_votes(across: Floats, asked: Flags, wall: Floats, tolerance: float) -> WallVotes:
    """Votes of beams on walls at which they end.

    Most beams are far from most walls: they are counted together, and only the others one by one, in their order.

    Args:
        across: ends of the beams, measured across each heading, (beams, headings) [m].
        asked: whether each beam has a say at each radius, (r, beams).
        wall: walls across each heading, from the nearest edge to the farthest, (r, edges, headings) [m].
        tolerance: largest distance from a wall of a beam that votes for it [m].
    """
    radii, edges, headings = wall.shape
    margin = 1.001 * tolerance  # rounding must not make a near beam far
    nearest, farthest, has_say = wall[:, :1], wall[:, -1:], asked[..., None]
    past = across > farthest + margin  # (r, beams, headings)
    near = np.flatnonzero((across >= nearest - margin) & has_say & ~past)

    # Each near beam belongs to one cell of (r, headings), in which it meets the walls of all edges.
    radius, heading = near // across.size, near % headings
    cell, cells = radius * headings + heading, radii * headings
    walls = wall.swapaxes(0, 1).reshape(edges, cells).take(cell, axis=1)  # (edges, near beams)
    beams = across.ravel()[near % across.size]
    off = np.subtract(beams, walls, out=walls)
    off /= tolerance

    # A beam beyond one wall is beyond the nearer walls too: count beams by how many walls they are beyond.
    passed = (off > 1.0).sum(axis=0)
    histogram = np.bincount(passed + cell * (edges + 1), minlength=cells * (edges + 1))
    at_least = histogram.reshape(radii, headings, edges + 1)[..., ::-1].cumsum(axis=2)[..., ::-1]
    beyond = at_least[..., 1:].swapaxes(1, 2)  # (r, edges, headings)

    agree: Floats = np.stack([np.bincount(cell, votes, cells) for votes in weights(off)])
    far = (has_say & past).sum(axis=1, dtype=np.int32)[:, None]
    return WallVotes(agree.reshape(edges, radii, headings).swapaxes(0, 1), beyond + far)
