"""Convex prisms of a route's wall: their faces, and points in them."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.system_solids import PRISM_FACES


def faces_of(prisms: Floats) -> tuple[Floats, Floats]:
    """Outward normals and offsets of every prism's faces: n x <= d inside, (..., 12, 3) and (..., 12)."""
    a, b, c = np.moveaxis(prisms[..., PRISM_FACES, :], -2, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return normal, (normal * a).sum(axis=-1)


def depth_in_any(prisms: Floats, points: Floats) -> Floats:
    """Depth of points (p, 3) in the prism that holds them deepest, negative outside of all: (p,) [m]."""
    normal, offset = (x.reshape(-1, 12, *x.shape[3:]) for x in faces_of(prisms))
    outside = np.einsum("pi,kfi->pkf", points, normal) - offset  # (p, prisms, 12)
    return np.asarray(-outside.max(axis=2).min(axis=1))
