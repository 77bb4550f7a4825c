"""The walls of a planar route: segments, inner edges and sides; in a tee or a cross they run into the branches too.

Without branches a wall is a line along the route. With branches the free space is the union of its pipes, and its
outline is cut where the pipes are open.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.pipes.branch_pipes import BranchPipes
from pipenav.pipes.pipe import WallSide
from pipenav.pipes.route_legs import Legs, frozen

if TYPE_CHECKING:
    import shapely

FLAT = 1e-9
"""Sine of the angle between two segments below which they are one straight wall."""

ROUNDING = 1e-8
"""Distance from a straight line below which a point lies on it [m]."""

SAME = 1e-7
"""Distance between points that are the same one [m]: what a union of shapes rounds is far below it."""


class PlanarWalls(NamedTuple):
    """The walls of a planar route; the arrays are read-only.

    Attributes:
        segments: segments `[[x1, y1], [x2, y2]]`, free space on the left of each, (s, 2, 2) [m]. They go along the
            right wall, into every branch and back, and then back along the left wall.
        edges: flags of segment ends that lie at an inner edge, (s, 2); an open end counts as its segment's other end.
        sides: the walls from open end to open end, each with its back.
    """

    segments: Floats
    edges: Flags
    sides: list[WallSide]


def plain_walls(legs: Legs, wall: float) -> PlanarWalls:
    """The walls of a route without branches, the sides from the first open end to the last: left, then right.

    Args:
        legs: legs of the route.
        wall: wall thickness [m].
    """
    left, right = (legs.line(legs.radius, around)[:, :2].copy() for around in (0.0, math.pi))
    lines = [right, left[::-1]]
    segments = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
    backs = [legs.line(legs.radius + wall, around)[:, :2] for around in (0.0, math.pi)]
    sides = [WallSide(frozen(left), backs[0]), WallSide(frozen(right), backs[1])]
    return PlanarWalls(frozen(segments), _plain_edges(legs), sides)


def branched_walls(legs: Legs, branches: BranchPipes, wall: float, capped: bool) -> PlanarWalls:
    """The walls of a route with branches in its plane, the sides in the order of the segments.

    Args:
        legs: legs of the route.
        branches: its branches.
        wall: wall thickness [m].
        capped: whether a cap closes the far end.
    """
    faces, backs = (_outline(legs, branches, outside, capped) for outside in (0.0, wall))
    segments = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in faces])
    edges = np.concatenate([_edges(line) for line in faces])
    return PlanarWalls(frozen(segments), edges, [WallSide(*pair) for pair in zip(faces, backs, strict=True)])


def _plain_edges(legs: Legs) -> Flags:
    to_left = np.cos(legs.inside) * legs.reach  # in the plane, positive where the route turns left
    sides = []
    for around, inner in ((0.0, to_left > FLAT), (math.pi, to_left < -FLAT)):
        points = np.array(legs.line_chords(legs.radius, around)) + 1
        at_point = np.repeat(inner, points)
        for i in np.flatnonzero(~np.isnan(legs.taper)):  # of its two points the narrower one
            narrower = int(points[:i].sum()) + int(legs.radius[i + 1] < legs.radius[i])
            at_point[narrower] = True
        at_point = np.concatenate([at_point[:1], at_point, at_point[-1:]])  # an open end is like its neighbour
        sides.append(np.stack([at_point[:-1], at_point[1:]], axis=1))  # (segments, 2)
    left, right = sides
    return np.concatenate([right, left[::-1, ::-1]])


def _edges(line: Floats) -> Flags:
    """Flags of a wall's segment ends at inner edges: where the wall (k, 2) turns right, away from the free space."""
    steps = np.diff(line, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    turns = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
    inner = turns < -FLAT
    at_point = np.concatenate([inner[:1], inner, inner[-1:]]) if len(inner) else np.zeros(2, bool)
    return np.stack([at_point[:-1], at_point[1:]], axis=1)


def free_space(legs: Legs, branches: BranchPipes, outside: float = 0.0, capped: bool = False) -> shapely.Polygon:
    """The union of all pipes of a planar route, in the plane.

    Args:
        legs: legs of the route.
        branches: its branches.
        outside: distance by which the pipes are wider, and caps thicker [m].
        capped: whether a cap closes the far end.
    """
    import shapely  # it takes 0.2 s to load, and only pipes with branches need it

    shapes = [shapely.Polygon(piece) for piece in _pieces(legs, outside, outside if capped else 0.0)]
    for i in range(len(branches.corner)):
        half, far = branches.radius[i] + outside, branches.length[i] + (outside if branches.closed[i] else 0.0)
        along, left = branches.axes[i, :2, 0], branches.axes[i, :2, 1]
        corners = [along * x + left * y for x, y in ((0, -half), (far, -half), (far, half), (0, half))]
        shapes.append(shapely.Polygon(branches.start[i, :2] + np.array(corners)))
    union = shapely.union_all(shapes, grid_size=1e-10)
    assert isinstance(union, shapely.Polygon)  # pipes that meet elsewhere are refused before
    return shapely.Polygon(union.exterior)


def _pieces(legs: Legs, outside: float, longer: float) -> list[Floats]:
    """Outlines of the route's own parts, cut squarely at every tee and cross and longer at the end, (k, 2) [m] each."""
    radius = legs.radius + outside
    sides = []
    for around in (0.0, math.pi):
        line, chords = legs.line(radius, around)[:, :2], legs.line_chords(radius, around)
        line[-1] += longer * legs.axes[-1, :2, 0]
        ends = np.cumsum([count + 1 for count in chords])  # the last point of every corner
        sides.append(np.split(line, [int(ends[i]) for i in np.flatnonzero(legs.taper == 0)]))
    return [np.concatenate([right, left[::-1]]) for left, right in zip(*sides, strict=True)]


def _outline(legs: Legs, branches: BranchPipes, outside: float, capped: bool) -> list[Floats]:
    """The outline of `free_space` without the open ends, from the right side of the first open end, (k, 2) [m] each."""
    import shapely

    ring = np.array(shapely.orient_polygons(free_space(legs, branches, outside, capped)).exterior.coords)[:-1]
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turns = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    ring = ring[np.abs(turns) > ROUNDING * np.linalg.norm(before + after, axis=1)]  # without points in a straight wall
    openings = _openings(legs, branches, capped)
    middles = (ring + np.roll(ring, -1, axis=0)) / 2
    of_edge = np.linalg.norm(middles[:, None] - openings, axis=2)  # (edges, openings)
    first = int(of_edge[:, 0].argmin())
    ring, is_open = np.roll(ring, -first - 1, axis=0), np.roll(of_edge.min(axis=1) < SAME, -first - 1)
    ends = np.flatnonzero(is_open)  # edges from a point to the next one, the last of all is the first open end
    return [ring[a : b + 1] for a, b in zip([0, *(ends[:-1] + 1)], ends, strict=True)]


def _openings(legs: Legs, branches: BranchPipes, capped: bool) -> Floats:
    """Middles of the open ends in the plane, the route's first one first, (openings, 2) [m]."""
    end = legs.start[-1] + legs.length[-1] * legs.axes[-1, :, 0]
    far = branches.start + branches.length[:, None] * branches.axes[:, :, 0]
    return np.concatenate([legs.start[:1], *([] if capped else [end[None]]), far[~branches.closed]])[:, :2]
