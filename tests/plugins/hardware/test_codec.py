"""Readings from what servos and scanner say, and goals from commands, within all limits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.arm import ANGLES, ARM, ROBOT, home, raw, scan, state
from hypothesis import given
from hypothesis import strategies as st
from pipenav_hardware import table
from pipenav_hardware.arm_config import ArmConfig
from pipenav_hardware.beam_filter import BeamFilter
from pipenav_hardware.codec import JUMP_MARGIN, LIMIT_MARGIN, STEP_SLACK, Codec, Raw

from pipenav.backends.messages import Command
from pipenav.backends.safety import Stopped


def codec(arm: ArmConfig = ARM) -> Codec:
    return Codec(ROBOT, arm, BeamFilter(ROBOT.laser, ANGLES, 0.005, 0.5))


@given(st.integers(0, 3), st.integers(0, 1023), st.sampled_from([1, -1]), st.floats(300, 700))
def test_counts_and_positions_convert_both_ways(which: int, counts: int, sign: int, zero: float) -> None:
    servo = ARM.servos[which].model_copy(update={"sign": sign, "zero_count": zero})
    assert servo.to_counts(servo.to_position(counts)) == pytest.approx(counts, abs=1e-9)
    assert math.copysign(1, servo.to_position(zero + 1)) == sign


@given(st.lists(st.integers(-20, 20), min_size=4, max_size=4), st.lists(st.integers(-100, 100), min_size=4, max_size=4))
def test_a_reading_is_what_the_servos_said(offsets: list[int], speeds: list[int]) -> None:
    counts = [start + offset for start, offset in zip(home(), offsets, strict=True)]
    states = tuple(state(position, speed) for position, speed in zip(counts, speeds, strict=True))
    reading = codec().decode(Raw(states, scan(), None, 1.5))
    assert reading is not None
    assert reading.q[0] == pytest.approx([s.to_position(c) for s, c in zip(ARM.servos, counts, strict=True)])
    assert reading.qd[0] == pytest.approx(
        [s.unit * v * table.SPEED_UNIT for s, v in zip(ARM.servos, speeds, strict=True)]
    )
    assert (reading.ranges == 0.2).all()
    assert reading.time[0] == 1.5


def test_without_all_servos_or_a_scan_there_is_no_reading() -> None:
    made = codec()
    assert made.decode(raw(*home(), with_scan=False)) is None
    assert made.decode(raw(*home())) is not None
    assert made.decode(raw(*home()[:3], None)) is None
    assert made.problem == "servo 4 (theta3) does not answer"
    assert made.decode(raw(*home(), with_scan=False)) is not None


def test_one_impossible_position_is_rejected_two_stop() -> None:
    made, start = codec(), home()
    made.decode(raw(*start))
    furthest = int(made.bounds.step[1]) + JUMP_MARGIN
    assert made.decode(raw(start[0], start[1] + furthest, *start[2:])) is not None
    assert made.decode(raw(start[0], start[1] - 300, *start[2:])) is None
    assert "impossible position" in made.problem
    assert made.decode(raw(*start)) is not None
    assert made.decode(raw(start[0], start[1] - 300, *start[2:])) is None
    with pytest.raises(Stopped, match=r"servo 2 \(theta1\) jumped") as stopped:
        made.decode(raw(start[0], start[1] - 300, *start[2:]))
    assert stopped.value.cause == "jump"


def test_after_a_lost_answer_a_joint_may_have_moved_twice_as_far() -> None:
    made, start = codec(), home()
    made.decode(raw(*start))
    made.decode(raw(start[0], None, *start[2:]))
    assert made.decode(raw(start[0], start[1] + 2 * int(made.bounds.step[1]), *start[2:])) is not None


def test_a_joint_beyond_its_limits_stops() -> None:
    low, _ = ARM.servos[1].count_limits
    start = home()
    assert codec().decode(raw(start[0], low - LIMIT_MARGIN, *start[2:])) is not None
    with pytest.raises(Stopped, match="theta1 is beyond its limits") as stopped:
        codec().decode(raw(start[0], low - LIMIT_MARGIN - 1, *start[2:]))
    assert stopped.value.cause == "limit"


hostile = st.one_of(
    st.floats(),
    st.integers(-(10**30), 10**30),
    st.text(max_size=3),
    st.none(),
    st.sampled_from([1e308, -1e308, 5e-324]),
)


@given(st.lists(st.lists(hostile, min_size=4, max_size=4), max_size=30), st.randoms(use_true_random=False))
def test_no_action_however_hostile_leaves_the_limits(actions: list[list[object]], random: Any) -> None:
    made, present = codec(), home()
    last = present
    for action in actions:
        made.decode(raw(*present))
        try:
            sent = made.encode(Command("position", np.array([action], object))).goals  # type: ignore[arg-type]
        except Stopped as stopped:
            assert stopped.cause in ("not-finite", "lost-step")
            continue
        for i, (servo, goal) in enumerate(zip(ARM.servos, sent.items(), strict=False)):
            position, speed = goal[1]
            low, high = servo.count_limits
            step = int(made.bounds.step[i])
            assert low <= position <= high
            assert abs(position - last[i]) <= step
            assert abs(position - present[i]) <= step + STEP_SLACK
            assert 1 <= speed <= ROBOT.speed_limits[i] / servo.unit / table.SPEED_UNIT
        if sent:
            last = [goal for goal, _ in sent.values()]
            low_high = [servo.count_limits for servo in ARM.servos]
            moved = [
                p + random.randint(-10, 10) if random.random() < 0.5 else g for p, g in zip(present, last, strict=True)
            ]
            present = [min(max(m, low), high) for m, (low, high) in zip(moved, low_high, strict=True)]


@pytest.mark.parametrize("values", [[np.nan, 0, 0, 0], [0, 0, np.inf, 0], ["a", 0, 0, 0]])
def test_a_command_that_is_no_number_sends_nothing(values: list[object]) -> None:
    made = codec()
    made.decode(raw(*home()))
    with pytest.raises(Stopped, match="not a finite number"):
        made.encode(Command("position", np.array([values], object)))  # type: ignore[arg-type]
    assert made.last is None


def test_torques_and_wrong_shapes_are_refused() -> None:
    made = codec()
    made.decode(raw(*home()))
    with pytest.raises(Stopped, match="take positions, not torques"):
        made.encode(Command("torque", np.zeros((1, 4))))
    with pytest.raises(Stopped, match="3 values came for 4 joints"):
        made.encode(Command("position", np.zeros((1, 3))))


def test_a_servo_that_loses_its_goals_gets_none_once_then_stops() -> None:
    made, start = codec(), home()
    made.decode(raw(*start))
    made.last = np.array(start, float) + np.array([0, 3 * made.bounds.step[1], 0, 0])
    command = Command("position", np.zeros((1, 4)))
    assert made.encode(command).goals == {}
    with pytest.raises(Stopped, match="joint theta1 is farther from its last goal") as stopped:
        made.encode(command)
    assert stopped.value.cause == "lost-step"
