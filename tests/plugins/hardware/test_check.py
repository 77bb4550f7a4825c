"""Checks of an arm and calibrations of one, on the emulator's process."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.emulated import ROBOT, driver, few_ids, strike, switch_on
from helpers.waiting import wait_until
from pipenav_hardware import servos, table
from pipenav_hardware.backend import HardwareBackend, HardwareOptions
from pipenav_hardware.calibrate import Calibration
from pipenav_hardware.check import findings
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings
from pipenav_hardware.servo_flaws import READ_BYTES, tick_bytes

from pipenav.backends.safety import Stopped, TorqueUnconfirmed
from pipenav.deployment.guard import guarded
from pipenav.errors import PipenavError
from pipenav.robots.robot import load_robot

pytestmark = pytest.mark.realtime


def levels(emulator: Emulator) -> dict[str, str]:
    return {finding.what: finding.level for finding in findings(emulator.arm)}


def test_a_check_of_a_healthy_arm_finds_nothing_and_changes_nothing(
    emulator: Emulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(servos, "SLOW", math.inf)  # how soon servos answer depends on this machine
    found = levels(emulator)
    assert set(found.values()) == {"ok"}
    assert any("servo 4 (theta3): model 12, firmware 24, 12.0 V" in what for what in found)
    assert byte_log.only_asked(emulator.log_path)


@pytest.mark.parametrize(
    ("order", "words", "remedy"),
    [
        ({"fault": "dead", "servo": 3}, "servo 3 (theta2) does not answer", "the cable from servo 2 (theta1) to it"),
        ({"fault": "wheel", "servo": 1}, "in wheel mode", "pipenav calibrate --store-only"),
        ({"fault": "voltage", "value": 8.0}, "gets 8.0 V", "supply 9 to 12.6 V"),
        ({"fault": "overload", "servo": 2}, "reports overload", "switch the supply off and on"),
        ({"fault": "duplicate", "servo": 3, "value": 7.0}, "does not answer", "the one with id 7"),
        ({"fault": "duplicate", "servo": 3, "value": 200.0}, "does not answer", "the one with id 200"),
        ({"fault": "unplug", "device": "scanner"}, "there is no port", ""),
        ({"fault": "shutdown", "servo": 2, "value": 0.0}, "(register 18 is 0)", "pipenav calibrate --store-only"),
        ({"fault": "return_level", "servo": 2, "value": 0.0}, "its cable works", "pipenav calibrate --store-only"),
        ({"fault": "return_level", "servo": 2, "value": 1.0}, "answers questions but not orders", "--store-only"),
        ({"fault": "baud", "servo": 4, "value": 34.0}, "at 1000000 baud but at 57600", "set its register 4 to 1"),
        ({"fault": "baud", "servo": 4, "value": 7.0}, "at 1000000 baud but at 250000", "set its register 4 to 1"),
        ({"fault": "laser", "device": "scanner"}, "status 01: its laser cannot be switched on", ""),
        ({"fault": "trouble", "device": "scanner", "value": 60.0}, "status 60: its hardware is in trouble", ""),
    ],
    ids=lambda value: value["fault"] if isinstance(value, dict) else "",
)
def test_a_check_names_what_is_wrong_and_what_to_do(
    emulator: Emulator, order: dict[str, Any], words: str, remedy: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if order["fault"] == "dead":
        few_ids(monkeypatch)
    strike(emulator, **order)
    problems = [finding for finding in findings(emulator.arm) if finding.level == "problem"]
    assert any(words in problem.what and remedy in problem.remedy for problem in problems), problems
    assert byte_log.only_asked(emulator.log_path)


def test_a_calibration_finds_how_the_arm_is_mounted(tmp_path: Path) -> None:
    """An arm whose second servo is mirrored and whose horn sits elsewhere, and whose pinion is another."""
    with Emulator(ROBOT, EmulatorSettings(front_sensor=False)) as ideal:
        mounts = list(ideal.arm.servos)
    limits = {"lower_deg": -137.0, "upper_deg": 136.0}
    mounts[1] = mounts[1].model_copy(update={"sign": -1, "zero_count": 470.0} | limits)
    mounted = ideal.arm.model_copy(update={"servos": tuple(mounts)})
    with Emulator(ROBOT, EmulatorSettings(front_sensor=False, mounted=mounted)) as emulator:
        straight = [round(servo.to_counts(0.0)) for servo in mounted.servos]
        emulator.order(place=straight)
        made = HardwareBackend.calibrator(ROBOT, {"servos": emulator.arm.port, "scanner": emulator.arm.scanner.port})
        made.set_zero()
        for servo in mounted.servos:
            turned = made.nudge(servo.joint)
            assert 0.1 < turned < 0.25
            positive = servo.sign > 0
            moved = 1e3 * turned * servo.unit if servo.drive == "pinion" else None
            made.set_direction(servo.joint, positive, moved)
        emulator.order(place=straight)
        written = made.write_servos()
        made.close()
        path = tmp_path / "arm.toml"
        path.write_text(made.text())
        assert len(written) == 4
        with driver(emulator, arm=str(path)) as arm:
            assert [s.sign for s in arm.arm.servos] == [1, -1, 1, 1]
            assert arm.arm.servos[0].unit == pytest.approx(0.075, rel=0.05)
            assert arm.read().q == pytest.approx(np.zeros((1, 4)), abs=0.01)
        assert not any(on for on, _ in byte_log.torque(emulator.log_path, (1, 2, 3, 4)).values())


def test_a_calibration_names_the_joint_that_does_not_confirm(
    emulator: Emulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A servo that falls silent while it moves a little."""
    ports = {"servos": emulator.arm.port, "scanner": emulator.arm.scanner.port}
    made = HardwareBackend.calibrator(ROBOT, ports)
    assert isinstance(made, Calibration)
    beat = made._watchdog.beat

    def strike_and_beat() -> None:
        emulator.order(fault="dead", servo=2)
        beat()

    monkeypatch.setattr(made._watchdog, "beat", strike_and_beat)
    with pytest.raises(PipenavError, match=r"Torque may still be on at theta1: switch the supply off"), guarded(made):
        made.nudge("theta1")
    made.close()


