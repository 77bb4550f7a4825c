"""The tube of a system of pipes with tees, crosses or caps as one solid, and solids made fit for a file.

Strands that are in line at a fitting and have one bore make one solid, which runs on through the fitting. So the
polygons that stand for their bores meet corner to corner, and the branches alone have to be joined.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner_lines import ARC_TOLERANCE
from pipenav.pipes.corner_solids import MESH_GRID_MM, Faces, Mesh, mesh_of, round_angles
from pipenav.pipes.pipe_system import PipeSystem, Strand, StrandEnd, stations
from pipenav.units import mm_to_m

if TYPE_CHECKING:
    from manifold3d import Manifold

BEYOND = 1e-3
"""Length by which bores run on past open ends before they are cut out [m]."""

IN_LINE = 1e-3
"""Angle within which two strands of one bore run on as one solid [rad]: that within which networks call them so."""

ROUNDS = 20
"""Rounds in which a solid's points are rounded before it counts as one that cannot be written."""

CRUMB = 1e-10
"""Volume below which a loose part of a solid is none [m3]: what rounding leaves, a tenth of a cubic millimetre."""


class _Step(NamedTuple):
    """A strand of a row, and whether the row runs through it from its end to its start."""

    strand: int
    backwards: bool


def system_tube_mesh(system: PipeSystem) -> Mesh:
    """The hollow tube of a system: the union of all outsides without the union of all bores."""
    around = round_angles(max(float(strand.legs.radius.max()) for strand in system.strands) + system.wall)
    rows = _rows(system)
    outside = _union(system, rows, system.wall, around, (0.0, system.wall))
    return welded(outside - _union(system, rows, 0.0, around, (BEYOND, 0.0)))


def welded(made: Manifold) -> Mesh:
    """A solid as a mesh every edge of which belongs to two triangles after its points were rounded.

    Rounding can lay edges on each other, whose triangles then are simplified away.
    """
    from manifold3d import Manifold, Mesh64

    tolerance = 2 * MESH_GRID_MM * mm_to_m(1.0)
    for _ in range(ROUNDS):
        mesh = made.simplify(tolerance).to_mesh64()
        points, triangles = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64)
        rounded = mesh_of(points, triangles, mirrored=False)
        corners = np.sort(np.concatenate([rounded.faces[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
        if (np.unique(corners, axis=0, return_counts=True)[1] == 2).all():
            break
        tolerance *= 1.2
        vertices = np.ascontiguousarray(rounded.vertices * mm_to_m(1.0))
        whole = Manifold(Mesh64(vertices, np.ascontiguousarray(rounded.faces.astype(np.uint64))))
        made = Manifold.compose([part for part in whole.decompose() if part.volume() > CRUMB])
    return rounded


def _rows(system: PipeSystem) -> list[list[_Step]]:
    """The strands in rows, each of which runs on through the fittings."""
    ends = {(i, last): end for i, strand in enumerate(system.strands) for last, end in enumerate(_ends(strand))}
    joined: dict[tuple[int, int], tuple[int, int]] = {}
    for one, other in combinations(ends, 2):
        if one not in joined and other not in joined and _in_line(system, ends[one], ends[other]):
            joined[one], joined[other] = other, one
    left, rows = set(range(len(system.strands))), []
    # A row begins where no other strand joins it; what is left then are rings, which begin anywhere.
    for begin in sorted(ends, key=lambda end: end in joined):
        if begin[0] in left:
            row, entered = [], begin
            while entered[0] in left:
                left.remove(entered[0])
                row.append(_Step(entered[0], bool(entered[1])))
                entered = joined.get((entered[0], 1 - entered[1]), entered)
            rows.append(row)
    return rows


def _ends(strand: Strand) -> tuple[StrandEnd, StrandEnd]:
    return strand.start, strand.end


def _in_line(system: PipeSystem, one: StrandEnd, other: StrandEnd) -> bool:
    """Whether one strand runs on in another: the same fitting, the same bore, and opposite directions."""
    if one.fitting is None or one.fitting != other.fitting:
        return False
    radius = system.fittings[one.fitting].radius
    same_bore = abs(radius[one.pipe] - radius[other.pipe]) < 1e-9
    return bool(same_bore and np.linalg.norm(one.direction + other.direction) < IN_LINE)


def _union(
    system: PipeSystem, rows: Sequence[Sequence[_Step]], outside: float, around: Floats, past: tuple[float, float]
) -> Manifold:
    """The union of all rows as solids, so much wider than their bores [m], and longer at open and at closed ends."""
    from manifold3d import Manifold, OpType

    return Manifold.batch_boolean([_solid(_lines(system, row, outside, around, past)) for row in rows], OpType.Add)


def _lines(
    system: PipeSystem, row: Sequence[_Step], outside: float, around: Floats, past: tuple[float, float]
) -> Floats:
    """Lines along a row, which run counter-clockwise seen from its start, (lines, stations, 3) [m]."""
    parts: list[Floats] = []
    sideways = np.zeros((0, 3))
    for step in row:
        strand = system.strands[step.strand]
        first, last = (-1, 0) if step.backwards else (0, -1)
        if parts:
            angles = np.arctan2(sideways @ strand.legs.axes[first, :, 2], sideways @ strand.legs.axes[first, :, 1])
        else:
            angles = -around if step.backwards else around
        lines = stations(strand.legs, outside, angles, ARC_TOLERANCE / 4)
        for end, station in ((strand.start, 0), (strand.end, -1)):
            if end.fitting is None:
                lines[:, station] += past[end.closed] * end.direction
        lines = lines[:, ::-1] if step.backwards else lines
        left, up = strand.legs.axes[last, :, 1], strand.legs.axes[last, :, 2]
        sideways = np.cos(angles)[:, None] * left + np.sin(angles)[:, None] * up
        parts.append(lines[:, 1:] if parts else lines)
    return np.concatenate(parts, axis=1)


def _solid(lines: Floats) -> Manifold:
    """The solid within lines (lines, stations, 3), which run counter-clockwise seen from its start."""
    from manifold3d import Manifold, Mesh64

    points = lines.swapaxes(0, 1)  # (stations, lines, 3)
    count, around = points.shape[:2]
    middles = points[[0, -1]].mean(axis=1)
    vertices, index = np.unique(
        np.round(np.concatenate([points.reshape(-1, 3), middles]), 9) + 0.0, axis=0, return_inverse=True
    )
    grid = np.arange(count * around).reshape(count, around)
    a, b = grid[:-1], grid[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    first, last, after = grid[0], grid[-1], count * around
    faces: Faces = np.concatenate(
        [
            *(np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, d, c), (a, c, b))),
            np.stack([np.full(around, after), np.roll(first, -1), first], axis=1),
            np.stack([np.full(around, after + 1), last, np.roll(last, -1)], axis=1),
        ]
    )
    faces = index.reshape(-1)[faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    made = Manifold(Mesh64(np.ascontiguousarray(vertices), np.ascontiguousarray(faces.astype(np.uint64))))
    assert not made.is_empty() and made.volume() > 0, made.status()
    return made
