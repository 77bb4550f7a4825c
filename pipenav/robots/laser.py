"""Readings of the laser fan in a pipe, for n robots at once: ray against wall segment, then the sensor's own limits."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats
from pipenav.robots.parts import Laser


def cast(origins: Floats, headings: Floats, segments: Floats) -> Floats:
    """True distance along each ray to the nearest wall; inf for a ray that meets no wall.

    Solves `origin + t u = a + s (b - a)` by cross products; a hit has t >= 0 and 0 <= s <= 1.

    Args:
        origins: ray origins, (n, 2) [m].
        headings: ray directions, (n, beams) [rad].
        segments: wall segments of each robot's pipe, (n, s, 2, 2) [m].

    Returns:
        (n, beams) [m].
    """
    # Robots come last, the long axis along which numpy is fast; arrays that lie so in memory already are not copied.
    heading, (start, end) = np.ascontiguousarray(headings.T), segments.T.swapaxes(0, 1)  # (beams, n), (2, s, n) each
    ux, uy = np.cos(heading), np.sin(heading)
    ax, ay = np.ascontiguousarray(start - origins.T[:, None])[:, :, None]  # (s, 1, n) each
    ex, ey = np.ascontiguousarray(end - start)[:, :, None]
    determinant = ux * ey - uy * ex  # (s, beams, n)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (ax * ey - ay * ex) / determinant
        s = (ax * uy - ay * ux) / determinant
        hit = (t >= 0) & (s >= 0) & (s <= 1)
    return np.ascontiguousarray(np.where(hit, t, np.inf).min(axis=0).T)


def measure(laser: Laser, distances: Floats) -> Floats:
    """Readings of the sensor for true distances of any shape [m]: rounded to its resolution, clipped to its range."""
    reachable = np.asarray(distances).clip(laser.range_min, laser.range_max)
    return np.asarray((np.rint(reachable / laser.resolution) * laser.resolution).clip(laser.range_min, laser.range_max))
