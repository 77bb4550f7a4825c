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
    ux, uy = np.cos(headings)[:, :, None], np.sin(headings)[:, :, None]  # (n, beams, 1)
    ax = (segments[:, :, 0, 0] - origins[:, None, 0])[:, None]  # (n, 1, s)
    ay = (segments[:, :, 0, 1] - origins[:, None, 1])[:, None]
    ex = (segments[:, :, 1, 0] - segments[:, :, 0, 0])[:, None]
    ey = (segments[:, :, 1, 1] - segments[:, :, 0, 1])[:, None]
    determinant = ux * ey - uy * ex  # (n, beams, s)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (ax * ey - ay * ex) / determinant
        s = (ax * uy - ay * ux) / determinant
        hit = (t >= 0) & (s >= 0) & (s <= 1)
    return np.asarray(np.where(hit, t, np.inf).min(axis=2))


def measure(laser: Laser, distances: Array) -> Array:
    """What the sensor returns for true distances: rounded to its resolution, clipped to its range. Any shape [m]."""
    reachable = np.clip(distances, laser.range_min, laser.range_max)
    rounded = np.round(reachable / laser.resolution) * laser.resolution
    return np.asarray(np.clip(rounded, laser.range_min, laser.range_max))
