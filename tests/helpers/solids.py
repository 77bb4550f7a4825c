"""Solids read back from their files, and the points that lie inside of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from manifold3d import Manifold, Mesh64

from helpers.pipe_oracle import PipeOracle
from pipenav.arrays import Flags, Floats
from pipenav.export.corner_folder import write_stl
from pipenav.pipes.corner_solids import Mesh

RAYS = np.array([[0.48, 0.6, 0.64], [-0.36, 0.48, -0.8]])
"""Directions of the rays that are counted."""

NEAR = 1e-4
"""Distance from a surface up to which a mesh may differ from it [m]."""


def read_back(mesh: Mesh, folder: Path) -> trimesh.Trimesh:
    """A mesh, written as STL and read again, its vertices merged."""
    write_stl(folder / "solid.stl", mesh)
    return trimesh.load(folder / "solid.stl")


def inside(body: trimesh.Trimesh, points: Floats) -> Flags:
    """Flags of points (n, 3) inside a closed surface, by rays in single precision, and by exact ones where two differ.

    Args:
        body: the surface.
        points: points in its own unit.
    """
    flags = []
    for direction in RAYS:
        _, ray, _ = body.ray.intersects_location(points, np.tile(direction, (len(points), 1)), multiple_hits=True)
        flags.append(np.bincount(ray, minlength=len(points)) % 2 == 1)
    found, disputed = flags[0].copy(), np.flatnonzero(flags[0] != flags[1])
    if len(disputed):
        faces = np.ascontiguousarray(body.faces.astype(np.uint64))
        solid, far = Manifold(Mesh64(np.ascontiguousarray(body.vertices, float), faces)), 4 * body.scale
        assert not solid.is_empty(), solid.status()
        for i in disputed:
            found[i] = len(solid.ray_cast(tuple(points[i]), tuple(points[i] + far * RAYS[0]))) % 2 == 1
    return found


def differing(body: trimesh.Trimesh, oracle: PipeOracle, rng: np.random.Generator, count: int) -> Floats:
    """Points in and around pipes at which a tube in millimetres and the oracle differ, (n, 3) [m].

    Points within `NEAR` of a surface are left out: polygons stand for circles.
    """
    points = oracle.around(count, rng)
    bore, outside = oracle.bore(points), oracle.outside(points)
    sure = (np.abs(bore) > NEAR) & (np.abs(outside) > NEAR)
    points, expected = points[sure], ((outside < 0) & (bore > 0))[sure]
    assert sure.mean() > 0.9 and 0.05 < expected.mean() < 0.95
    return points[inside(body, 1e3 * points) != expected]
