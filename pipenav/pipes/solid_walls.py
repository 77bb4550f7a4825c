"""The wall of a route as boxes, and as wedges where no box fits: what a simulator collides with fast.

The bore is a polygon, `SECTION`. A facet is the face towards the bore of one prism of `wall_prisms`, and behind it
lies a box. At an edge between a facet and the next one along the pipe, the wall turns away from the bore or towards it.
In a hollow edge boxes go on past the edge: there they are behind the other facet. At a ridge a box stops where its
square end would stick out of the other facet. What it leaves uncovered, because the edge is slanted or sharp, is
covered by a box along the edge or, at an acute ridge, by a wedge between both facets.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.pipes.pipe_system import Polygon, system_of
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_solids import BEND_DEVIATION, prisms_behind
from pipenav.pipes.system_solids import strand_walls

SECTION = Polygon(sides=20, turned=0.5, inside=0.003)
"""Section of the bore: at most 1 % of the radius beside the round one.

A robot in the plane of a corner, or square to it, has a corner of the polygon on either hand. The edges of a wheel's
tread then touch one side each, 9 deg beside the plane, as they touch a round bore 7 to 12 deg beside it: a wheel goes
as far with each turn as it should, within 1 %. Sides that faced the plane made it 8 % less in narrow pipes. Sixteen
sides would be 8 % faster, but lie 1 % inside; with twenty-four, all outside, a simulator is 9 % slower.
"""

STICK_OUT = 0.0025
"""Largest distance by which a box sticks out of a neighbouring facet, as a share of the bore's radius."""

OVERLAP = 0.25
"""Length by which boxes go on past a hollow edge, as a share of their thickness."""

FLAT = 1e-9
"""Sine of the turn up to which an edge counts as hollow: rounding."""


class WallSolids(NamedTuple):
    """The wall as convex solids in the route's frame.

    Attributes:
        position: middles of the boxes, (boxes, 3) [m].
        rotation: axes of the boxes as columns: along the wall, around the bore, and into the wall, (boxes, 3, 3).
        half_size: half lengths of the boxes along their axes, (boxes, 3) [m].
        hulls: corners of the other solids, each (corners, 3) [m]; none lies within the hull of the others.
    """

    position: Floats
    rotation: Floats
    half_size: Floats
    hulls: list[Floats]


class _Boxes(NamedTuple):
    """Boxes, as `WallSolids` has them."""

    position: Floats
    rotation: Floats
    half_size: Floats


class _Facets(NamedTuple):
    """Facets and the boxes behind them: p pieces along the pipe, f facets around each.

    Attributes:
        edges: ends of the first and of the last edge, each in order around the bore, (2, 2, p, f, 3) [m].
        origin: middle of the first edge, (p, f, 3) [m].
        axes: along the facet, around the bore, and into the wall, (3, p, f, 3).
        half: half width of the box, (p, f) [m].
        reach: where the box begins and ends, along the facet from its origin, (2, p, f) [m].
    """

    edges: Floats
    origin: Floats
    axes: Floats
    half: Floats
    reach: Floats


class _Ridges(NamedTuple):
    """Ridges that the boxes of their two facets leave uncovered, m in number.

    Attributes:
        origin: one end of the ridge, (m, 3) [m].
        along: unit vector along the ridge, (m, 3).
        into: unit vectors in both facets, square to the ridge and away from it, (2, m, 3).
        normal: normals of both facets, into the wall, (2, m, 3).
        span: from where to where it is uncovered along the ridge, (2 ends, 2 facets, m) [m].
        depth: how far from the ridge, (2 facets, m) [m].
    """

    origin: Floats
    along: Floats
    into: Floats
    normal: Floats
    span: Floats
    depth: Floats


def wall_solids(route: PipeRoute, thickness: float) -> WallSolids:
    """The wall of a route, without a gap, and exact but for `STICK_OUT`.

    Args:
        route: the route.
        thickness: thickness of the wall [m]; it is less near a tight bend.

    Raises:
        PipenavError: a wall so thick that those of the legs before and after a short one would meet.
    """
    if not route.has_fittings:
        return _solids_of(prisms_behind(SECTION, route, thickness), float(route.legs.radius.min()))
    parts = []
    for wall in strand_walls(system_of(route), SECTION, thickness, BEND_DEVIATION):
        if len(wall.prisms):
            parts.append(_solids_of(wall.prisms, float(route.legs.radius.min())))
        beside, hulls = _boxes_of(wall.uncut), [piece.vertices for piece in wall.cut]
        parts.append(WallSolids(*beside, hulls))
    *boxes, hulls_of_all = zip(*parts, strict=True)
    position, rotation, half_size = map(np.concatenate, boxes)
    return WallSolids(position, rotation, half_size, [hull for hulls in hulls_of_all for hull in hulls])


def _solids_of(prisms: Floats, narrowest: float) -> WallSolids:
    """Solids in place of prisms (pieces, facets, 8, 3) around a bore whose least radius is given [m]."""
    flat = _facets(prisms)
    thick = float((prisms[0, 0, 3] - prisms[0, 0, 0]) @ flat.axes[2, 0, 0])
    flat = flat._replace(
        half=flat.half + thick / 2 * math.tan(math.pi / SECTION.sides)
    )  # or clefts open behind corners
    ridges = _cut_to_ridges(flat, thick, STICK_OUT * narrowest)
    acute = np.sum(ridges.normal[0] * ridges.normal[1], axis=-1) < -FLAT
    parts = [_facet_boxes(flat, thick), *(_ridge_boxes(ridges, side, ~acute, thick) for side in (0, 1))]
    position, rotation, half_size = map(np.concatenate, zip(*parts, strict=True))
    return WallSolids(position, rotation, half_size, _wedges(ridges, acute))


