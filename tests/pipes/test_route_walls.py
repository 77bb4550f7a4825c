"""Walls of routes in the plane: what lies on which side of them, and where they bend."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.random_routes import angles, diameters, flat_rolls, planar_routes, routes, turns
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.backends.wall_boxes import wall_boxes
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route import PipeRoute


@given(diameters, angles, turns)
def test_a_route_of_one_corner_is_that_corner(diameter: float, angle: float, turn: str) -> None:
    pipe = PipeCorner.of(diameter, angle, turn)
    route = PipeRoute.from_corner(pipe)
    left, right = pipe.walls if turn == "left" else pipe.walls[::-1]
    np.testing.assert_allclose(route.walls.left, left, atol=1e-12)
    np.testing.assert_allclose(route.walls.right, right, atol=1e-12)
    np.testing.assert_allclose(route.centre_line[:, :2], pipe.line(0.0), atol=1e-12)
    points = np.random.default_rng(1).uniform(-1.2, 1.2, (200, 2)) * pipe.leg
    points = points[pipe.contains(points)]
    np.testing.assert_allclose(route.distance_along(points), pipe.distance_along(points), atol=1e-12)
    # Sorted by their middles, a pipe and a run list the same walls, with the same thick and thin boxes behind them.
    if angle > 179.9:  # where a run knows no inner side
        return
    for boxes in zip(*(_sorted_boxes(it) for it in (pipe, route)), strict=True):
        np.testing.assert_allclose(*boxes, atol=1e-9)


def _sorted_boxes(pipe: PipeCorner | PipeRoute) -> Floats:
    boxes = wall_boxes([pipe], 4, np.zeros(1))
    turned = np.sign(boxes.quaternion[0][:, :1]) * boxes.quaternion[0]
    rows = np.concatenate([boxes.position[0], np.abs(turned), boxes.half_size[0]], axis=1)
    return rows[np.lexsort(np.round(rows[:, :2], 6).T)]


@given(routes(), st.integers(0, 9))
def test_points_of_the_wall_are_outside(route: PipeRoute, seed: int) -> None:
    rng = np.random.default_rng(seed)
    lines = route.legs.lines(route.radius + 0.5 * route.wall, rng.uniform(0, 2 * math.pi, 20))
    assert not route.contains(lines[:, :-1] + rng.uniform(size=(20, 1, 1)) * np.diff(lines, axis=1)).any()


@given(planar_routes)
def test_a_planar_routes_segments_have_free_space_on_their_left_only(route: PipeRoute) -> None:
    step = route.segments[:, 1] - route.segments[:, 0]
    left = np.stack([-step[:, 1], step[:, 0]], axis=1) / np.linalg.norm(step, axis=1, keepdims=True)
    middle = route.segments.mean(axis=1)
    assert route.contains(middle + 1e-6 * left).all()
    assert not route.contains(middle - 1e-6 * left).any()


@given(planar_routes)
def test_edges_are_where_the_wall_bends_away_from_the_free_space(route: PipeRoute) -> None:
    for wall, edges in zip(np.split(route.segments, 2), np.split(route.edges, 2), strict=True):
        step = wall[:, 1] - wall[:, 0]
        step /= np.linalg.norm(step, axis=1, keepdims=True)
        bend = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]  # positive: to the left, towards the free space
        for at_end, at_start, turning in zip(edges[:-1, 1], edges[1:, 0], bend, strict=True):
            assert at_end == at_start
            assert at_end == (turning < 0) or abs(turning) < 1e-6


@given(routes(flat_rolls, st.integers(300, 2500), most=3))
@settings(max_examples=50)
def test_no_wall_box_reaches_into_free_space_farther_than_the_thin_ones_do(route: PipeRoute) -> None:
    boxes = wall_boxes([route], len(route.segments), np.zeros(1))
    grid = np.stack(np.meshgrid(*[np.linspace(-1, 1, 9)] * 2), axis=-1).reshape(-1, 2)
    yaw = 2 * np.arctan2(boxes.quaternion[0, :, 3], boxes.quaternion[0, :, 0])
    along = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    local = grid * boxes.half_size[0][:, None, :2]  # (s, 81, 2)
    points = boxes.position[0][:, None, :2] + local[..., :1] * along[:, None] + local[..., 1:] * across[:, None]
    narrow = route.model_copy(update={"diameter": route.diameter - 3e-4})
    assert not narrow.contains(points).any()


@given(routes())
def test_only_planar_routes_have_walls_in_the_plane(route: PipeRoute) -> None:
    rolled = any(abs(math.sin(corner.roll)) > 1e-9 for corner in route.corners)
    assert route.planar == (not rolled)
    if rolled:
        with pytest.raises(PipenavError, match="leaves the plane"):
            _ = route.walls
    else:
        assert np.abs(route.centre_line[:, 2]).max() < 1e-9
