"""Routes with tees, crosses or caps as solids: their tube, their boards, and their wall as convex pieces.

The pipes of a fitting are halves of cylinders that begin at the crossing of its axes. The tube is the union of all
pipes' outsides without the union of their bores. The wall is, for each pipe, the prisms around it without the bores of
the fitting's other pipes, cut into convex pieces by the planes of those bores.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.branch_pipes import reaches
from pipenav.pipes.corner_solids import MESH_GRID_MM, Faces, Mesh, mesh_of
from pipenav.pipes.route import PipeRoute
from pipenav.units import mm_to_m

if TYPE_CHECKING:
    from manifold3d import Manifold

BEYOND = 1e-3
"""Length by which bores run on past open ends before they are cut out [m]."""

LEAST_VOLUME = 1e-12
"""Volume of a piece of wall below which it is dropped [m3]: a thousandth of a cubic millimetre."""

LEAST_DEPTH = 1e-7
"""Depth to which a prism must reach into a bore to be cut [m]: what touches the bore stays whole."""


class ConvexPiece(NamedTuple):
    """A convex part of a wall: vertices (v, 3) [m], and triangles (t, 3), counter-clockwise seen from outside."""

    vertices: Floats
    faces: Faces


PRISM_FACES: Faces = np.array(
    [[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]]
    + [[i, 4 + i, 4 + (i + 1) % 4] for i in range(4)]
    + [[i, 4 + (i + 1) % 4, (i + 1) % 4] for i in range(4)]
)
"""Triangles of a prism between two quadrilaterals, counter-clockwise seen from outside, (12, 3)."""


class _End(NamedTuple):
    """End of a section.

    Attributes:
        direction: unit vector along the section's axis, out of it, (3,).
        fitting: number of the tee or cross there; None for an end of the whole.
        pipe: which of the fitting's pipes the section is there.
        closed: whether a cap closes it.
    """

    direction: Floats
    fitting: int | None = None
    pipe: int = 0
    closed: bool = False


class _Section(NamedTuple):
    """Part of a route between two fittings or ends, or a branch.

    Attributes:
        lines: lines along its surface, (lines, stations, 3) [m].
        start, end: its two ends.
    """

    lines: Floats
    start: _End
    end: _End


class _Round(NamedTuple):
    """Lines around a section: their angles, (lines,) [rad], the factor on the radius, and chords of the corners."""

    around: Floats
    factor: float
    chords: Sequence[int]


def fitting_tube_mesh(route: PipeRoute, around: Floats, chords: Sequence[int]) -> Mesh:
    """The hollow tube of a route with branches or a cap.

    Args:
        route: the route.
        around: angles of the lines that stand for a circle, (lines,) [rad].
        chords: number of chords of each corner.
    """
    lines = _Round(around, 1.0, chords)
    outside = _union(_sections(route, route.wall, lines), 0.0, route.wall)
    tube = outside - _union(_sections(route, 0.0, lines), BEYOND, 0.0)
    return _mesh(tube)


def fitting_boards_mesh(route: PipeRoute) -> Mesh:
    """The boards of a planar route with branches or a cap: its walls, as high as the first diameter.

    Raises:
        PipenavError: the route leaves the plane.
    """
    from manifold3d import CrossSection, FillRule

    outlines = [np.concatenate([face, back[::-1]]) for face, back in route.wall_sides]
    boards = CrossSection(outlines, FillRule.NonZero).extrude(route.diameter)
    return _mesh(boards.translate((0.0, 0.0, -route.diameter / 2)))


def _mesh(made: Manifold) -> Mesh:
    mesh = made.simplify(2 * MESH_GRID_MM * mm_to_m(1.0)).to_mesh64()
    return mesh_of(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64), mirrored=False)


def fitting_wall_pieces(route: PipeRoute, facets: int, thickness: float, chords: Sequence[int]) -> list[ConvexPiece]:
    """The wall of a route with branches or a cap as convex pieces.

    Args:
        route: the route.
        facets: sides of the polygon that stands for the bore.
        thickness: thickness of the wall [m].
        chords: number of chords of each corner.
    """
    lines = _Round((np.arange(facets) - 0.5) * 2 * math.pi / facets, 1 / math.cos(math.pi / facets), chords)
    bores = {i: _bores(route, i, facets) for i in np.flatnonzero(route.legs.taper == 0).tolist()}
    pieces: list[ConvexPiece] = []
    for near, far in zip(_sections(route, 0.0, lines), _sections(route, thickness, lines), strict=True):
        ring = np.stack([near.lines, np.roll(near.lines, -1, 0), np.roll(far.lines, -1, 0), far.lines], axis=2)
        rings = ring.swapaxes(0, 1)  # (stations, facets, 4, 3)
        for prisms, ends in _prisms(route, near, rings, thickness):
            for prism in prisms:
                pieces += _without(prism, [bore for end in ends for bore in _others(bores, end)])
        for end, edge in ((near.start, far.lines[:, 0]), (near.end, far.lines[:, -1])):
            if end.closed:
                pieces.append(_hull(np.concatenate([edge, edge + thickness * end.direction])))
    return pieces


def _sections(route: PipeRoute, outside: float, lines: _Round) -> list[_Section]:
    """The sections of a route, so much wider than their bores [m]: the route's own in order, then its branches."""
    legs, branches = route.legs, route.branches
    drawn = legs.lines((legs.radius + outside)[None] * lines.factor, lines.around, lines.chords)
    fittings = np.flatnonzero(legs.taper == 0).tolist()
    last_station = np.cumsum([count + 1 for count in lines.chords])
    parts = np.split(drawn, [int(last_station[i]) for i in fittings], axis=1)
    starts = [_End(-legs.axes[0, :, 0]), *(_End(-legs.axes[i + 1, :, 0], i, 1) for i in fittings)]
    ends = [*(_End(legs.axes[i, :, 0], i, 0) for i in fittings), _End(legs.axes[-1, :, 0], closed=route.capped)]
    sections = [_Section(*part) for part in zip(parts, starts, ends, strict=True)]
    for b, corner in enumerate(branches.corner.tolist()):
        along, left, up = branches.axes[b].T
        radius = (branches.radius[b] + outside) * lines.factor
        sideways = radius * (np.cos(lines.around)[:, None] * left + np.sin(lines.around)[:, None] * up)
        ring = branches.start[b] + sideways
        pipe = 2 + int((branches.corner[:b] == corner).sum())
        far = _End(along, closed=bool(branches.closed[b]))
        stations = np.stack([ring, ring + branches.length[b] * along], axis=1)
        sections.append(_Section(stations, _End(-along, corner, pipe), far))
    return sections


