"""Convex bodies in space: whether two of them are apart."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats

ROUNDS = 1000
"""Rounds after which two bodies count as too near: only bodies at almost exactly the asked distance need so many."""


def apart(a: Floats, b: Floats, distance: float) -> bool:
    """Whether the convex hulls of points (n, 3) and (m, 3) are farther apart than a distance above 0 [m].

    Gilbert's method: `between` is the shortest known vector from one hull to the other. Along it, the hulls are at
    least as far apart as their farthest points towards each other, and at most as far as it is long.
    (E. G. Gilbert, "An iterative procedure for computing the minimum of a quadratic form on a convex set", 1966.)
    """
    between = a.mean(axis=0) - b.mean(axis=0)
    for _ in range(ROUNDS):
        nearest = a[(a @ between).argmin()] - b[(b @ between).argmax()]
        length = float(np.linalg.norm(between))
        if length <= distance:
            return False
        if nearest @ between > distance * length:
            return True
        step = between - nearest
        between = between - min(float(between @ step) / float(step @ step), 1.0) * step
    return False
