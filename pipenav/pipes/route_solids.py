"""A route as solids: its tube, its boards, and its wall as convex prisms that a simulator can collide with.

The bore of the prisms is a prism itself: a regular polygon whose sides touch the round bore from outside, so that what
fits into the tube fits between them. A side faces the left of the first leg, and with it the inside or the outside of
every corner whose plane is rolled by a whole number of sides.
"""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner_lines import ARC_TOLERANCE
from pipenav.pipes.corner_solids import Mesh, boards_between, round_angles, tube_between
from pipenav.pipes.pipe_system import Polygon, bend_chords, leg_rings, system_of
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.system_solids import (
    PRISM_FACES,
    ConvexPiece,
    fitting_boards_mesh,
    system_wall_pieces,
)
from pipenav.pipes.system_tubes import system_tube_mesh
from pipenav.units import m_to_mm

FACETS = 16
"""Sides of the polygon: its corners lie 2 % of the radius outside the round bore."""

BEND_DEVIATION = 0.01
"""Largest distance between a bend and the chords of its prisms, as a share of the bore's radius."""


def wall_prisms(route: PipeRoute, facets: int = FACETS, thickness: float | None = None) -> Floats:
    """The wall as convex prisms, (pieces, facets, 8, 3) [m] in the route's frame.

    A piece is a leg, or the part of a bend along one chord. Each prism lies behind one side of the polygon, from one
    end of its piece to the other. Its corners lie on the bore and behind it, first at the piece's start and then at its
    end, each time around the section. Neighbours share a face, in a mitre too; so they leave no gap, and no prism
    reaches into the bore of another leg. Chords leave the bend by `BEND_DEVIATION` at most, and walls end before the
    axis of the tightest bend, so they can be thinner than asked.

    Args:
        route: the route.
        facets: sides of the polygon.
        thickness: thickness of the wall [m], by default the route's own.

    Raises:
        PipenavError: a wall so thick that those of the legs before and after a short one would meet.
    """
    return prisms_behind(Polygon(facets), route, route.wall if thickness is None else thickness)


def prisms_behind(polygon: Polygon, route: PipeRoute, thickness: float) -> Floats:
    """The wall as `wall_prisms`, behind a polygon of one's own.

    Raises:
        PipenavError: a wall so thick that those of the legs before and after a short one would meet.
    """
    rings = leg_rings(route.legs, polygon, thickness, BEND_DEVIATION)
    legs = np.cumsum([0, *(count + 1 for count in bend_chords(route.legs, BEND_DEVIATION))])  # the pieces that are legs
    far = rings[:, :, 3]
    if (np.sum(np.diff(far, axis=0)[legs] * route.legs.axes[:, None, :, 0], axis=-1) <= 0).any():
        raise PipenavError(
            f"walls of {m_to_mm(thickness):g} mm do not fit behind the short straights of {route.name}: "
            "choose thinner ones."
        )
    return np.concatenate([rings[:-1], rings[1:]], axis=2)


def wall_pieces(route: PipeRoute, thickness: float | None = None) -> dict[str, ConvexPiece]:
    """The wall as convex pieces by name: the prisms of `wall_prisms`, or in a route with fittings what is left of them.

    Args:
        route: the route.
        thickness: thickness of the wall [m], by default the route's own.

    Raises:
        PipenavError: a wall so thick that those of the legs before and after a short one would meet.
    """
    if route.has_fittings:
        behind = route.wall if thickness is None else thickness
        parts = system_wall_pieces(system_of(route), Polygon(FACETS), behind, BEND_DEVIATION)
        return {f"wall_{number}": part for number, part in enumerate(parts, 1)}
    prisms = wall_prisms(route, thickness=thickness)
    return {
        f"wall_{piece + 1}_{side}": ConvexPiece(prisms[piece, side], PRISM_FACES)
        for piece, side in np.ndindex(*prisms.shape[:2])
    }


def route_tube_mesh(route: PipeRoute) -> Mesh:
    """The hollow tube of a route."""
    outside = route.legs.radius + route.wall
    widest = float(outside.max())
    if route.has_fittings:
        return system_tube_mesh(system_of(route))
    chords = route.legs.chords(widest, ARC_TOLERANCE / 4)
    inner, outer = (route.legs.lines(r[None], round_angles(widest), chords) for r in (route.legs.radius, outside))
    return tube_between(inner, outer)


def route_boards_mesh(route: PipeRoute) -> Mesh:
    """The two boards of a planar route: its left and its right wall, as high as the first diameter.

    Raises:
        PipenavError: the route leaves the plane.
    """
    _ = route.walls  # raises where the route leaves the plane
    if route.has_fittings:
        return fitting_boards_mesh(route)
    outside, sides = route.legs.radius + route.wall, np.array([0.0, math.pi])
    chords = route.legs.chords(float(outside.max()), ARC_TOLERANCE / 4)
    (left, right), (behind_left, behind_right) = (
        route.legs.lines(r[None], sides, chords)[..., :2] for r in (route.legs.radius, outside)
    )
    return boards_between([(left, behind_left), (behind_right, right)], route.radius)
