"""Set-points never jump: laws over random wishes, random speeds and random changes of driver."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.driving.slew import Slew, SlewLimits, braking
from pipenav.robots.robot import load_robot

ROBOTS = [load_robot("basic"), load_robot("pirate")]
ROUNDING = 1e-9


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_no_command_jumps_and_by_hand_no_speed_does(robot: object, seed: int) -> None:
    rng, limits = np.random.default_rng(seed), SlewLimits.of(robot)  # type: ignore[arg-type]
    joints = len(robot.joints)  # type: ignore[attr-defined]
    slew = Slew(limits, joints)
    slew.start(rng.uniform(limits.lower[:joints], limits.upper[:joints]))
    by_hand = True
    for _ in range(150):
        if rng.random() < 0.1:
            by_hand = not by_hand
            if not by_hand:
                slew.hand_over()
        before, pace = slew.last.copy(), slew.pace.copy()
        goal = rng.uniform(2 * limits.lower, 2 * limits.upper)
        now = slew.person(goal, rng.uniform(0, 1, joints)) if by_hand else slew.policy(goal)
        assert (np.abs(now - before) <= limits.step + ROUNDING).all()
        assert (now >= limits.lower - ROUNDING).all()
        assert (now <= limits.upper + ROUNDING).all()
        if by_hand:
            assert (np.abs(slew.pace - pace) <= limits.change[:joints] + ROUNDING).all()


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_a_hand_over_to_a_policy_changes_the_speed_little_by_little(robot: object, seed: int) -> None:
    rng, limits = np.random.default_rng(seed), SlewLimits.of(robot)  # type: ignore[arg-type]
    joints = len(robot.joints)  # type: ignore[attr-defined]
    slew = Slew(limits, joints)
    slew.start(np.zeros(joints))
    for _ in range(20):
        slew.person(rng.uniform(limits.lower, limits.upper))
    slew.hand_over()
    pace = slew.pace.copy()
    slew.policy(rng.uniform(limits.lower, limits.upper))
    assert (np.abs(slew.pace - pace) <= limits.change[:joints] + ROUNDING).all()


@given(goal=st.floats(-1.0, 1.0), start=st.floats(-1.0, 1.0))
def test_a_person_comes_to_stand_at_the_goal_without_passing_it(goal: float, start: float) -> None:
    robot = ROBOTS[1]
    slew = Slew(SlewLimits.of(robot), 6)
    slew.start(np.full(6, start))
    wish = np.concatenate([np.full(6, goal), np.zeros(6)])
    low, high = min(goal, start), max(goal, start)
    for _ in range(60):
        now = slew.person(wish)[:6]
        assert (now >= low - ROUNDING).all()
        assert (now <= high + ROUNDING).all()
    assert np.allclose(now, goal, atol=1e-6)
    assert np.allclose(slew.pace, 0.0, atol=1e-6)


@given(distance=st.floats(0.0, 10.0), change=st.floats(0.001, 1.0))
def test_braking_uses_all_of_the_distance_and_no_more(distance: float, change: float) -> None:
    pace = float(braking(np.array(distance), np.array(change)))
    gone = 0.0
    while pace > 0:
        gone, pace = gone + pace, pace - change
    assert gone == pytest.approx(distance, abs=1e-6)


def test_a_policy_that_drives_on_is_bound_by_the_step_alone() -> None:
    robot = ROBOTS[1]
    limits = SlewLimits.of(robot)
    slew = Slew(limits, 6)
    slew.start(np.zeros(6))
    inside = np.concatenate([0.9 * limits.step[:6], limits.upper[6:]])
    assert np.allclose(slew.policy(inside), inside)
