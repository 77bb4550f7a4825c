"""Observations of a robot on wheels in a traverse, and what its actions ask for."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from helpers.traversing import CONFIG, ROBOT, episodes, seeds, started
from hypothesis import given
from hypothesis import strategies as st

from pipenav.backends.messages import Reading
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.tee import TeePassage, Way, tee
from pipenav.tasks.registry import task_of
from pipenav.tasks.traverse import observation
from pipenav.tasks.traverse.episode import GRAVITY


def test_where_down_is_is_felt_in_the_divided_link_and_mirrored_as_all_else() -> None:
    config = CONFIG.model_copy(update={"inclination_deg": (0.0, 360.0), "start_spread": (1.0, 1.0)})
    left = episodes(config, 3, [PipeCorner.of(90, 75), PipeCorner.of(110, 110)])
    mirrored = tuple(pipe.model_copy(update={"turn": "right"}) for pipe in left.pipes)
    mirror = np.array([1.0, -1.0])
    right = left._replace(pipes=mirrored, q=left.q * ROBOT.mirror_coordinates, gravity=left.gravity * mirror)
    with started(left, config) as one, started(right, config) as other:
        for _ in range(3):
            still = np.zeros((2, one.action_size))
            down, seen = one.step(still).observation[:, -2:], other.step(still).observation[:, -2:]
            assert down == pytest.approx(seen, abs=0.02)
            rear, front = one.points[:, 3:5].swapaxes(0, 1)  # of the link between wheel 3 and wheel 4
            ahead = (front - rear) / np.linalg.norm(front - rear, axis=1)[:, None]
            across = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
            felt = np.stack([(left.gravity * axis).sum(axis=1) for axis in (ahead, across)], axis=1) / GRAVITY
            assert down == pytest.approx(felt)
    assert [part.name for part in observation.layout(ROBOT, config)][-1] == "down"


def test_left_and_right_are_seen_and_driven_alike() -> None:
    left = episodes(pipes=[PipeCorner.of(90, 75), PipeCorner.of(110, 110)], seed=3)
    mirrored = tuple(pipe.model_copy(update={"turn": "right"}) for pipe in left.pipes)
    right = left._replace(pipes=mirrored, q=left.q * ROBOT.mirror_coordinates)
    rng = np.random.default_rng(0)
    with started(left) as one, started(right) as other:
        for _ in range(6):
            action = rng.uniform(-1.0, 1.0, (2, one.action_size))
            a, b = one.step(action), other.step(action)
            assert a.observation == pytest.approx(b.observation, abs=0.02)
            assert a.reward == pytest.approx(b.reward, abs=1e-3)


def test_the_observation_has_the_size_and_the_order_that_its_layout_says() -> None:
    parts = observation.layout(ROBOT, CONFIG)
    names = ["q", "qd", "wheel_speeds", "loads", "ranges", "action_before", "turns_beside"]
    assert [part.name for part in parts] == names
    n = 2
    reading = Reading(
        np.full((n, 6), 1.0),
        np.full((n, 6), 2.0),
        np.full((n, 10), 4.0),
        np.zeros(n),
        np.full((n, 6), 3.0),
        np.ones((n, 12)),
    )
    route = observation.RouteAhead(np.ones(n), np.array([[0.0, -1.0]] * n))
    seen = observation.observe(ROBOT, reading, np.full((n, 12), 5.0), route)
    assert seen.shape == (n, len(task_of(CONFIG).observation_scale(ROBOT)))
    assert list(seen[0]) == [1.0] * 6 + [2.0] * 6 + [3.0] * 6 + [1.0] * 12 + [4.0] * 10 + [5.0] * 12 + [0.0, -1.0]


def test_a_robot_is_told_where_its_route_goes_straight_on_and_nothing_more() -> None:
    config = CONFIG.model_copy(update={"exit_told": True})
    pipes = [
        tee(90, angle, TeePassage(way, turn))
        for angle in (60, 90)
        for way in get_args(Way)
        for turn in ("left", "right")
    ]
    names = [part.name for part in observation.layout(ROBOT, config)]
    assert names[-1] == "straight_on"
    with started(episodes(config, 3, pipes), config) as batch, started(episodes(CONFIG, 3, pipes), CONFIG) as untold:
        seen, other = (one.step(np.zeros((len(pipes), one.action_size))).observation for one in (batch, untold))
    assert seen[:, :-1] == pytest.approx(other)
    assert list(seen[:, -1]) == [float(pipe.as_route_corner.straight_on) for pipe in pipes]
    assert set(seen[:, -1]) == {0.0, 1.0}


@given(seeds, st.sampled_from(["measured", "held"]))
def test_a_command_keeps_to_the_limits_and_near_the_joints_and_is_mirrored(seed: int, set_points: str) -> None:
    config = CONFIG.model_copy(update={"set_points": set_points})
    rng = np.random.default_rng(seed)
    action, (q, before) = rng.uniform(-1.5, 1.5, (2, 12)), rng.uniform(ROBOT.lower, ROBOT.upper, (2, 2, 6))
    left = observation.to_command(ROBOT, config, action, q, before, np.ones(2)).values
    signs = ROBOT.mirror_signs
    right = observation.to_command(ROBOT, config, action, q * signs, before * signs, -np.ones(2)).values
    assert right == pytest.approx(left * ROBOT.mirror_actuators)
    assert np.all((left[:, :6] >= ROBOT.lower) & (left[:, :6] <= ROBOT.upper))
    assert np.abs(left[:, :6] - q).max() <= config.alpha + 1e-12
    assert np.abs(left[:, 6:]).max() <= observation.wheel_limits(ROBOT).max()


def test_held_set_points_stay_and_measured_ones_follow_the_joints() -> None:
    q, before, still = np.full((1, 6), 0.3), np.full((1, 6), 0.4), np.zeros((1, 12))
    for name, expected in (("held", before), ("measured", q)):
        config = CONFIG.model_copy(update={"set_points": name})
        assert observation.to_command(ROBOT, config, still, q, before, np.ones(1)).values[:, :6] == pytest.approx(
            expected
        )


def test_wheels_roll_forwards_on_the_wall_that_their_bend_presses_them_on() -> None:
    q = np.array([[-0.5, 0.5, -0.05, 0.0, 0.5, -0.5]])  # a bend to the right presses its wheel to the left
    ahead = np.concatenate([np.zeros((1, 6)), np.ones((1, 6))], axis=1)
    limit = observation.wheel_limits(ROBOT)[0]
    speeds = observation.to_command(ROBOT, CONFIG, ahead, q, q, np.ones(1)).values[0, 6:]
    assert speeds == pytest.approx(limit * np.array([1.0, -1.0, 0.5, 0.0, -1.0, 1.0]))
