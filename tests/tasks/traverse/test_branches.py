"""Points in branches: outside the route's own pipes, and found for every pipe of a batch alike."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from pipenav.pipes.centre_lines import CentreLines
from pipenav.pipes.corner_sets import parse_corners
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route import as_route
from pipenav.pipes.route_sets import parse_routes
from pipenav.tasks.traverse.branches import Branches

TEES = parse_corners(["tees"])
PLAIN = parse_corners(["d=100,angle=90"])


def _contained(pipes: list[Pipe], points: np.ndarray) -> np.ndarray:
    return Branches.of(pipes).contain(points, CentreLines.of(pipes, points.shape[-1]))


def _points(rng: np.random.Generator, pipes: int, dimensions: int) -> np.ndarray:
    return rng.uniform(-0.3, 0.3, (pipes, 4000, dimensions))


def test_a_point_in_a_branch_is_in_the_pipe_and_in_no_leg_of_the_route() -> None:
    points = _points(np.random.default_rng(1), len(TEES), 3)
    found = _contained(TEES, points)
    assert found.any(axis=1).all()
    for pipe, own, inside in zip(TEES, points, found, strict=True):
        route = as_route(pipe)
        in_legs = np.logical_or(route.legs.in_straight(own, 0), route.legs.in_straight(own, 1))
        within = np.abs(own).max(axis=1) < route.branches.length.min() / 2
        assert not (inside & in_legs).any()
        assert route.contains(own)[inside & within].all()


def test_the_plane_is_a_section_of_space() -> None:
    flat = _points(np.random.default_rng(2), len(TEES), 2)
    high = np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=-1)
    assert np.array_equal(_contained(TEES, flat), _contained(TEES, high))


def test_each_pipe_of_a_batch_is_asked_for_its_own_branches() -> None:
    rng = np.random.default_rng(3)
    routes = parse_routes(["space-tees"])[:5]
    pipes = [TEES[0], *PLAIN, TEES[-1], *routes]
    points = _points(rng, len(pipes), 3)
    alone = [_contained([pipe], own[None])[0] for pipe, own in zip(pipes, points, strict=True)]
    assert np.array_equal(_contained(pipes, points), alone)
    assert not alone[1].any()
    put = Branches.of(PLAIN * len(pipes)).put(np.arange(len(pipes)), Branches.of(pipes))
    assert np.array_equal(put.contain(points, CentreLines.of(pipes, 3)), alone)


def test_no_point_of_a_route_lies_in_its_branches() -> None:
    """Also where the line of a branch meets a later leg."""
    routes = parse_routes(["town"]) + parse_routes(["space-town"]) + parse_routes(["space-tees"])
    for route in routes:
        share = np.linspace(0.0, 1.0, 200)[:, None]
        legs = np.concatenate([start + share * (end - start) for start, end in pairwise(route.centre_line)])
        assert not _contained([route], legs[None]).any()


def test_a_robot_that_fell_out_of_a_branch_stays_found() -> None:
    route = next(route for route in parse_routes(["space-tees"]) if len(route.branches.radius))
    out = route.branches.start[0] + route.branches.axes[0, :, 0] * np.array([[0.7 + route.branches.length[0]], [1e3]])
    assert _contained([route], out[None]).all()
