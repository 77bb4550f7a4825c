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
from pipenav.tasks.reach import observation, reward
from pipenav.tasks.reach.action import position_step, to_command
from pipenav.tasks.reach.config import ReachConfig, RewardConfig
from pipenav.tasks.reach.observation import Snapshot, canonical, layout, observe
from pipenav.tasks.reach.reward import StepFacts
from pipenav.tasks.registry import task_of

ROBOT = load_robot("basic")
LEFT, RIGHT = np.ones(1), -np.ones(1)


def snapshot(q: Any, qd: Any, ranges: Any) -> Snapshot:
    return canonical(ROBOT, Reading(np.array([q]), np.array([qd]), np.array([ranges]), np.zeros(1)), LEFT)


RESTING = snapshot([0.0] * 4, [0.0] * 4, [0.3] * 10)

unit = st.floats(-1, 1)
joint_values = arrays(float, (1, 4), elements=unit)
range_values = arrays(float, (1, 10), elements=st.floats(0.005, 0.5))


def facts(error: float = 0.018, nearest: float = 0.199, change: float = 0.199, failed: bool = False) -> StepFacts:
    """One robot's step; the defaults make eq 3.8 equal ln 0.1 and eq 3.10 and 3.14 equal -1."""
    one, ranges = np.ones(1), np.full((1, 10), 0.4)
    ranges[0, 3] = nearest
    flags = np.array([failed])
    return StepFacts(error * one, ranges, change * one, 0.01 * one, 2.0 * one, 0.001 * one, ~flags, flags)


def test_target_term_linear_eq_3_6() -> None:
    assert reward.target_linear(np.array([0.25])) == pytest.approx([-0.25])


def test_target_term_huber_eq_3_7() -> None:
    # delta = 0.1. Inner: -0.05^2 / 2 = -0.00125; at delta -0.1^2 / 2 = -0.005. The printed outer branch,
    # 0.1 * 0.3 - 0.1^2 / 2 = +0.025, lacks its sign: it would jump from -0.005 to +0.005 at delta and then reward
    # distance. With the sign: -0.025.
    assert reward.target_huber(np.array([0.05, 0.1, 0.3])) == pytest.approx([-0.00125, -0.005, -0.025])
    assert np.all(np.diff(reward.target_huber(np.linspace(0, 1, 1001))) < 0)


def test_target_term_log_eq_3_8_with_eq_3_9() -> None:
    # e = 0: -ln 0.1 + ln 0.1 = 0. e = 0.018: 50 * 0.018 + 0.1 = 1, so ln 0.1 = -2.302585.
    # e = 0.1: -ln 5.1 + ln 0.1 = -ln 51 = -3.931826.
    assert reward.target_log(np.array([0.0, 0.018, 0.1])) == pytest.approx([0.0, -2.302585, -3.931826])


def test_laser_term_eq_3_10_with_eq_3_11() -> None:
    # min D = 0.199: 5 * 0.199 + 0.005 = 1, so -1. min D = 0.005: 0.03, so -33.3333.
    # real-setup (5.4.1), beta = 1, d0 = 0.001: min D = 0.099 gives -1 / 0.1 = -10.
    ranges = np.array([[0.4, 0.199, 0.5], [0.005, 0.3, 0.3]])
    assert reward.laser(ranges, 5.0, 0.005) == pytest.approx([-1.0, -100 / 3])
    assert reward.laser(np.array([[0.099, 0.4]]), 1.0, 0.001) == pytest.approx([-10.0])
    assert (RewardConfig().beta, RewardConfig().d0) == (5.0, 0.005)


def test_joint_change_term_eq_3_14() -> None:
    # J = 0.199: 5 * 0.199 + 0.005 = 1, so -1. A robot that is stuck, J = 0: -1 / 0.005 = -200.
    assert reward.joint_change(np.array([0.199, 0.0])) == pytest.approx([-1.0, -200.0])


def test_basic_total_eq_3_12() -> None:
    # 1.5 * ln 0.1 + 0.4 * (-1) = -3.453878 - 0.4.
    config = RewardConfig(c1=1.5, c2=0.4)
    assert reward.total(config, facts()) == pytest.approx([1.5 * math.log(0.1) - 0.4])


def test_limit_total_eq_3_13() -> None:
    assert reward.total(RewardConfig(), facts(failed=True)) == pytest.approx([-1000.0])


def test_advanced_total_eq_3_15() -> None:
    # 1.5 * ln 0.1 + 0.1 * (-1) + 1.5 * (-1).
    config = RewardConfig(c1=1.5, c2=0.1, c3=1.5)
    assert reward.total(config, facts()) == pytest.approx([1.5 * math.log(0.1) - 0.1 - 1.5])


def test_our_own_terms() -> None:
    # progress 20 / m * 0.01 m, reach 5, step -0.1, force -0.05 / N * 2 N, penetration -1 / mm * 1 mm: 4.0, times 2.
    config = RewardConfig(c1=0, c2=0, progress=20, reach=5, step=-0.1, force=-0.05, penetration=-1.0, scale=2.0)
    assert reward.total(config, facts()) == pytest.approx([2 * (0.2 + 5.0 - 0.1 - 0.1 - 1.0)])


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


def test_torque_actions_eq_3_3() -> None:
    command = to_command(ROBOT, ReachConfig(control="torque"), np.array([[0.5, -3.0, 0, 1]]), np.zeros((1, 4)), LEFT)
    assert command.control == "torque"
    assert command.values[0] == pytest.approx([0.5, -1.0, 0.0, 1.0])  # clipped


def test_position_actions_eq_3_4_and_3_5() -> None:
    # alpha = 0.2: a hinge moves by 0.2 rad * a, the slide by 0.2 * 0.1 m * a = v0 of 5.3.1.
    config = ReachConfig(control="position")
    q = np.array([[0.1, 0.3, -0.3, 2.35]])
    command = to_command(ROBOT, config, np.array([[1.0, 0.5, -1.0, 1.0]]), q, LEFT)
    assert config.alpha == 0.2
    assert position_step(ROBOT, config) == pytest.approx([0.02, 0.2, 0.2, 0.2])
    assert command.control == "position"
    assert command.values[0] == pytest.approx([0.12, 0.4, -0.5, 2.4])  # the last at its limit


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
