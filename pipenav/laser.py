"""What the laser fan reads in a pipe, for n robots at once: ray against wall segment, then the sensor's own limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipenav.robot import Laser

Array = NDArray[np.float64]


def cast(origins: Array, headings: Array, segments: Array) -> Array:
    """True distance along each ray to the nearest wall; inf where it meets none.

    Solves `origin + t u = a + s (b - a)` by cross products; a hit has t >= 0 and 0 <= s <= 1.

    Args:
        origins: ray origins, (n, 2) [m].
        headings: ray directions, (n, beams) [rad].
        segments: wall segments of each robot's pipe, (n, s, 2, 2) [m].

    Returns:
        (n, beams) [m].
    """
    # Robots come last, the long axis along which numpy is fast.
    heading, wall = headings.T, segments.transpose(1, 2, 3, 0)  # (beams, n), (s, 2, 2, n)
    ux, uy = np.cos(heading), np.sin(heading)
    ax, ay = np.ascontiguousarray(wall[:, None, 0] - origins.T).transpose(2, 0, 1, 3)  # (s, 1, n) each
    ex, ey = np.ascontiguousarray(wall[:, None, 1] - wall[:, None, 0]).transpose(2, 0, 1, 3)
    determinant = ux * ey - uy * ex  # (s, beams, n)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (ax * ey - ay * ex) / determinant
        s = (ax * uy - ay * ux) / determinant
        hit = (t >= 0) & (s >= 0) & (s <= 1)
    return np.ascontiguousarray(np.where(hit, t, np.inf).min(axis=0).T)


def measure(laser: Laser, distances: Array) -> Array:
    """What the sensor returns for true distances: rounded to its resolution, clipped to its range. Any shape [m]."""
    reachable = np.clip(distances, laser.range_min, laser.range_max)
    rounded = np.round(reachable / laser.resolution) * laser.resolution
    return np.asarray(np.clip(rounded, laser.range_min, laser.range_max))
