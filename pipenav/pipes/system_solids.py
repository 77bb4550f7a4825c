"""Walls of systems of pipes with tees, crosses or caps: their boards in the plane, and convex pieces in space."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner_solids import Faces, Mesh
from pipenav.pipes.pipe_system import Fitting, PipeSystem, Polygon, Strand, StrandEnd, leg_rings
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.system_tubes import welded

if TYPE_CHECKING:
    from manifold3d import Manifold

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


def fitting_boards_mesh(route: PipeRoute) -> Mesh:
    """The boards of a planar route with branches or a cap: its walls, as high as the first diameter.

    Raises:
        PipenavError: the route leaves the plane.
    """
    from manifold3d import CrossSection, FillRule

    outlines = [np.concatenate([face, back[::-1]]) for face, back in route.wall_sides]
    boards = CrossSection(outlines, FillRule.NonZero).extrude(route.diameter)
    return welded(boards.translate((0.0, 0.0, -route.diameter / 2)))


class StrandWall(NamedTuple):
    """The wall of a strand.

    Attributes:
        prisms: whole prisms, (pieces, sides, 8, 3) [m], one piece after the other along the strand.
        uncut: prisms beside a fitting that reach into no other pipe's bore, (n, 8, 3) [m].
        cut: what other pipes' bores leave of the prisms beside a fitting, and the discs of caps.
    """

    prisms: Floats
    uncut: Floats
    cut: list[ConvexPiece]


def strand_walls(system: PipeSystem, polygon: Polygon, thickness: float, deviation: float) -> list[StrandWall]:
    """The wall of every strand: its prisms without the bores of its fittings' other pipes.

    Args:
        system: the system.
        polygon: section of the bore.
        thickness: thickness of the wall [m].
        deviation: see `bend_chords`.
    """
    bores = [_bores(fitting, polygon) for fitting in system.fittings]
    walls = []
    for strand in system.strands:
        rings = leg_rings(strand.legs, polygon, thickness, deviation)
        whole, uncut, cut = [], [], []
        for prisms, ends in _prisms(system, strand, rings, thickness):
            if not ends:
                whole.append(prisms)
                continue
            for prism in prisms:
                parts = _without(prism, [bore for end in ends for bore in _others(bores, end)])
                if len(parts) == 1 and parts[0].vertices is prism:
                    uncut.append(prism)
                else:
                    cut += parts
        for end, edge in ((strand.start, rings[0, :, 3]), (strand.end, rings[-1, :, 3])):
            if end.closed:
                cut.append(_hull(np.concatenate([edge, edge + thickness * end.direction])))
        shape = (-1, *rings.shape[1:2], 8, 3)
        walls.append(StrandWall(np.array(whole).reshape(shape), np.array(uncut).reshape(-1, 8, 3), cut))
    return walls


def system_wall_pieces(system: PipeSystem, polygon: Polygon, thickness: float, deviation: float) -> list[ConvexPiece]:
    """The wall of a system as convex pieces, see `strand_walls`."""
    pieces: list[ConvexPiece] = []
    for wall in strand_walls(system, polygon, thickness, deviation):
        prisms = [*wall.prisms.reshape(-1, 8, 3), *wall.uncut]
        pieces += [*(ConvexPiece(prism, PRISM_FACES) for prism in prisms), *wall.cut]
    return pieces


def _prisms(
    system: PipeSystem, strand: Strand, rings: Floats, thickness: float
) -> Iterator[tuple[Floats, list[StrandEnd]]]:
    """Prisms of a strand's wall, (facets, 8, 3) [m] each time, with the ends whose fittings they reach.

    Straights beside a fitting are cut where the fitting's openings end, so that the rest of them stays whole.
    """
    last = len(rings) - 2
    for k in range(last + 1):
        first_ring, last_ring = rings[k], rings[k + 1]
        here = [end for end, at in ((strand.start, 0), (strand.end, last)) if at == k and end.fitting is not None]
        # A branch that leaves the other way opens nothing here, and a prism of no length would be none.
        ends = [end for end in here if _reach(system, end, thickness) > LEAST_DEPTH]
        long = [_reach(system, end, thickness) for end in ends]
        shortest = float(np.linalg.norm(last_ring - first_ring, axis=-1).min())
        if sum(long) >= shortest:
            yield np.concatenate([first_ring, last_ring], axis=1), ends
            continue
        cuts = [first_ring]
        parts: list[list[StrandEnd]] = []
        for end, reach in zip(ends, long, strict=True):
            if end is strand.start:
                cuts.append(first_ring - reach * end.direction)
                parts.append([end])
        parts.append([])
        if ends and ends[-1] is strand.end:
            cuts.append(last_ring - long[-1] * strand.end.direction)
            parts.append([strand.end])
        cuts.append(last_ring)
        for (one, other), reached in zip(pairwise(cuts), parts, strict=True):
            yield np.concatenate([one, other], axis=1), reached


def _reach(system: PipeSystem, end: StrandEnd, thickness: float) -> float:
    """Reach of a fitting's openings along one of its pipes, in walls of a thickness [m]."""
    assert end.fitting is not None
    return 1.05 * system.fittings[end.fitting].reach(end.pipe, thickness)  # the polygon's corners lie outside the bore


class _Bore(NamedTuple):
    """The bore of a pipe of a fitting, as the points x with normals @ x <= offsets: (planes, 3) and (planes,) [m]."""

    normals: Floats
    offsets: Floats


def _bores(fitting: Fitting, polygon: Polygon) -> list[_Bore]:
    """Bores of the pipes of a fitting."""
    around = polygon.middles
    bores = []
    for axes, radius in zip(fitting.axes, fitting.radius.tolist(), strict=True):
        along, left, up = axes.T
        sides = np.cos(around)[:, None] * left + np.sin(around)[:, None] * up
        normals = np.concatenate([-along[None], sides])
        bores.append(
            _Bore(
                normals,
                normals @ fitting.centre + np.append(0.0, np.full(polygon.sides, radius * (1 - polygon.inside))),
            )
        )
    return bores


def _others(bores: Sequence[list[_Bore]], end: StrandEnd) -> list[_Bore]:
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
