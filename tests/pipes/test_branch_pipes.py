"""Routes with tees, crosses and caps against the oracle: free space, inner edges, and distances along the route."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.pipe_oracle import PipeOracle
from helpers.random_networks import random_routes
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.pipes.branch import Branch
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import Corner, corner_of

seeds = st.integers(0, 2**31 - 1)

NEAR = 1e-4
"""Distance from a surface below which a step, which is a short cone, may differ from one [m]."""


@given(seeds)
@settings(max_examples=20, deadline=None)
def test_the_free_space_is_that_of_the_oracle(seed: int) -> None:
    for route in random_routes(seed):
        oracle = PipeOracle.of_route(route)
        points = oracle.around(1000, np.random.default_rng(seed))
        distance = oracle.bore(points)
        sure = np.abs(distance) > NEAR
        assert (route.contains(points) == (distance < 0))[sure].all()
        assert 0.05 < (distance < 0).mean() < 0.95


@given(seeds, st.integers(0, 9))
@settings(max_examples=15, deadline=None)
def test_distances_count_along_the_legs(seed: int, chance: int) -> None:
    """Points in a leg, farther from its corners than its bore is wide, count as far as they are along the leg."""
    rng = np.random.default_rng(chance)
    for route in random_routes(seed):
        frames, at = route.leg_frames, route.distances
        for i, length in enumerate(route.straights):
            near = 2 * float(frames.radius.max()) + route.inner_edges.max()
            if length > 2 * near:
                along, around, off = rng.uniform(near, length - near), rng.uniform(0, 7), 0.9 * frames.radius[i]
                sideways = off * (np.cos(around) * frames.axes[i, :, 1] + np.sin(around) * frames.axes[i, :, 2])
                point = frames.start[i] + along * frames.axes[i, :, 0] + sideways
                assert route.distance_along(point) == pytest.approx(at[i] + along, abs=1e-9)


@given(seeds)
@settings(max_examples=20, deadline=None)
def test_inner_edges_of_tees_are_where_the_openings_end(seed: int) -> None:
    for route in random_routes(seed):
        oracle, axes, start = PipeOracle.of_route(route), route.legs.axes, route.legs.start
        for i, corner in enumerate(route.corners):
            if len(corner.branches) != 1:
                continue
            pipes = [(-axes[i, :, 0], route.legs.radius[i]), (axes[i + 1, :, 0], route.legs.radius[i + 1])]
            branch = next(b for b, at in enumerate(route.branches.corner) if at == i)
            aside = route.branches.axes[branch, :, 0]
            opened = []
            for (along, radius), (other, _) in (pipes, pipes[::-1]):
                towards = aside if corner.straight_on else other
                inwards = towards - (towards @ along) * along
                inwards /= np.linalg.norm(inwards)
                past, before = route.inner_edges[i] + 1e-3, route.inner_edges[i] - 1e-3
                wall = start[i + 1] + (radius + 2e-4) * inwards
                assert oracle.bore(wall + past * along) > 0
                opened.append(oracle.bore(wall + before * along) < 0)
            assert any(opened)


@given(seeds)
@settings(max_examples=15, deadline=None)
def test_a_mirrored_route_has_the_mirrored_free_space(seed: int) -> None:
    for route in random_routes(seed):
        corners = tuple(_mirrored(corner) for corner in route.corners)
        mirrored = route.model_copy(update={"corners": corners})
        points = PipeOracle.of_route(route).around(500, np.random.default_rng(seed))
        surely = np.abs(PipeOracle.of_route(route).bore(points)) > 1e-9
        same = mirrored.contains(points * [1.0, -1.0, 1.0]) == route.contains(points)
        assert same[surely].all()
        np.testing.assert_allclose(mirrored.inner_edges, route.inner_edges, atol=1e-12)


def _mirrored(corner: Corner) -> Corner:
    turn = "right" if corner.turn == "left" else "left"
    branches = tuple(branch.mirrored for branch in corner.branches)
    return corner.model_copy(update={"turn": turn, "roll": -corner.roll, "branches": branches})


def side(angle: float = 90, diameter: float = 0.1, turn: str = "left", length: float = 0.3, **given: float) -> Branch:
    return Branch(angle=np.radians(angle), diameter=diameter, turn=turn, length=length, **given)


ALONG = Corner(angle=np.pi)
RUN = side(180)


@pytest.mark.parametrize(
    ("corner", "message"),
    [
        (
            ALONG.model_copy(update={"branches": (side(diameter=0.11),)}),
            r"diameter of a branch at corner 1 \(at most its run's\), 110 mm, is out of range: choose 40 to 100 mm",
        ),
        (
            ALONG.model_copy(update={"branches": (side(25),)}),
            "angle of a branch at corner 1, 25 deg, is out of range: choose 30 to 180 deg",
        ),
        (
            ALONG.model_copy(update={"branches": (side(151),)}),
            "angle between a branch at corner 1 and its run 151 deg is out of range: choose 30 to 150 deg",
        ),
        (
            ALONG.model_copy(update={"branches": (side(), side(70))}),
            "angle between the branches at corner 1, 20 deg, is out of range: choose 30 to 180 deg",
        ),
        (
            ALONG.model_copy(update={"branches": (side(), side(turn="right"), side(roll=1.5))}),
            "corner 1 has 3 branches: a tee has one, a cross 2",
        ),
        (
            ALONG.model_copy(update={"branches": (side(length=0.05),)}),
            "length of a branch at corner 1, 50 mm, is out of range: choose 63 to 20000 mm",
        ),
        (
            ALONG.model_copy(update={"branches": (side(length=float("inf")),)}),
            "length of a branch at corner 1, inf mm, is out of range",
        ),
        (
            ALONG.model_copy(update={"branches": (side(diameter=float("nan")),)}),
            "diameter of a branch at corner 1, nan mm, is out of range: choose 40 to 300 mm",
        ),
        (
            ALONG.model_copy(update={"branches": (side(roll=float("nan")),)}),
            "roll of a branch at corner 1, nan deg, is out of range: choose -360 to 360 deg",
        ),
        (
            ALONG.model_copy(update={"branches": (side(),), "bend_radius": 0.1}),
            "bend radius of corner 1, a tee or cross, 100 mm, is out of range: choose 0 to 0 mm",
        ),
        (
            ALONG.model_copy(update={"branches": (side(),), "length": 0.1}),
            "length of corner 1, which is no reducer, 100 mm, is out of range: choose 0 to 0 mm",
        ),
        (
            corner_of(90, "left").model_copy(update={"branches": (side(60, turn="right"),)}),
            "corner 1 has no run: two pipes of a tee or cross must be in line and of one diameter",
        ),
        (
            ALONG.model_copy(update={"branches": (side(),), "to_diameter": 0.08}),
            "corner 1 has no run: two pipes of a tee or cross must be in line and of one diameter",
        ),
    ],
)
def test_fittings_that_are_none_are_refused_in_one_sentence(corner: Corner, message: str) -> None:
    with pytest.raises(PipenavError, match=message) as caught:
        PipeRoute.with_default_straights(0.1, (corner,), [None, None], 0.003)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("length", [0.3, 19.0])
def test_a_branch_that_meets_another_leg_is_refused(length: float) -> None:
    corners = (
        ALONG.model_copy(update={"branches": (side(90, length=length),)}),
        corner_of(90, "left"),
        corner_of(90, "left"),
    )
    straights = [600.0, 300.0, 400.0, 1000.0]
    if length < 0.3001:
        assert PipeRoute.with_default_straights(0.1, corners, straights, 0.003).has_fittings
    else:
        with pytest.raises(PipenavError, match="the branch at corner 1 and straight 4 would touch or nearly touch"):
            PipeRoute.with_default_straights(0.1, corners, straights, 0.003)


def test_fittings_too_near_each_other_are_refused() -> None:
    tee_here = ALONG.model_copy(update={"branches": (side(),)})
    tee_there = ALONG.model_copy(update={"branches": (side(turn="right"),)})
    with pytest.raises(PipenavError, match=r"length of straight 2, 100 mm, is out of range: choose 1[0-9]{2} to 20000"):
        PipeRoute.with_default_straights(0.1, (tee_here, tee_there), [None, 100.0, None], 0.003)
