"""Starts of traverses: where, how bent, and which way is down."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.traversing import CONFIG, PIPES, ROBOT, episodes, seeds
from hypothesis import given, settings

from pipenav.policies.baselines.wall_distance import wall_distance
from pipenav.robots.kinematics import waypoints
from pipenav.tasks.traverse.episode import GRAVITY


@settings(max_examples=30, deadline=None)
@given(seeds)
def test_starts_touch_nothing_and_leave_the_gap(seed: int) -> None:
    start = episodes(seed=seed)
    for i, pipe in enumerate(start.pipes):
        room = wall_distance(ROBOT, pipe, start.q[i : i + 1], float(start.base[i]))[0]
        assert room >= -1e-9
        points = waypoints(ROBOT, start.q[i : i + 1])[0] + [start.base[i], 0.0]
        low, high = CONFIG.start_gap
        assert low - 1e-9 <= -pipe.inner_edge - points[-1, 0] <= high + 1e-9
        assert -pipe.leg < points[0, 0] - ROBOT.length  # room to slide back by its own length


@settings(max_examples=10, deadline=None)
@given(seeds)
def test_at_a_full_spread_wheels_touch_the_left_and_the_right_wall_alternately(seed: int) -> None:
    start = episodes(CONFIG.model_copy(update={"start_spread": (1.0, 1.0)}), seed, PIPES[:1])
    wheels = waypoints(ROBOT, start.q)[0, 1:-1]
    room = PIPES[0].radius - ROBOT.width / 2
    assert np.abs(wheels[:, 1]) == pytest.approx(room)
    assert np.all(np.diff(np.sign(wheels[:, 1])) != 0)


def test_gravity_is_drawn_over_the_whole_circle_or_is_none() -> None:
    assert not episodes().gravity.any()
    inclined = CONFIG.model_copy(update={"inclination_deg": (0.0, 360.0)})
    drawn = episodes(inclined, pipes=PIPES * 100).gravity
    assert np.linalg.norm(drawn, axis=1) == pytest.approx(GRAVITY)
    quarters = np.histogram(np.arctan2(*drawn.T), bins=4, range=(-np.pi, np.pi))[0]
    assert quarters.min() > 0.8 * quarters.mean()
