"""Every equation of the task against values worked by hand from the thesis, and the mirror."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipenav.backends.messages import Reading
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach import observation
from pipenav.tasks.reach.action import to_command
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.observation import Snapshot, canonical, layout, observe
from pipenav.tasks.registry import task_of

ROBOT = load_robot("basic")
LEFT, RIGHT = np.ones(1), -np.ones(1)


def snapshot(q: Any, qd: Any, ranges: Any) -> Snapshot:
    return canonical(ROBOT, Reading(np.array([q]), np.array([qd]), np.array([ranges]), np.zeros(1)), LEFT)


RESTING = snapshot([0.0] * 4, [0.0] * 4, [0.3] * 10)

unit = st.floats(-1, 1)
joint_values = arrays(float, (1, 4), elements=unit)
range_values = arrays(float, (1, 10), elements=st.floats(0.005, 0.5))


STATES = ("basic", "history", "relative", "relative-history")


def names(config: ReachConfig) -> list[str]:
    return [part.name for part in layout(ROBOT, config)]


def test_basic_state_eq_3_1() -> None:
    # [q qd p_ee p_goal D]: 4 + 4 + 2 + 2 + 10 = 22; straight, the tip is 0.04 + 0.12 + 0.12 + 0.11 + l = 0.49 ahead.
    config = ReachConfig(observation="basic")
    now = snapshot([0.1, 0, 0, 0], [5.0, 6, 7, 8], 0.01 * np.arange(1.0, 11))
    seen = observe(config, now, RESTING, np.full((1, 4), 9.0), np.array([[0.6, 0.2]]))
    expected = [0.1, 0, 0, 0, 5, 6, 7, 8, 0.49, 0, 0.6, 0.2, *(0.01 * np.arange(1, 11))]
    assert seen[0] == pytest.approx(expected)
    assert seen.shape == (1, 22) == (1, len(task_of(config).observation_scale(ROBOT)))
    assert names(config) == ["q", "qd", "p_ee", "p_goal", "ranges"]


def test_history_state_eq_3_2() -> None:
    # [q qd D, the same before, a before, p_ee, p_goal]: 18 + 18 + 4 + 2 + 2 = 44.
    config = ReachConfig(observation="history")
    now, before = snapshot([0.0] * 4, [2.0] * 4, [3.0] * 10), snapshot([4.0] * 4, [5.0] * 4, [6.0] * 10)
    seen = observe(config, now, before, np.full((1, 4), 7.0), np.array([[0.6, 0.2]]))
    blocks = [[0.0] * 4, [2.0] * 4, [3.0] * 10, [4.0] * 4, [5.0] * 4, [6.0] * 10, [7.0] * 4, [0.39, 0.0], [0.6, 0.2]]
    assert seen[0] == pytest.approx(np.concatenate(blocks))
    assert seen.shape == (1, 44) == (1, len(task_of(config).observation_scale(ROBOT)))
    expected = ["q", "qd", "ranges", "q_before", "qd_before", "ranges_before", "action_before", "p_ee", "p_goal"]
    assert names(config) == expected


def test_relative_state_sees_the_target_from_the_tip() -> None:
    # The tip link points to +y; a target 0.03 beyond the tip lies straight ahead, at half length in `goal_near`.
    now = snapshot([0.0, 0.0, 0.0, math.pi / 2], [0.0] * 4, [0.3] * 10)
    target = np.array([[0.28, 0.11 + 0.03]])
    seen = observe(ReachConfig(observation="relative"), now, RESTING, np.zeros((1, 4)), target)
    assert seen[0, 18:] == pytest.approx([0.03, 0.0, 0.5, 0.0], abs=1e-12)
    assert observation.NEAR == 0.03


def test_relative_state_with_the_scan_before_and_the_last_action() -> None:
    now, before = snapshot([0.1] * 4, [2.0] * 4, [0.3] * 10), snapshot([4.0] * 4, [5.0] * 4, [0.6] * 10)
    config, target, action = ReachConfig(observation="relative-history"), np.array([[0.6, 0.2]]), np.full((1, 4), 0.7)
    seen = observe(config, now, before, action, target)
    alone = observe(ReachConfig(observation="relative"), now, before, action, target)
    assert seen[0] == pytest.approx([*alone[0], *[0.6] * 10, *[0.7] * 4])
    assert seen.shape == (1, 36) == (1, len(task_of(config).observation_scale(ROBOT)))
    assert names(config) == ["q", "qd", "ranges", "goal_in_tip", "goal_near", "ranges_before", "action_before"]


@settings(max_examples=40)
@given(joint_values, joint_values, range_values, joint_values, st.sampled_from(STATES))
def test_a_right_turn_looks_like_the_left_turn_it_mirrors(q, qd, ranges, action, kind) -> None:  # type: ignore[no-untyped-def]
    reading = Reading(q, qd, ranges, np.zeros(1))
    signs = np.array([1.0, -1, -1, -1])  # the slide stays, the hinges turn to the other side
    mirrored = Reading(q * signs, qd * signs, ranges[:, ::-1], np.zeros(1))
    config, target = ReachConfig(observation=kind), np.array([[0.5, 0.2]])

    left, right = canonical(ROBOT, reading, LEFT), canonical(ROBOT, mirrored, RIGHT)
    seen = [observe(config, now, RESTING, action, target) for now in (left, right)]
    assert np.array_equal(*seen)

    for control in ("torque", "position"):
        task = ReachConfig(control=control)
        on_left = to_command(ROBOT, task, action, reading.q, LEFT).values
        on_right = to_command(ROBOT, task, action, mirrored.q, RIGHT).values
        assert np.allclose(on_right, on_left * signs, rtol=0, atol=1e-15)


@settings(max_examples=40)
@given(joint_values, joint_values, range_values)
def test_a_snapshot_shares_no_memory_with_the_reading(q, qd, ranges) -> None:  # type: ignore[no-untyped-def]
    reading = Reading(q, qd, ranges, np.zeros(1))
    for turn_sign in (LEFT, RIGHT):
        for seen, read in zip(canonical(ROBOT, reading, turn_sign), reading, strict=False):
            assert not np.shares_memory(seen, read)
