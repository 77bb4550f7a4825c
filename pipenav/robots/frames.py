"""Points in the three frames of a planar robot, and the conversions between them.

- Pipe frame: the first corner is the origin, the first leg lies along -x, a left turn goes towards +y.
- Robot frame: its origin is the rear end of the first link at rest, `base` along the pipe frame's x axis.
- Canonical frame: the robot frame with every turn a left turn; for a right turn y changes its sign.

Arrays of points are (..., 2) [m]; `base` and `turn_sign` are one number for all points or (...).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pipenav.arrays import Floats


def robot_to_canonical(points: ArrayLike, turn_sign: ArrayLike) -> Floats:
    """Points of the robot frame in the canonical frame; `turn_sign` is +1 for a left turn, -1 for a right one."""
    sign = np.asarray(turn_sign, float)
    return np.asarray(np.asarray(points, float) * np.stack([np.ones_like(sign), sign], axis=-1))


def canonical_to_robot(points: ArrayLike, turn_sign: ArrayLike) -> Floats:
    """Points of the canonical frame in the robot frame; the reflection is its own inverse."""
    return robot_to_canonical(points, turn_sign)


def robot_to_pipe(points: ArrayLike, base: ArrayLike) -> Floats:
    """Points of the robot frame in the pipe frame; `base` is the robot frame's origin on the pipe's x axis [m]."""
    offset = np.asarray(base, float)
    return np.asarray(np.asarray(points, float) + np.stack([offset, np.zeros_like(offset)], axis=-1))


def pipe_to_robot(points: ArrayLike, base: ArrayLike) -> Floats:
    """Points of the pipe frame in the robot frame; `base` is the robot frame's origin on the pipe's x axis [m]."""
    offset = np.asarray(base, float)
    return np.asarray(np.asarray(points, float) - np.stack([offset, np.zeros_like(offset)], axis=-1))


def canonical_to_pipe(points: ArrayLike, turn_sign: ArrayLike, base: ArrayLike) -> Floats:
    """Points of the canonical frame in the pipe frame."""
    return robot_to_pipe(canonical_to_robot(points, turn_sign), base)
