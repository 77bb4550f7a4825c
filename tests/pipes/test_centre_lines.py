"""Which leg of a route a point belongs to, and how far along the centre line it lies."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.random_routes import inside, leg_of, routes
from helpers.traversing import PIPES, seeds
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pipenav.pipes.centre_lines import CentreLines
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_pipes

LEVEL = parse_pipes(["runs-level"])
CORNERS = [PipeCorner.of(90, 75, "right", leg_mm=1600), PipeCorner.of(110, 110, leg_mm=1600)]


@pytest.mark.slow
@given(routes(), st.integers(0, 9))
def test_the_distance_rises_along_lines_that_keep_the_inside_and_is_exact_on_the_centre_line(
    route: PipeRoute, seed: int
) -> None:
    distances = np.sort(np.random.default_rng(seed).uniform(route.distances[0], route.distances[-1], 300))
    on_line = np.stack([np.interp(distances, route.distances, line) for line in route.centre_line.T], axis=1)
    np.testing.assert_allclose(route.distance_along(on_line), distances, atol=1e-9)
    line = route.legs.lines(0.9 * route.radius, np.array([seed]))[0]
    share = np.linspace(0, len(line) - 1, 400)
    walked = np.stack([np.interp(share, np.arange(len(line)), x) for x in line.T], axis=1)
    assert (np.diff(route.distance_along(walked)) >= -1e-9).all()


@given(routes())
def test_the_distance_goes_on_past_the_open_ends(route: PipeRoute) -> None:
    before = route.centre_line[0] - 0.1 * route.frames.rotation[0][:, 0]
    after = route.centre_line[-1] + 0.1 * route.frames.rotation[-1][:, 0]
    assume(leg_of(route, np.stack([before, after])).tolist() == [0, len(route.corners)])  # no other leg is nearer
    assert not route.contains(np.stack([before, after])).any()
    assert route.distance_along(np.stack([before, after])) == pytest.approx(
        [route.distances[0] - 0.1, route.distances[-1] + 0.1]
    )


def test_a_point_in_a_mitre_counts_to_the_leg_before() -> None:
    route = PipeRoute.of(100, [(90, "left", 0)])
    mitre = np.array([[0.02, -0.02], [0.0, 0.0], [-0.02, 0.02]])
    assert leg_of(route, mitre).tolist() == [0, 0, 0]
    assert route.distance_along(mitre) == pytest.approx([0.0, 0.0, -0.02])
    assert route.distance_along(mitre + np.array([0.0, 1e-9])) == pytest.approx([0.0, 0.0, 0.02], abs=1e-8)


@given(routes(), st.integers(0, 9))
def test_points_of_a_leg_are_inside_and_belong_to_it(route: PipeRoute, seed: int) -> None:
    points = inside(route, seed)
    assert route.contains(points).all()
    leg = np.broadcast_to(np.arange(len(points))[:, None], points.shape[:2])
    np.testing.assert_array_equal(leg_of(route, points), leg)
    local = route.to_leg(points, leg)
    origin, rotation = route.frames
    np.testing.assert_allclose((rotation[leg] @ local[..., None])[..., 0] + origin[leg], points, atol=1e-9)


def test_points_in_a_bore_belong_to_it_even_where_another_legs_open_end_points_at_them() -> None:
    route = PipeRoute.of(108, [(110, "left", 0), (110, "left", 0), (30, "left", 0)], [137, 92, 317, 224])
    points = np.array([[-0.0874, 0.0539], [-0.06, 0.05]])
    assert leg_of(route, points).tolist() == [0, 0] and route.contains(points).all()


@given(routes(), st.floats(0.0, 1.0), st.floats(0, 6.28))
@settings(max_examples=50)
def test_legs_that_are_no_neighbours_never_share_a_point(route: PipeRoute, share: float, around: float) -> None:
    line = route.legs.lines(share * route.radius, np.array([around]))[0]
    samples = line[:-1, None] + np.linspace(0, 1, 50)[1:-1, None] * np.diff(line, axis=0)[:, None]
    np.testing.assert_array_equal(
        leg_of(route, samples), np.broadcast_to(np.arange(len(samples))[:, None], (len(samples), 48))
    )


@given(seeds)
def test_distances_of_corners_are_those_of_their_own_centre_lines(seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-1.0, 1.0, (len(PIPES), 6, 2))
    distances = CentreLines.of(PIPES).distance(points)
    for one, pipe, own in zip(distances, PIPES, points, strict=True):
        assert one == pytest.approx(pipe.distance_along(own))


@given(seeds)
def test_distances_of_routes_and_corners_together_are_those_of_their_own_centre_lines(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pipes = [LEVEL[0], CORNERS[0], LEVEL[7], PipeRoute.of(100, [(180, "left", 0), (90, "left", 180)])]
    line = [np.array([[-1.0, 0], [0, 0], [1, 1]]) if isinstance(p, PipeCorner) else p.centre_line[:, :2] for p in pipes]
    points = np.stack([points[rng.integers(len(points), size=8)] for points in line])
    points += rng.normal(0.0, 0.3, points.shape)
    distances = CentreLines.of(pipes).distance(points)
    for one, pipe, own in zip(distances, pipes, points, strict=True):
        assert one == pytest.approx(pipe.distance_along(own))


def test_centre_lines_make_room_for_more_corners() -> None:
    lines = CentreLines.of([CORNERS[0], CORNERS[1]]).put(np.array([1]), CentreLines.of([LEVEL[0]]))
    points = np.random.default_rng(0).normal(size=(2, 50, 2))
    assert lines.distance(points)[0] == pytest.approx(CORNERS[0].distance_along(points[0]))
    assert lines.distance(points)[1] == pytest.approx(LEVEL[0].distance_along(points[1]))
    assert list(lines.corners) == [1, 5]


@given(st.sampled_from(LEVEL))
def test_corners_end_one_after_the_other_and_turn_to_the_side_that_the_route_turns_to(route: PipeRoute) -> None:
    lines = CentreLines.of([route])
    assert np.all(np.diff(lines.end[0, :-1]) > 0)
    direction = np.diff(route.centre_line[:, :2], axis=0)
    cross = direction[:-1, 0] * direction[1:, 1] - direction[:-1, 1] * direction[1:, 0]
    assert route.turn_signs == pytest.approx(np.sign(cross))
    assert lines.turn_sign[0, :-1] == pytest.approx(np.sign(cross))