def test_an_arm_that_is_closed_without_an_answer_names_its_joints(emulator: Emulator) -> None:
    with pytest.raises(TorqueUnconfirmed, match="still be on at theta2: switch"), driver(emulator) as arm:
        switch_on(arm)
        emulator.order(fault="dead", servo=3)


@pytest.mark.parametrize(
    ("fault", "words"), [("lock", "its EEPROM is locked"), ("torque_on", "torque is on and no program drives it")]
)
def test_a_check_warns_of_what_is_no_reason_to_refuse(emulator: Emulator, fault: str, words: str) -> None:
    strike(emulator, fault=fault, servo=2)
    warnings = [finding.what for finding in findings(emulator.arm) if finding.level == "warning"]
    assert any(words in warning for warning in warnings)


FLAWED: list[list[dict[str, Any]]] = [
    [{"fault": "wheel", "servo": 1}, {"fault": "shutdown", "value": 0.0}],
    [{"fault": "return_level", "value": 0.0}],
    [{"fault": "return_level", "servo": 3, "value": 1.0}],
]


@pytest.mark.parametrize("orders", FLAWED)
def test_what_a_check_says_about_settings_is_mended_as_it_says(
    emulator: Emulator, orders: list[dict[str, Any]]
) -> None:
    for order in orders:
        strike(emulator, **order)
    options = HardwareOptions(arm=str(emulator.arm_path))
    assert any(finding.level == "problem" for finding in HardwareBackend.check(options, ROBOT))
    assert len(HardwareBackend.store(options)) == 4
    assert not [finding for finding in HardwareBackend.check(options, ROBOT) if finding.level == "problem"]


