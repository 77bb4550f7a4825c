"""Tees as corners: the same fitting from each of its ends, its mirror image, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.pipe_oracle import PipeOracle
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.errors import OutOfRange, PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.tee import TeePassage, tee, tee_route

ways = st.sampled_from(["straight", "into", "out"])
turns = st.sampled_from(["left", "right"])
diameters = st.floats(40, 300)
angles = st.one_of(st.floats(30, 150), st.sampled_from([30.0, 45.0, 90.0, 135.0, 150.0]))
tees = st.builds(lambda d, a, way, turn: tee(d, a, TeePassage(way, turn), 2000), diameters, angles, ways, turns)


def in_space(points: Floats) -> Floats:
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)


def corners_of(pipe: PipeCorner) -> Floats:
    """Points at which the walls turn, without the open ends, (k, 2)."""
    return np.concatenate([side.face[1:-1] for side in pipe.wall_sides])


@given(tees, st.integers(0, 9))
@settings(max_examples=60, deadline=None)
def test_the_free_space_of_a_tee_is_that_of_the_oracle(pipe: PipeCorner, seed: int) -> None:
    oracle = PipeOracle.of_route(PipeRoute.from_corner(pipe))
    points = np.random.default_rng(seed).uniform(-1.5, 1.5, (500, 2)) * 2 * pipe.diameter
    distance = oracle.bore(in_space(points))
    assert (pipe.contains(points) == (distance < 0))[np.abs(distance) > 1e-6].all()


@given(tees)
@settings(max_examples=60, deadline=None)
def test_turned_round_twice_is_the_tee_itself(pipe: PipeCorner) -> None:
    again = pipe.turned_round.turned_round
    np.testing.assert_allclose(corners_of(again), corners_of(pipe), atol=1e-9)
    assert again.angle == pipe.angle and again.turn == pipe.turn


@given(tees)
@settings(max_examples=60, deadline=None)
def test_turned_round_has_the_same_walls_seen_from_the_other_end(pipe: PipeCorner) -> None:
    """The frame of the second leg, looking back to the corner."""
    along = -pipe.second_leg
    frame = np.stack([along, [-along[1], along[0]]], axis=1)  # columns
    seen = corners_of(pipe) @ frame
    turned = corners_of(pipe.turned_round)
    assert len(seen) == len(turned)
    distance = np.linalg.norm(seen[:, None] - turned, axis=2)
    assert distance.min(axis=0).max() < 1e-8 and distance.min(axis=1).max() < 1e-8


@given(diameters, angles, turns)
@settings(max_examples=60, deadline=None)
def test_a_tee_into_the_branch_is_turned_round_the_tee_out_of_it(diameter: float, angle: float, turn: str) -> None:
    into = tee(diameter, angle, TeePassage("into", turn), 2000)
    out = tee(diameter, angle, TeePassage("out", "left" if turn == "right" else "right"), 2000)
    seen, expected = corners_of(into.turned_round), corners_of(out)
    assert np.linalg.norm(seen[:, None] - expected, axis=2).min(axis=1).max() < 1e-8
    assert into.turned_round.turn == out.turn


@given(diameters, angles, turns)
@settings(max_examples=60, deadline=None)
def test_one_tee_has_the_same_walls_from_each_of_its_ends(diameter: float, angle: float, turn: str) -> None:
    """Its edges lie at the same distances from each other, whichever way the robot takes."""
    shapes = []
    for way, seen in (("straight", angle), ("into", angle), ("out", angle), ("into", 180 - angle)):
        points = np.unique(np.round(corners_of(tee(diameter, seen, TeePassage(way, turn), 2000)), 9), axis=0)
        distances = np.linalg.norm(points[:, None] - points, axis=2)
        shapes.append(np.sort(np.append(distances.ravel(), np.linalg.norm(points, axis=1))))
    for shape in shapes[1:]:
        np.testing.assert_allclose(shape, shapes[0], atol=1e-8)


@given(tees)
@settings(max_examples=60, deadline=None)
def test_mirrored_tees_have_mirrored_walls(pipe: PipeCorner) -> None:
    seen, mirrored = corners_of(pipe), corners_of(pipe.mirrored) * [1.0, -1.0]
    assert np.linalg.norm(seen[:, None] - mirrored, axis=2).min(axis=1).max() < 1e-9
    assert pipe.mirrored.mirrored == pipe


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((100, 29), "angle of the tee 29 deg is out of range: choose 30 to 150 deg"),
        ((100, 151), "is out of range: choose 30 to 150 deg"),
        ((100, 90, TeePassage("back")), "way 'back' through a tee is unknown: choose 'straight', 'into' or 'out'"),
        ((100, 90, TeePassage("into", "up")), "turn 'up' is unknown: choose 'left' or 'right'"),
        ((100, 90, TeePassage(), 40), "leg length 40 mm is out of range"),
        ((1000, 90), "diameter 1000 mm is out of range: choose 40 to 300 mm"),
        ((float("nan"), 90), "diameter nan mm is out of range"),
        ((100, 90, TeePassage(), None, float("nan")), "wall thickness nan mm is out of range: choose 0.5 to 50 mm"),
        ((100, 90, TeePassage(), float("inf")), "leg length inf mm is out of range"),
        ((100, float("nan")), "angle of the tee nan deg is out of range: choose 30 to 150 deg"),
    ],
)
def test_what_is_no_tee_is_refused_in_one_sentence(given: tuple[float, float], message: str) -> None:
    with pytest.raises(PipenavError, match=message) as caught:
        tee(*given)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("way", ["straight", "into", "out"])
def test_a_branch_wider_than_its_run_is_refused(way: str) -> None:
    with pytest.raises(OutOfRange, match=r"diameter of the tee.s branch 110 mm is out of range: choose 40 to 100 mm"):
        tee_route(100, 110, 90, TeePassage(way))
