"""Walls of boxes and wedges: they fill the wall right up to the bore, without a gap, and stay out of the bore."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.random_routes import bends, routes
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.reducer import reducer
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_routes
from pipenav.pipes.route_solids import prisms_behind
from pipenav.pipes.solid_walls import SECTION, STICK_OUT, WallSolids, wall_solids

THICKNESS = 0.02
TIGHT = PipeRoute.of(100, [(55, "left", 30), (125, "right", -45), (90, "left", 90)], [400, 220, 250, 300])
SOME = [TIGHT, reducer(90, 70, 60), reducer(80, 120, 0), reducer(120, 80, 0), *parse_routes(["runs-rolled"])[::8]]


def depth(solids: WallSolids, points: Floats) -> Floats:
    """Depth of points (p, 3) in the solid that holds them deepest, negative outside of all: (p,) [m]."""
    local = np.einsum("pbi,bij->pbj", points[:, None] - solids.position, solids.rotation)
    deepest = (solids.half_size - np.abs(local)).min(axis=2).max(axis=1)
    for wedge in solids.hulls:
        faces = wedge[[[0, 1, 2], [3, 4, 5], [0, 1, 3], [0, 2, 3], [1, 2, 4]]]
        normal = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        normal *= -np.sign(np.sum(normal * (wedge.mean(axis=0) - faces[:, 0]), axis=1, keepdims=True))
        outside = points @ normal.T - np.sum(normal * faces[:, 0], axis=1)
        deepest = np.maximum(deepest, -outside.max(axis=1))
    return np.asarray(deepest)


def on_facets(route: PipeRoute, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Points on the sides of the polygon, edges and corners among them, and unit vectors to the axis, (p, 3)."""
    edges = prisms_behind(SECTION, route, THICKNESS)[:, :, [0, 1, 4, 5]]
    share, around = rng.uniform(-0.2, 1.2, (2, *edges.shape[:2], 8, 1)).clip(0.0, 1.0)
    a, b, c, d = np.moveaxis(edges, 2, 0)[:, :, :, None]
    points = (1 - share) * ((1 - around) * a + around * b) + share * ((1 - around) * c + around * d)
    start, end = edges[:, :, :2].mean(axis=(1, 2)), edges[:, :, 2:].mean(axis=(1, 2))
    to_axis = (1 - share) * start[:, None, None] + share * end[:, None, None] - points
    some = rng.permutation(points.size // 3)[:600]
    unit = to_axis / np.linalg.norm(to_axis, axis=-1, keepdims=True)
    return points.reshape(-1, 3)[some], unit.reshape(-1, 3)[some]


def check(route: PipeRoute, seed: int) -> None:
    try:
        solids = wall_solids(route, THICKNESS)
    except PipenavError:  # short straights have no room for thick walls
        assume(False)
    points, to_axis = on_facets(route, np.random.default_rng(seed))
    assert depth(solids, points).min() > -1e-9  # no gap
    assert depth(solids, points - 1e-3 * to_axis).min() > -1e-9  # nor behind it
    # A point of a ridge is nearer to the facets than to the ridge, by the sine of half its angle.
    free = 1.5 * STICK_OUT * 2 * float(route.legs.radius.max())
    assert depth(solids, points + free * to_axis).max() < 0
    away = np.random.default_rng(seed).uniform(0.05, 1.0, (len(points), 1)) * route.legs.radius.min()
    assert depth(solids, points + away * to_axis).max() < 0


@pytest.mark.parametrize("route", SOME, ids=lambda route: route.name)
def test_walls_have_no_gap_and_stay_out_of_the_bore(route: PipeRoute) -> None:
    check(route, 0)


@pytest.mark.slow
@given(routes(bends=bends, most=3), st.integers(0, 9))
@settings(max_examples=30, deadline=None)
def test_walls_of_any_route_have_no_gap_and_stay_out_of_the_bore(route: PipeRoute, seed: int) -> None:
    check(route, seed)


def test_the_section_is_at_most_one_percent_of_the_radius_beside_the_round_bore() -> None:
    corner = (1 - SECTION.inside) / math.cos(math.pi / SECTION.sides)
    assert SECTION.inside + STICK_OUT < 0.01 and corner - 1 < 0.01


def test_only_acute_ridges_need_wedges() -> None:
    def wedges(angle: float) -> int:
        return len(wall_solids(PipeRoute.of(90, [(angle, "left", 0)]), THICKNESS).hulls)

    assert wedges(90) == wedges(120) == 0 < wedges(55)
    assert not wall_solids(PipeRoute.of(90, [(60, "left", 0, 135)]), THICKNESS).hulls
