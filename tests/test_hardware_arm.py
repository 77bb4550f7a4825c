"""The arm's description, the arithmetic between wire and robot, and the beams: without a wire."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pipenav_hardware import packets, table
from pipenav_hardware.arm_config import (
    ArmConfig,
    FrontSensorConfig,
    ScannerConfig,
    arm_toml,
    default_arm,
    load_arm,
)
from pipenav_hardware.beam_filter import DISBELIEF, BeamFilter
from pipenav_hardware.codec import JUMP_MARGIN, LIMIT_MARGIN, STEP_SLACK, Codec, Raw
from pipenav_hardware.ranging import AFTER_SCAN, RangeScan, late_for_scan
from pipenav_hardware.realsense import scanline
from pipenav_hardware.servo_config import PINION_TRAVEL

from pipenav.backends.messages import Command
from pipenav.backends.safety import Stopped
from pipenav.errors import ConfigError, PipenavError
from pipenav.robots.robot import load_robot

ROBOT = load_robot("basic")
SCANNER = ScannerConfig(driver="scip2", port="scanner")
ARM = default_arm(ROBOT, "bus", SCANNER, FrontSensorConfig(port="front"))
ANGLES = np.deg2rad(np.arange(-95.0, 95.5, 0.5))


def changed(servo: int, **values: Any) -> dict[str, Any]:
    table_ = ARM.model_dump()
    servos = [dict(one) for one in table_["servos"]]
    servos[servo] |= values
    return table_ | {"servos": servos}


def codec(arm: ArmConfig = ARM) -> Codec:
    return Codec(ROBOT, arm, BeamFilter(ROBOT.laser, ANGLES, 0.005, 0.5))


def state(position: int, speed: int = 0, load: int = 0) -> bytes:
    return packets.words(position, table.raw_signed(speed), table.raw_signed(load)) + bytes([120, 30])


def scan(millimetres: int = 200, sequence: int = 1) -> RangeScan:
    return RangeScan((millimetres,) * len(ANGLES), 0.0, sequence)


def raw(*positions: int | None, with_scan: bool = True) -> Raw:
    states = tuple(None if position is None else state(position) for position in positions)
    return Raw(states, scan() if with_scan else None, None, 0.1)


def home(arm: ArmConfig = ARM) -> list[int]:
    return [round(servo.to_counts(0.0)) for servo in arm.servos]


def test_a_description_survives_its_file(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(arm_toml(ARM))
    assert load_arm(path) == ARM
    ARM.require(ROBOT)


@pytest.mark.parametrize(
    ("table_", "message"),
    [
        (changed(0, upper_mm=400.0), "a pinion of 75 mm radius moves the rack 390 mm at most"),
        (changed(0, pinion_radius_mm=60.0), "moves the rack 312 mm at most"),
        (changed(1, upper_deg=160.0), "allowed are 4 to 1019"),
        (changed(1, zero_count=900.0), "mount the servo so that 0 lies elsewhere"),
        (changed(1, lower_deg=10.0), "must lie strictly between the limits"),
        (changed(1, id=1), "two servos have the same id"),
        (changed(1, id=254), "less than or equal to 252"),
        (changed(1, sign=0), "input should be 1 or -1"),
        (changed(1, torque_limit_percent=100.0), "less than 100"),
        (ARM.model_dump() | {"baud": 400_000}, "baud 400000 is not one of 9600, 19200"),
    ],
)
def test_an_impossible_arm_is_refused_in_a_sentence(tmp_path: Path, table_: dict[str, Any], message: str) -> None:
    path = tmp_path / "arm.toml"
    text = arm_toml(ARM.model_construct(**table_)) if False else _as_toml(table_)
    path.write_text(text)
    with pytest.raises(ConfigError) as refused:
        load_arm(path)
    assert message.lower() in str(refused.value).lower()


def _as_toml(table_: dict[str, Any]) -> str:
    class Plain:
        def model_dump(self, exclude_none: bool) -> dict[str, Any]:  # noqa: ARG002  # as pydantic's
            return {key: value for key, value in table_.items() if value is not None}

    return arm_toml(Plain())  # type: ignore[arg-type]


def test_a_missing_or_broken_description_says_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="write one with pipenav calibrate"):
        load_arm(tmp_path / "none.toml")
    (tmp_path / "bad.toml").write_text("servos = [")
    with pytest.raises(ConfigError, match="not valid TOML"):
        load_arm(tmp_path / "bad.toml")
    (tmp_path / "more.toml").write_text(arm_toml(ARM).replace('robot = "basic"', 'robot = "basic"\nrobto = 1'))
    with pytest.raises(ConfigError, match="unknown key 'robto'"):
        load_arm(tmp_path / "more.toml")


def test_an_arm_of_another_robot_is_refused() -> None:
    with pytest.raises(ConfigError, match="this arm is a 'other', not a 'basic'"):
        ARM.model_copy(update={"robot": "other"}).require(ROBOT)
    swapped = ARM.model_copy(update={"servos": (ARM.servos[0], ARM.servos[2], ARM.servos[1], ARM.servos[3])})
    with pytest.raises(ConfigError, match="servos move l, theta2, theta1, theta3"):
        swapped.require(ROBOT)


def test_the_rack_is_as_long_as_a_single_turn_allows() -> None:
    slide = ARM.servos[0]
    assert slide.unit == pytest.approx(0.075)
    assert slide.limits[1] - slide.limits[0] <= PINION_TRAVEL * slide.unit < 5.236 * slide.unit


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


def beam_filter() -> BeamFilter:
    return BeamFilter(ROBOT.laser, ANGLES, 0.02, 1.0)


def test_a_beam_is_the_median_of_its_neighbourhood() -> None:
    rng = np.random.default_rng(0)
    errors = []
    for i in range(50):
        noisy = np.round(200 + rng.normal(0, 10, len(ANGLES))).astype(int)
        noisy[rng.random(len(ANGLES)) < 0.2] = 20
        errors.append(np.abs(beam_filter().beams(RangeScan(tuple(noisy), 0.0, i), None) - 0.2).max())
    assert np.mean(errors) < 0.01


def test_a_minimum_from_nowhere_is_doubted_for_a_while() -> None:
    made = beam_filter()
    made.beams(scan(300), None)
    for _ in range(DISBELIEF):
        assert (made.beams(scan(20), None) == 0.3).all()
    assert (made.beams(scan(20), None) == 0.02).all()


def test_a_wall_that_comes_nearer_is_believed() -> None:
    made = beam_filter()
    for millimetres in (300, 210, 120, 60, 20):
        assert (made.beams(scan(millimetres), None) == millimetres / 1e3).all()


def test_error_codes_are_no_distances() -> None:
    made = beam_filter()
    assert (made.beams(scan(19), None) == ROBOT.laser.range_max).all()
    assert made.all_invalid


def test_the_front_sensor_sees_nearer_than_the_scanner() -> None:
    close = beam_filter().beams(scan(0), 0.012)
    middle = np.abs(ROBOT.laser.angles) < 0.2
    assert (close[middle] == 0.01).all()
    assert (close[~middle] == ROBOT.laser.range_max).all()
    assert (beam_filter().beams(scan(300), 0.28) == 0.3).all(), "within the scanner's range the scanner counts"


def test_a_scanner_that_sees_too_little_is_refused() -> None:
    with pytest.raises(PipenavError, match="does not see the beam at -81 deg"):
        BeamFilter(ROBOT.laser, np.deg2rad(np.arange(-43.0, 43.0)), 0.1, 1.0)


def test_a_depth_image_becomes_ranges_from_right_to_left() -> None:
    depth = np.full((9, 4), 1000, np.uint16)
    depth[:, 0] = 0
    depth[4, 3] = 500
    assert scanline(depth, 0.001, np.array([2.0, 1.0, 1.0, 2.0])) == (1000, 1000, 1000, 0)


@given(st.floats(0, 0.1), st.floats(-2e-4, 2e-4))
def test_ticks_come_to_begin_just_after_a_scan_and_stay_there(phase: float, drift: float) -> None:
    """Wherever they begin, and although the scanner's clock runs a little faster or slower."""
    due, stamp = 100.0, 100.0 - phase
    for _ in range(80):
        due += 0.1 - late_for_scan(due, RangeScan((300,), stamp, 1))
        while stamp + 0.1 + drift <= due:
            stamp += 0.1 + drift
    assert abs(math.remainder(due - stamp - AFTER_SCAN, 0.1)) < 0.001
    assert late_for_scan(due, None) == 0.0
