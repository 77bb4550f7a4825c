"""Rotations about the axes of a frame, and points of the plane in space."""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats


def about_x(angle: float) -> Floats:
    """Rotation about x, (3, 3)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def about_z(angle: float) -> Floats:
    """Rotation about z, (3, 3)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def in_space(points: Floats) -> Floats:
    """Points (..., 2) of the x-y plane as points (..., 3)."""
    points = np.asarray(points, float)
    if points.shape[-1] == 3:
        return points
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)
