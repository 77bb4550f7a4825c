"""Ways on which robots are expected to move: how far points stray from them, which ways hold others."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pipenav_mujoco.ways import AHEAD, MOST, Expected, Way

from pipenav.arrays import Floats

COORDINATES = st.lists(st.floats(-1, 1), min_size=6, max_size=6)


def way_of(ends: list[float], slack: float) -> Way:
    """Way of one robot with one point."""
    start, end = np.array(ends).reshape(2, 1, 1, 3)
    return Way(start, end, np.array([slack]))


def tracks_of(points: Floats) -> Floats:
    """Tracks of one robot's only point, (m, 3)."""
    return points.T[None, :, None].copy()


@given(COORDINATES, st.floats(0, 1), st.floats(0, 0.03))
def test_a_point_strays_by_its_distance_from_its_way(ends: list[float], share: float, beside: float) -> None:
    way = way_of(ends, 0.01)
    direction = (way.end - way.start).ravel()
    across = np.cross(direction, [0.3, -0.5, 0.8])
    across = across / np.linalg.norm(across) if np.linalg.norm(across) > 1e-6 else np.array([1.0, 0.0, 0.0])
    on_way = way.start[0, 0] + share * direction
    strayed = way.strayed(tracks_of(np.stack([on_way, on_way + beside * across])))
    np.testing.assert_allclose(strayed, beside, atol=2e-6)


@given(COORDINATES, COORDINATES, st.floats(0.001, 0.5), st.floats(0.001, 0.02), st.integers(0, 2**32 - 1))
def test_what_is_near_a_way_that_is_held_is_near_the_way_that_holds_it(
    outer: list[float], inner: list[float], wide: float, narrow: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    inner = [o + 0.3 * wide * i for o, i in zip(outer, inner, strict=True)]
    holder, held = way_of(outer, wide), way_of(inner, narrow)
    if not holder.holds(held)[0]:
        return
    shares, beside = rng.uniform(size=(50, 1)), rng.normal(size=(50, 3))
    beside *= narrow * rng.uniform(size=(50, 1)) / np.linalg.norm(beside, axis=1, keepdims=True)
    near = held.start[0] + shares * (held.end - held.start)[0] + beside
    assert holder.strayed(tracks_of(near))[0] <= wide + 1e-9


def test_a_steady_robot_is_looked_ahead_and_one_put_at_rest_is_not() -> None:
    expected, points = Expected(2, 1, 1), np.zeros((2, 1, 3))
    told = np.zeros((2, 1))
    assert expected.ways(points, told).slack.tolist() == [MOST, MOST]
    for k in range(3):
        way = expected.ways(points, told)
        points = points + np.array([0.01, 0.0, 0.0])
        expected.learn(way, np.array([0.0, 0.004]), points - np.array([0.0025, 0.0, 0.0]))
        assert expected.steady.tolist() == [k > 0, False]
    expected.forget(np.array([1]))
    ways = expected.ways(points, told)
    np.testing.assert_allclose(ways.end - ways.start, [[[0.01, 0, 0]], [[0, 0, 0]]], atol=1e-12)
    ahead = ways.ahead(expected.steady)
    np.testing.assert_allclose(ahead.end - ahead.start, [[[AHEAD * 0.01, 0, 0]], [[0, 0, 0]]], atol=1e-12)
    assert ahead.holds(ways).all()
    moved = Way(ways.end, 2 * ways.end - ways.start, ways.slack)
    assert ahead.holds(moved)[0]