@pytest.mark.parametrize("level", [0.0, 2.0])
def test_a_locked_servo_is_told_from_a_cable(emulator: Emulator, level: float) -> None:
    strike(emulator, fault="return_level", servo=2, value=level)
    strike(emulator, fault="lock", servo=2)
    with pytest.raises(PipenavError, match=r"servo 2 \(theta1\).*EEPROM.*locked.*switch the supply off and on"):
        HardwareBackend.store(HardwareOptions(arm=str(emulator.arm_path)))


def test_an_arm_of_another_robot_is_refused_before_any_port_is_opened(emulator: Emulator) -> None:
    options = HardwareOptions(arm=str(emulator.arm_path))
    with pytest.raises(PipenavError, match="this arm is a 'basic', not a 'real-setup'"):
        HardwareBackend.check(options, load_robot("real-setup"))
    assert not byte_log.instructions(emulator.log_path)


@pytest.mark.parametrize("baud", sorted(table.BAUD_VALUES))
def test_a_speed_drives_the_arm_or_is_refused_with_the_arithmetic(baud: int) -> None:
    with Emulator(ROBOT, EmulatorSettings(front_sensor=False)) as ideal:
        mounted = ideal.arm.model_copy(update={"baud": baud})
    tick, once_more = (1e4 * size / baud for size in (tick_bytes(4), READ_BYTES))
    with Emulator(ROBOT, EmulatorSettings(front_sensor=False, mounted=mounted)) as emulator:
        if tick + once_more > 100:
            words = rf"{baud} baud is too slow for the arm: 164 bytes a tick take {tick:.0f} ms, "
            words += rf"a question asked once more {once_more:.0f} ms, a tick has 100 ms"
            with pytest.raises(PipenavError, match=words), driver(emulator):
                pass
            assert any(words in finding.what for finding in findings(emulator.arm) if finding.level == "problem")
        else:
            with driver(emulator) as arm:
                assert arm.read().q == pytest.approx(np.zeros((1, 4)), abs=0.2)
        assert all(f"servo {i} " in " ".join(levels(emulator)) for i in (1, 2, 3, 4)), "a check finds them all the same"
        assert byte_log.only_asked(emulator.log_path)


def test_a_scanner_that_was_left_in_time_stamp_mode_is_set_right(emulator: Emulator) -> None:
    strike(emulator, fault="time_mode", device="scanner")
    assert any("scanner scip2" in what and level == "ok" for what, level in levels(emulator).items())


def test_a_scanner_in_trouble_stops_the_arm_in_its_own_words(emulator: Emulator) -> None:
    with driver(emulator) as arm:
        switch_on(arm)
        emulator.order(fault="trouble", device="scanner", value=61)
        with pytest.raises(Stopped, match="says status 61: its hardware is in trouble") as stopped:
            for _ in range(100):
                arm.read()
                arm.hold()
                arm.wait()
        assert stopped.value.cause == "sensor-lost"


@pytest.mark.parametrize("ending", ["end", "no front sensor"])
def test_the_laser_is_off_when_a_check_or_a_connection_ends(emulator: Emulator, ending: str) -> None:
    if ending == "end":
        levels(emulator)
    else:
        strike(emulator, fault="unplug", device="front")
        with pytest.raises(PipenavError, match="front"), driver(emulator):
            pass
    wait_until(lambda: any(r.get("event") == "laser" for r in byte_log.records(emulator.log_path)), "the laser was on")
    wait_until(lambda: not byte_log.laser(emulator.log_path), "the laser is off")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGHUP])
def test_the_laser_is_off_when_a_program_is_killed(emulator: Emulator, number: int) -> None:
    config = emulator.arm.scanner.model_dump_json()
    program = (
        "import time; from pipenav_hardware.arm_config import ScannerConfig; from pipenav_hardware.scip2 import *; "
        f"scanner = open_scanner(ScannerConfig.model_validate_json({config!r}), 0.5); time.sleep(600)"
    )
    killed = subprocess.Popen([sys.executable, "-c", program])
    wait_until(lambda: byte_log.laser(emulator.log_path), "the laser is on")
    killed.send_signal(number)
    killed.wait()
    wait_until(lambda: not byte_log.laser(emulator.log_path), "the laser is off")
