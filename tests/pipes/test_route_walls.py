"""Walls in the plane of routes with tees, crosses and caps, against the oracle."""

from __future__ import annotations

import numpy as np
from helpers.pipe_oracle import PipeOracle
from helpers.random_networks import random_routes
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.pipes.corner_lines import ARC_TOLERANCE
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route import PipeRoute

NEAR = 1.2 * ARC_TOLERANCE
"""Distance from a chord at which a point surely lies on its side of the arc [m]."""

seeds = st.integers(0, 2**31 - 1)


def in_space(points: Floats) -> Floats:
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)


def lefts(segments: Floats) -> Floats:
    step = segments[:, 1] - segments[:, 0]
    return np.stack([-step[:, 1], step[:, 0]], axis=1) / np.linalg.norm(step, axis=1, keepdims=True)


def check_segments(pipe: Pipe, oracle: PipeOracle) -> None:
    """Free space on the left of every segment, none on its right, and no segment in it."""
    shares = np.array([0.03, 0.3, 0.5, 0.8, 0.97])[:, None, None]
    long = np.linalg.norm(np.diff(pipe.segments, axis=1)[:, 0], axis=1) > 30 * NEAR
    segments = pipe.segments[long]
    on = segments[:, 0] + shares * (segments[:, 1] - segments[:, 0])  # (shares, segments, 2)
    assert np.abs(oracle.bore(in_space(on))).max() < NEAR
    assert (oracle.bore(in_space(on + 2 * NEAR * lefts(segments))) < 0).all()
    assert (oracle.bore(in_space(on - 2 * NEAR * lefts(segments))) > 0).all()


@given(seeds)
@settings(max_examples=20, deadline=None)
def test_segments_have_the_free_space_on_their_left(seed: int) -> None:
    for route in random_routes(seed, level=True):
        assert route.planar
        check_segments(route, PipeOracle.of_route(route))


@given(seeds)
@example(430)  # without a tee or a cap
@settings(max_examples=20, deadline=None)
def test_walls_are_closed_but_for_the_open_ends(seed: int) -> None:
    """The next wall begins where one ends, across an open end as wide as its bore."""
    for route in random_routes(seed, level=True):
        branches = [branch for corner in route.corners for branch in corner.branches if not branch.closed]
        bores = [route.diameter, *(branch.diameter for branch in branches)]
        bores += [] if route.capped else [2 * route.legs.radius[-1]]
        faces = _as_segments(route)
        gaps = [np.linalg.norm(b[0] - a[-1]) for a, b in zip(faces, faces[1:] + faces[:1], strict=True)]
        np.testing.assert_allclose(sorted(gaps), sorted(bores), atol=1e-6)
        expected = np.concatenate([np.stack([face[:-1], face[1:]], axis=1) for face in faces])
        np.testing.assert_array_equal(route.segments, expected)


def _as_segments(route: PipeRoute) -> list[Floats]:
    """The faces in the order and direction of the segments: a route without fittings lists its left wall first."""
    sides = [side.face for side in route.wall_sides]
    return sides if route.has_fittings else [sides[1], sides[0][::-1]]


@given(seeds)
@settings(max_examples=20, deadline=None)
def test_edges_are_exactly_where_the_wall_turns_away_from_the_free_space(seed: int) -> None:
    for route in random_routes(seed, level=True):
        first = 0
        for face in _as_segments(route):
            edges = route.edges[first : first + len(face) - 1]
            step = np.diff(face, axis=0)
            step /= np.linalg.norm(step, axis=1, keepdims=True)
            turns = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]
            for ends_here, begins_here, turning in zip(edges[:-1, 1], edges[1:, 0], turns, strict=True):
                assert ends_here == begins_here
                assert ends_here == (turning < 0) or abs(turning) < 1e-6
            if len(edges) > 1:  # an open end counts as its segment's other end
                assert edges[0, 0] == edges[0, 1] and edges[-1, 1] == edges[-1, 0]
            first += len(edges)
        assert first == len(route.edges)


@given(seeds)
@settings(max_examples=15, deadline=None)
def test_backs_lie_a_wall_behind_the_faces(seed: int) -> None:
    for route in random_routes(seed, level=True):
        if any(corner.reducer and not corner.length for corner in route.corners):
            continue  # a step's wall is as short as the step
        oracle = PipeOracle.of_route(route)
        for face, back in route.wall_sides:
            middles = (back[:-1] + back[1:]) / 2
            assert (np.abs(oracle.outside(in_space(middles))) < 2 * NEAR).all()
            assert (oracle.bore(in_space(middles)) > 0.3 * route.wall).all()
            assert np.linalg.norm(face[0] - back[0]) < 1.01 * route.wall