def _boxes_of(prisms: Floats) -> _Boxes:
    """Boxes in place of single prisms (n, 8, 3) with square ends, no wider than their facets: openings are near."""
    flat = _facets(prisms[None])
    thick = np.sum((prisms[:, 3] - prisms[:, 0]) * flat.axes[2, 0], axis=-1)
    return _facet_boxes(flat, float(thick.max(initial=0.0)))


def _facets(prisms: Floats) -> _Facets:
    """Facets of prisms (p, f, 8, 3), with boxes that reach from edge to edge."""
    edges = np.moveaxis(prisms[:, :, [[0, 1], [4, 5]]], (2, 3), (0, 1))
    origin, end = edges.mean(axis=1)
    along = _unit(end - origin)
    normal = _unit(np.cross((edges[:, 1] - edges[:, 0]).sum(axis=0), along))
    axes = np.stack([along, np.cross(normal, along), normal])
    from_origin = edges - origin
    half = np.abs(_dot(from_origin, axes[1])).max(axis=(0, 1))
    distance = _dot(from_origin, along)  # (2, 2, p, f)
    return _Facets(edges, origin, axes, half, np.stack([distance[0].min(axis=0), distance[1].max(axis=0)]))


def _cut_to_ridges(flat: _Facets, thickness: float, stick_out: float) -> _Ridges:
    """Move the boxes' ends past hollow edges and back from ridges, and return the ridges that this uncovers."""
    origin, last = flat.edges[1][:, :-1]
    along, length = _unit(last - origin), np.linalg.norm(last - origin, axis=-1)
    pairs = [(flat.axes[0, k], flat.axes[2, k]) for k in (np.s_[:-1], np.s_[1:])]
    forwards = np.stack([_unit(a - _dot(a, along)[..., None] * along) for a, _ in pairs])
    into, normal = forwards * np.array([-1.0, 1.0]).reshape(2, 1, 1, 1), np.stack([n for _, n in pairs])
    hollow = _dot(normal[1], forwards[0]) >= -FLAT
    spans, depths = [], []
    for side, (piece, sign) in enumerate([(np.s_[:-1], 1.0), (np.s_[1:], -1.0)]):
        reach = flat.reach[1 - side, piece]
        ahead, around, inwards = flat.axes[:, piece]
        other, from_ridge = normal[1 - side], flat.origin[piece] - origin
        across = flat.half[piece][..., None] * around
        corners = np.stack([from_ridge + s * across + z * inwards for s in (-1, 1) for z in (0.0, thickness)])
        room = (stick_out + _dot(corners, other)).min(axis=0)
        slope = np.where(hollow, 1.0, -sign * _dot(other, ahead))
        limit = sign * room / slope  # along the facet from its origin
        past = sign * (reach - limit) > 0
        uncovered = ~hollow & past
        reach[...] = np.where(hollow, reach + sign * OVERLAP * thickness, np.where(uncovered, limit, reach))
        ends = from_ridge + reach[..., None] * ahead + np.stack([across, -across])  # (2, p - 1, f, 3)
        spots = _dot(ends, along)
        spans.append([np.minimum(spots.min(axis=0), 0.0), np.maximum(spots.max(axis=0), length)])
        depths.append(np.where(uncovered, _dot(ends, into[side]).max(axis=0), 0.0))
    depth, span = np.stack(depths), np.stack(spans, axis=1)
    left = (depth > 0).any(axis=0)
    return _Ridges(origin[left], along[left], into[:, left], normal[:, left], span[:, :, left], depth[:, left])


def _facet_boxes(flat: _Facets, thickness: float) -> _Boxes:
    low, high = flat.reach
    size = np.stack([(high - low) / 2, flat.half, np.full_like(low, thickness / 2)], axis=-1)
    middle = flat.origin + ((low + high) / 2)[..., None] * flat.axes[0] + thickness / 2 * flat.axes[2]
    boxes = high > low
    return _Boxes(middle[boxes], np.moveaxis(flat.axes, 0, -1)[boxes], size[boxes])


def _ridge_boxes(ridges: _Ridges, side: int, chosen: Flags, thickness: float) -> _Boxes:
    """Boxes in one facet of each chosen ridge, along the ridge."""
    needed = chosen & (ridges.depth[side] > 0)
    origin, along = ridges.origin[needed], ridges.along[needed]
    into, normal = ridges.into[side, needed], ridges.normal[side, needed]
    low, high = ridges.span[:, side, needed]
    depth = ridges.depth[side, needed]
    middle = origin + ((low + high) / 2)[:, None] * along + (depth / 2)[:, None] * into + thickness / 2 * normal
    size = np.stack([(high - low) / 2, depth / 2, np.full_like(low, thickness / 2)], axis=-1)
    rotation = np.stack([along, np.cross(normal, along), normal], axis=-1)
    return _Boxes(middle, rotation, size)


def _wedges(ridges: _Ridges, acute: Flags) -> list[Floats]:
    """Wedges between both facets of acute ridges, each (6, 3)."""
    hulls = []
    for m in np.flatnonzero(acute):
        depth = ridges.depth[:, m].max()
        ends = np.array([ridges.span[0, :, m].min(), ridges.span[1, :, m].max()])
        section = np.stack([np.zeros(3), *(depth * ridges.into[:, m])])
        hulls.append((ridges.origin[m] + ends[:, None, None] * ridges.along[m] + section).reshape(-1, 3))
    return hulls


def _dot(a: Floats, b: Floats) -> Floats:
    """Products of vectors along the last axis."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
