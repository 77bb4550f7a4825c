"""The laws of a route's walls, whose corners are mitres and bends: surfaces, volumes, and what lies inside."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from helpers.prisms import depth_in_any, faces_of
from helpers.random_routes import angles, bent_routes, flat_rolls, planar_bent_routes, rounded_length, routes, turns
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_lines import ARC_TOLERANCE
from pipenav.pipes.corner_solids import Mesh, tube_mesh
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_solids import BEND_DEVIATION, route_boards_mesh, route_tube_mesh, wall_prisms

NEAR = 1.1 * ARC_TOLERANCE
"""Distance from a chord at which a point surely lies on its side of the arc [m]."""

BENT = [
    PipeRoute.of(100, [(90, "left", 0, 150), (90, "right", 90, 150), (60, "right", 45)]),
    PipeRoute.of(70, [(135, "right", 30, 52.5), (45, "left", -60, 200)]),
    PipeRoute.of(120, [(90, "left", 0, 120), (120, "right", 0, 90), (75, "left", 0), (90, "left", 0, 360)]),
]


def solid(mesh: Mesh) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


@given(bent_routes, st.integers(0, 9))
def test_points_of_the_wall_are_outside_and_points_of_the_bore_inside(route: PipeRoute, seed: int) -> None:
    rng = np.random.default_rng(seed)
    around, share = rng.uniform(0, 2 * math.pi, 20), rng.uniform(size=(20, 1, 1))
    for distance, inside in ((route.radius + 0.5 * route.wall, False), (0.99 * route.radius - NEAR, True)):
        lines = route.legs.lines(distance, around, route.legs.chords(2 * route.radius))
        points = lines[:, :-1] + share * np.diff(lines, axis=1)
        assert (route.contains(points) == inside).all()


@given(planar_bent_routes)
def test_a_planar_routes_segments_have_free_space_on_their_left_only(route: PipeRoute) -> None:
    step = route.segments[:, 1] - route.segments[:, 0]
    left = np.stack([-step[:, 1], step[:, 0]], axis=1) / np.linalg.norm(step, axis=1, keepdims=True)
    middle = route.segments.mean(axis=1)
    assert route.contains(middle + NEAR * left).all()
    assert not route.contains(middle - NEAR * left).any()


@given(planar_bent_routes)
def test_edges_are_where_the_wall_bends_away_from_the_free_space(route: PipeRoute) -> None:
    right = len(route.wall_sides[1].face) - 1
    for wall, edges in zip(np.split(route.segments, [right]), np.split(route.edges, [right]), strict=True):
        step = wall[:, 1] - wall[:, 0]
        step /= np.linalg.norm(step, axis=1, keepdims=True)
        bend = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]  # positive: to the left, towards the free space
        for at_end, at_start, turning in zip(edges[:-1, 1], edges[1:, 0], bend, strict=True):
            assert at_end == at_start
            assert at_end == (turning < 0) or abs(turning) < 1e-6


@given(st.floats(40, 300), angles, turns, st.floats(0.75, 5))
def test_a_route_of_one_bend_is_that_corner(diameter: float, angle: float, turn: str, times: float) -> None:
    pipe = PipeCorner.of(diameter, angle, turn, times * diameter)
    route = PipeRoute.from_corner(pipe)
    left, right = pipe.walls if turn == "left" else pipe.walls[::-1]
    np.testing.assert_allclose(route.wall_sides[0].face, left, atol=1e-12)
    np.testing.assert_allclose(route.wall_sides[1].face, right, atol=1e-12)
    np.testing.assert_allclose(route.inner_edges, pipe.inner_edges, atol=1e-12)
    points = np.random.default_rng(1).uniform(-1.2, 1.2, (200, 2)) * pipe.leg
    np.testing.assert_allclose(route.distance_along(points), pipe.distance_along(points), atol=1e-12)
    one, other = pipe.contains(points), route.contains(points)
    near_wall = np.abs(_distance_to_segments(points, pipe.segments)) < NEAR
    assert ((one == other) | near_wall).all()


def _distance_to_segments(points: Floats, segments: Floats) -> Floats:
    start, step = segments[:, 0], segments[:, 1] - segments[:, 0]
    share = np.clip(((points[:, None] - start) * step).sum(-1) / (step**2).sum(-1), 0, 1)
    return np.asarray(np.linalg.norm(points[:, None] - start - share[..., None] * step, axis=-1).min(axis=1))


@pytest.mark.parametrize("route", BENT, ids=lambda route: route.name)
def test_bent_solids_are_watertight_and_as_large_as_straight_ones_of_the_centre_lines_length(route: PipeRoute) -> None:
    body, length = solid(route_tube_mesh(route)), rounded_length(route)
    assert body.is_watertight and body.is_winding_consistent
    # Pappus: a section that is carried around a circle sweeps its area times the way of its centre.
    expected = math.pi * ((route.radius + route.wall) ** 2 - route.radius**2) * length
    assert body.volume == pytest.approx(1e9 * expected, rel=5e-3)
    if route.planar:
        boards = solid(route_boards_mesh(route))
        assert boards.is_watertight and boards.is_winding_consistent
        assert boards.volume == pytest.approx(1e9 * 2 * route.wall * route.diameter * length, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("route", BENT, ids=lambda route: route.name)
@pytest.mark.parametrize("thickness", [None, 0.02])
def test_prisms_are_convex_leave_the_bore_free_and_fill_the_wall(route: PipeRoute, thickness: float | None) -> None:
    prisms = wall_prisms(route, thickness=thickness)
    normal, offset = faces_of(prisms)
    assert (np.einsum("...fi,...vi->...fv", normal, prisms) - offset[..., None]).max() < 1e-9
    rng = np.random.default_rng(0)
    around, share = rng.uniform(0, 2 * math.pi, 60), rng.uniform(size=(60, 1, 1))
    for distance, inside in ((1 - 1.01 * BEND_DEVIATION, False), (1.021 + BEND_DEVIATION, True)):
        lines = route.legs.lines(distance * route.radius, around, route.legs.chords(2 * route.radius))
        points = (lines[:, :-1] + share * np.diff(lines, axis=1)).reshape(-1, 3)
        assert ((depth_in_any(prisms, points) > 0) == inside).all()


def test_the_tube_of_one_bend_is_that_of_the_corner() -> None:
    pipe = PipeCorner.of(100, 75, "right", 150)
    one, other = solid(tube_mesh(pipe)), solid(route_tube_mesh(PipeRoute.from_corner(pipe)))
    assert one.volume == pytest.approx(other.volume, rel=1e-4)
    np.testing.assert_allclose(one.bounds, other.bounds, atol=0.1)


@given(routes(flat_rolls, st.integers(300, 1000), st.floats(0.75, 5.0), most=2), st.integers(0, 9))
@settings(max_examples=20, deadline=None)
def test_the_bore_of_the_chords_deviates_little(route: PipeRoute, seed: int) -> None:
    """The lines that chords stand for leave the arcs by no more than the share of the radius that is promised."""
    chords = route.legs.chords(route.radius, BEND_DEVIATION * route.radius)
    middle = route.legs.lines(route.radius, np.random.default_rng(seed).uniform(0, 7, 8), chords)
    middle = (middle[:, 1:] + middle[:, :-1]) / 2
    narrow, wide = ((1 + sign * 1.001 * BEND_DEVIATION) * route.diameter for sign in (-1, 1))
    assert route.model_copy(update={"diameter": wide}).contains(middle).all()
    assert not route.model_copy(update={"diameter": narrow}).contains(middle).any()


def test_names_and_labels_say_the_bend() -> None:
    route = PipeRoute.of(100, [(90, "left", 0, 150), (75, "right", 90)])
    assert route.name == "run-d100-L90r150-R75roll90"
    assert route.label == "100 mm, 90 deg left in 150 mm, 75 deg right rolled 90 deg"
    assert route != PipeRoute.of(100, [(90, "left", 0, 160), (75, "right", 90)], [0.6e3, 0.6e3, 0.6e3])
