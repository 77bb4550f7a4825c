"""Every trip of servos and sensors: its cause and its words at the threshold, and silence one step below it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pipenav_hardware.arm_config import ScannerConfig, default_arm
from pipenav_hardware.ranging import RangeScan
from pipenav_hardware.table import Alarm, State
from pipenav_hardware.trips import LASTING, STATE_ALARMS, SensorRules, ServoRules

from pipenav.backends.safety import Stopped
from pipenav.robots.robot import load_robot

ARM = default_arm(load_robot("basic"), "bus", ScannerConfig(driver="scip2", port="scanner"), None)
GOALS = np.full(4, 512.0)
WELL = State(512, 0, 0, 120, 40)


def states(odd: State, place: int = 2) -> list[State | None]:
    return [odd if i == place else WELL for i in range(4)]


def run(rules: ServoRules, odd: State, ticks: int) -> None:
    for _ in range(ticks):
        rules.check(states(odd), GOALS)


def test_a_healthy_arm_never_trips() -> None:
    rules = ServoRules(ARM)
    run(rules, WELL, 100)
    rules.alarmed([Alarm(0)] * 4)
    rules.answered([True] * 4)
    assert not rules.warnings


@pytest.mark.parametrize("alarm", STATE_ALARMS)
def test_an_alarm_bit_trips_at_once_and_names_servo_and_cause(alarm: Alarm) -> None:
    cause, words, _ = STATE_ALARMS[alarm]
    with pytest.raises(Stopped, match=rf"servo 3 \(theta2\) {words}") as stopped:
        ServoRules(ARM).alarmed([Alarm(0), Alarm(0), alarm, Alarm(0)])
    assert stopped.value.cause == cause


def test_all_alarms_of_a_servo_are_named() -> None:
    """The SDK names the first bit only."""
    with pytest.raises(Stopped) as stopped:
        ServoRules(ARM).alarmed([Alarm(0x25), Alarm(0), Alarm(0), Alarm(0)])
    for words in ("supply voltage", "overheating", "overload"):
        assert words in str(stopped.value)


def test_a_checksum_alarm_is_the_lines_fault() -> None:
    ServoRules(ARM).alarmed([Alarm.CHECKSUM] * 4)


def test_heat_trips_at_60_degrees() -> None:
    run(ServoRules(ARM), WELL._replace(temperature=59), 50)
    with pytest.raises(Stopped, match="at 60 deg C"):
        run(ServoRules(ARM), WELL._replace(temperature=60), 1)


@pytest.mark.parametrize(("good", "bad"), [(90, 89), (126, 127)])
def test_voltage_trips_out_of_range_after_half_a_second(good: int, bad: int) -> None:
    rules = ServoRules(ARM)
    run(rules, WELL._replace(decivolts=good), 50)
    run(rules, WELL._replace(decivolts=bad), LASTING - 1)
    run(rules, WELL, 1)
    run(rules, WELL._replace(decivolts=bad), LASTING - 1)
    with pytest.raises(Stopped, match=f"gets {bad / 10:.1f} V"):
        run(rules, WELL._replace(decivolts=bad), 1)


def test_a_weak_supply_is_warned_of_first() -> None:
    rules = ServoRules(ARM)
    run(rules, WELL._replace(decivolts=94), 1)
    assert rules.warnings == ["servo 3 (theta2): 9.4 V"]
    run(rules, WELL._replace(decivolts=95), 1)
    assert not rules.warnings


def stalled(load_share: float = 0.8, error: int = 18) -> State:
    return WELL._replace(position=512 - error, load=int(np.ceil(load_share * ARM.servos[2].torque_counts)))


def test_a_stall_trips_after_half_a_second() -> None:
    rules = ServoRules(ARM)
    run(rules, stalled(), 1)  # the first look cannot tell whether it moves
    run(rules, stalled(), LASTING - 1)
    with pytest.raises(Stopped, match="does not move") as stopped:
        run(rules, stalled(), 1)
    assert stopped.value.cause == "stall"


@pytest.mark.parametrize("state", [stalled(load_share=0.79), stalled(error=17)])
def test_less_than_a_stall_does_not_trip(state: State) -> None:
    run(ServoRules(ARM), state, 50)


def test_a_servo_that_moves_under_full_load_is_not_stalled() -> None:
    rules = ServoRules(ARM)
    for tick in range(50):
        rules.check(states(stalled()._replace(position=400 + 5 * (tick % 2))), GOALS)


def test_without_torque_nothing_is_stalled() -> None:
    rules = ServoRules(ARM)
    for _ in range(50):
        rules.check(states(stalled()), None)


def test_one_silent_tick_is_forgiven_two_are_not() -> None:
    rules = ServoRules(ARM)
    for _ in range(5):
        rules.answered([True, False, True, True])
        rules.answered([True, True, True, False])
    with pytest.raises(Stopped, match=r"servo 4 \(theta3\) did not answer for 2 ticks") as stopped:
        rules.answered([True, True, True, False])
    assert stopped.value.cause == "comms"


@given(st.lists(st.sets(st.integers(1, 4)), max_size=12))
def test_silence_stops_exactly_when_a_servo_was_silent_just_before(ticks: list[set[int]]) -> None:
    """It holds for all servos, one or several."""
    rules = ServoRules(ARM)
    for before, silent in pairwise([set(), *ticks]):
        answers = [servo not in silent for servo in (1, 2, 3, 4)]
        if before & silent:
            with pytest.raises(Stopped, match="did not answer for 2 ticks") as stopped:
                rules.answered(answers)
            assert all(f"{servo} (" in str(stopped.value) for servo in before & silent)
            return
        rules.answered(answers)


def scan(first: int, sequence: int) -> RangeScan:
    return RangeScan((first, 100, 200), 0.0, sequence)


def test_blind_scans_trip_at_the_third() -> None:
    rules = SensorRules()
    for i in range(6):
        rules.scanned(scan(i, i), blind=i % 3 != 0)
    with pytest.raises(Stopped, match="no valid point"):
        rules.scanned(scan(6, 6), blind=True)


def test_the_same_scan_for_the_third_time_trips() -> None:
    rules = SensorRules()
    for i in range(10):
        rules.scanned(scan(i // 2, i), blind=False)
    with pytest.raises(Stopped, match="same scan"):
        rules.scanned(scan(4, 10), blind=False)


def test_a_stale_sensor_trips_beyond_a_quarter_second() -> None:
    rules = SensorRules()
    rules.aged("scanner", 0.25)
    with pytest.raises(Stopped, match="260 ms old") as stopped:
        rules.aged("scanner", 0.26)
    assert stopped.value.cause == "stale"