def _union(sections: Sequence[_Section], past_open: float, past_closed: float) -> Manifold:
    """The union of sections as solids, longer at ends that are open and at those that are closed [m]."""
    from manifold3d import Manifold, OpType

    solids = []
    for section in sections:
        lines = section.lines.copy()
        for end, station in ((section.start, 0), (section.end, -1)):
            if end.fitting is None:
                lines[:, station] += (past_closed if end.closed else past_open) * end.direction
        solids.append(_solid(lines))
    return Manifold.batch_boolean(solids, OpType.Add)


def _solid(lines: Floats) -> Manifold:
    """The solid within lines (lines, stations, 3), which run counter-clockwise seen from its start."""
    from manifold3d import Manifold, Mesh64

    points = lines.swapaxes(0, 1)  # (stations, lines, 3)
    stations, count = points.shape[:2]
    middles = points[[0, -1]].mean(axis=1)
    vertices, index = np.unique(
        np.round(np.concatenate([points.reshape(-1, 3), middles]), 9) + 0.0, axis=0, return_inverse=True
    )
    grid = np.arange(stations * count).reshape(stations, count)
    a, b = grid[:-1], grid[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    first, last, after = grid[0], grid[-1], stations * count
    faces: Faces = np.concatenate(
        [
            *(np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, d, c), (a, c, b))),
            np.stack([np.full(count, after), np.roll(first, -1), first], axis=1),
            np.stack([np.full(count, after + 1), last, np.roll(last, -1)], axis=1),
        ]
    )
    faces = index.reshape(-1)[faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    made = Manifold(Mesh64(np.ascontiguousarray(vertices), np.ascontiguousarray(faces.astype(np.uint64))))
    assert not made.is_empty() and made.volume() > 0, made.status()
    return made


def _prisms(
    route: PipeRoute, section: _Section, rings: Floats, thickness: float
) -> Iterator[tuple[Floats, list[_End]]]:
    """Prisms of a section's wall, (facets, 8, 3) [m] each time, with the ends whose fittings they reach.

    Straights beside a fitting are cut where the fitting's openings end, so that the rest of them stays whole.
    """
    last = len(rings) - 2
    for k in range(last + 1):
        first_ring, last_ring = rings[k], rings[k + 1]
        ends = [end for end, at in ((section.start, 0), (section.end, last)) if at == k and end.fitting is not None]
        long = [_reach(route, end, thickness) for end in ends]
        shortest = float(np.linalg.norm(last_ring - first_ring, axis=-1).min())
        if sum(long) >= shortest:
            yield np.concatenate([first_ring, last_ring], axis=1), ends
            continue
        cuts = [first_ring]
        parts: list[list[_End]] = []
        for end, reach in zip(ends, long, strict=True):
            if end is section.start:
                cuts.append(first_ring - reach * end.direction)
                parts.append([end])
        parts.append([])
        if ends and ends[-1] is section.end:
            cuts.append(last_ring - long[-1] * section.end.direction)
            parts.append([section.end])
        cuts.append(last_ring)
        for (one, other), reached in zip(pairwise(cuts), parts, strict=True):
            yield np.concatenate([one, other], axis=1), reached


def _reach(route: PipeRoute, end: _End, thickness: float) -> float:
    """Reach of a fitting's openings along one of its pipes, in walls of a thickness [m]."""
    assert end.fitting is not None
    before, after = (2 * route.legs.radius[end.fitting : end.fitting + 2]).tolist()
    # The polygon's corners lie a little outside of the bore.
    return float(1.05 * reaches(route.corners[end.fitting], before, after, thickness)[end.pipe])


class _Bore(NamedTuple):
    """The bore of a pipe of a fitting, as the points x with normals @ x <= offsets: (planes, 3) and (planes,) [m]."""

    normals: Floats
    offsets: Floats


def _bores(route: PipeRoute, fitting: int, facets: int) -> list[_Bore]:
    """Bores of the pipes of a fitting: the leg before, the leg after, and its branches."""
    legs, branches = route.legs, route.branches
    here = np.flatnonzero(branches.corner == fitting)
    before = legs.axes[fitting] * np.array([-1.0, 1.0, 1.0])
    axes = [before, legs.axes[fitting + 1], *branches.axes[here]]
    radii = [*legs.radius[fitting : fitting + 2], *branches.radius[here]]
    around = np.arange(facets) * 2 * math.pi / facets
    bores = []
    for (along, left, up), radius in zip((one.T for one in axes), radii, strict=True):
        sides = np.cos(around)[:, None] * left + np.sin(around)[:, None] * up
        normals = np.concatenate([-along[None], sides])
        bores.append(_Bore(normals, normals @ legs.start[fitting + 1] + np.append(0.0, np.full(facets, radius))))
    return bores


def _others(bores: dict[int, list[_Bore]], end: _End) -> list[_Bore]:
    """Bores of a fitting's other pipes than the one that ends there."""
    assert end.fitting is not None
    return [bore for i, bore in enumerate(bores[end.fitting]) if i != end.pipe]


def _without(prism: Floats, bores: Sequence[_Bore]) -> list[ConvexPiece]:
    """Convex pieces of a prism's vertices (8, 3) that lie in none of the bores."""
    pieces = [ConvexPiece(prism, PRISM_FACES)]
    for bore in bores:
        pieces = [part for piece in pieces for part in _outside(piece, bore)]
    return pieces


def _outside(piece: ConvexPiece, bore: _Bore) -> list[ConvexPiece]:
    """Convex parts of a convex piece outside of a bore, cut by one of its planes after the other."""
    from manifold3d import Manifold

    depth = bore.offsets - piece.vertices @ bore.normals.T  # (v, planes)
    if (depth.max(axis=0) < LEAST_DEPTH).any():
        return [piece]
    parts: list[ConvexPiece] = []
    rest = Manifold.hull_points(piece.vertices)
    for i in np.flatnonzero(depth.min(axis=0) < -LEAST_DEPTH):
        normal = bore.normals[i].tolist()
        cut, rest = rest.split_by_plane((normal[0], normal[1], normal[2]), float(bore.offsets[i]))
        if cut.volume() > LEAST_VOLUME:
            parts.append(_piece(cut))
        if rest.volume() < LEAST_VOLUME:
            break
    return parts


def _hull(points: Floats) -> ConvexPiece:
    from manifold3d import Manifold

    return _piece(Manifold.hull_points(points))


def _piece(made: Manifold) -> ConvexPiece:
    mesh = made.to_mesh64()
    return ConvexPiece(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64))
