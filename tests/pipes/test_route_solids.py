"""The solids of a route: watertight meshes, and prisms that bound its bore exactly and stay out of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from helpers.prisms import depth_in_any, faces_of
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner_solids import Mesh
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_routes
from pipenav.pipes.route_solids import FACETS, route_boards_mesh, route_tube_mesh, wall_prisms
from pipenav.pipes.system_solids import PRISM_FACES

SHIPPED = parse_routes(["runs-rolled"])[::4] + parse_routes(["runs-level"])[::8]
TIGHT = PipeRoute.of(100, [(55, "left", 30), (125, "right", -45), (90, "left", 90)], [400, 120, 150, 300])
RUNS = [*SHIPPED, TIGHT, PipeRoute.of(70, [(30, "right", 0)]), PipeRoute.of(120, [(180, "left", 0)])]
some_runs = st.sampled_from(RUNS)
facet_counts = st.sampled_from([8, FACETS])


def solid(mesh: Mesh) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


@pytest.mark.parametrize("route", RUNS, ids=lambda route: route.name)
def test_tubes_are_watertight_and_as_large_as_straight_ones(route: PipeRoute) -> None:
    body = solid(route_tube_mesh(route))
    assert body.is_watertight and body.is_winding_consistent
    # Shear along a mitre keeps volumes.
    expected = math.pi * ((route.radius + route.wall) ** 2 - route.radius**2) * sum(route.straights)
    assert body.volume == pytest.approx(1e9 * expected, rel=5e-3)


@pytest.mark.parametrize("route", [route for route in RUNS if route.planar], ids=lambda route: route.name)
def test_boards_are_watertight_and_as_large_as_straight_ones(route: PipeRoute) -> None:
    body = solid(route_boards_mesh(route))
    assert body.is_watertight and body.is_winding_consistent
    assert body.volume == pytest.approx(1e9 * 2 * route.wall * route.diameter * sum(route.straights), rel=1e-3)


def test_only_planar_routes_have_boards() -> None:
    with pytest.raises(PipenavError, match="leaves the plane"):
        route_boards_mesh(TIGHT)


@given(some_runs, facet_counts)
@settings(max_examples=20, deadline=None)
def test_prisms_are_convex_and_fill_the_wall(route: PipeRoute, facets: int) -> None:
    prisms = wall_prisms(route, facets)
    assert prisms.shape == (len(route.straights), facets, 8, 3)
    normal, offset = faces_of(prisms)
    beyond = np.einsum("...fi,...vi->...fv", normal, prisms) - offset[..., None]
    assert beyond.max() < 1e-9  # no corner lies beyond any face
    volume = np.abs(np.einsum("...fi,...fi->...", np.cross(*_sides(prisms)), prisms[..., PRISM_FACES[:, 0], :])) / 6
    share = facets * math.tan(math.pi / facets)  # area of the polygon around a circle of radius 1
    expected = share * ((route.radius + route.wall) ** 2 - route.radius**2) * sum(route.straights)
    assert np.sum(volume) == pytest.approx(expected)


def _sides(prisms: Floats) -> tuple[Floats, Floats]:
    a, b, c = np.moveaxis(prisms[..., PRISM_FACES, :], -2, 0)
    return b - a, c - a


def to_polygon(route: PipeRoute, facets: int, around: Floats) -> Floats:
    """Distance from the axis to the polygon around the bore [m]."""
    turn_sign = 2 * math.pi / facets
    return np.asarray(route.radius / np.cos((around + turn_sign / 2) % turn_sign - turn_sign / 2))


def points_at(route: PipeRoute, distance: Floats, around: Floats, share: Floats) -> Floats:
    """Points at distances from the axis, in every leg, somewhere between its mitres: (legs points, 3)."""
    lines = route.legs.lines(distance, around)
    return np.asarray((lines[:, :-1] + share[:, None, None] * np.diff(lines, axis=1)).reshape(-1, 3))


@given(some_runs, facet_counts, st.sampled_from([None, 0.02]), st.integers(0, 99))
@settings(max_examples=30, deadline=None)
def test_prisms_begin_where_the_bore_ends_and_none_of_any_leg_reaches_into_it(
    route: PipeRoute, facets: int, thickness: float | None, seed: int
) -> None:
    if route == TIGHT:  # whose short straights have no room for thick walls
        thickness = None
    rng = np.random.default_rng(seed)
    around, share = rng.uniform(0, 2 * math.pi, 60), rng.uniform(0, 1, 60)
    bore = to_polygon(route, facets, around)
    prisms = wall_prisms(route, facets, thickness)
    within = points_at(route, (bore - 1e-7) * np.sqrt(rng.uniform(0, 1, 60)), around, share)
    assert depth_in_any(prisms, within).max() < 0
    assert depth_in_any(prisms, points_at(route, bore - 1e-7, around, share)).max() < 0
    assert depth_in_any(prisms, points_at(route, bore + 1e-7, around, share)).min() > 0


@pytest.mark.parametrize("facets", [8, FACETS])
def test_the_polygon_touches_the_round_bore_on_the_left_and_on_every_side_of_a_quarter_turn(facets: int) -> None:
    prisms = wall_prisms(RUNS[0], facets)
    first_leg = prisms[0, :: facets // 4, :2].mean(axis=1)  # (4, 3) middles of sides at the open end
    r = RUNS[0].radius
    np.testing.assert_allclose(first_leg[:, 1:], [[r, 0], [0, r], [-r, 0], [0, -r]], atol=1e-12)


def test_walls_too_thick_for_a_short_straight_are_refused() -> None:
    with pytest.raises(PipenavError, match="walls of 50 mm do not fit behind the short straights of run-d100"):
        wall_prisms(TIGHT, thickness=0.05)
