"""Checks of an arm and calibrations of one, on the emulator's process."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.emulated import ROBOT, driver, strike, switch_on
from pipenav_hardware import check
from pipenav_hardware.backend import HardwareBackend
from pipenav_hardware.calibrate import Calibration
from pipenav_hardware.check import findings
from pipenav_hardware.emulator import judge
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings

from pipenav.backends.safety import TorqueUnconfirmed
from pipenav.deployment.guard import guarded
from pipenav.errors import PipenavError

pytestmark = pytest.mark.realtime


def levels(emulator: Emulator) -> dict[str, str]:
    return {finding.what: finding.level for finding in findings(emulator.arm)}


def test_a_check_of_a_healthy_arm_finds_nothing_and_changes_nothing(
    emulator: Emulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(check, "SLOW", math.inf)  # how soon servos answer depends on this machine
    found = levels(emulator)
    assert set(found.values()) == {"ok"}
    assert any("servo 4 (theta3): model 12, firmware 24, 12.0 V" in what for what in found)
    assert judge.only_asked(emulator.log_path)


@pytest.mark.parametrize(
    ("order", "words", "remedy"),
    [
        ({"fault": "dead", "servo": 3}, "servo 3 (theta2) does not answer", "the cable from servo 2 (theta1) to it"),
        ({"fault": "wheel", "servo": 1}, "in wheel mode", "pipenav calibrate --write-servos"),
        ({"fault": "voltage", "value": 8.0}, "gets 8.0 V", "supply 9 to 12.6 V"),
        ({"fault": "overload", "servo": 2}, "reports overload", "docs/guides/the-arm.md"),
        ({"fault": "duplicate", "servo": 3, "value": 7.0}, "does not answer", "the one with id 7"),
        ({"fault": "unplug", "device": "scanner"}, "there is no port", ""),
    ],
    ids=lambda value: value["fault"] if isinstance(value, dict) else "",
)
def test_a_check_names_what_is_wrong_and_what_to_do(
    emulator: Emulator, order: dict[str, Any], words: str, remedy: str
) -> None:
    strike(emulator, **order)
    problems = [finding for finding in findings(emulator.arm) if finding.level == "problem"]
    assert any(words in problem.what and remedy in problem.remedy for problem in problems), problems
    assert judge.only_asked(emulator.log_path)


def test_a_calibration_finds_how_the_arm_is_mounted(tmp_path: Path) -> None:
    """An arm whose second servo is mirrored and whose horn sits elsewhere, and whose pinion is another."""
    with Emulator(ROBOT, EmulatorSettings(front_sensor=False)) as ideal:
        servos = list(ideal.arm.servos)
    limits = {"lower_deg": -137.0, "upper_deg": 136.0}
    servos[1] = servos[1].model_copy(update={"sign": -1, "zero_count": 470.0} | limits)
    mounted = ideal.arm.model_copy(update={"servos": tuple(servos)})
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
        assert not any(on for on, _ in judge.torque(emulator.log_path, (1, 2, 3, 4)).values())


def test_a_calibration_names_the_joint_that_does_not_confirm(
    emulator: Emulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A servo that falls silent while it moves a little."""
    ports = {"servos": emulator.arm.port, "scanner": emulator.arm.scanner.port}
    made = HardwareBackend.calibrator(ROBOT, ports)
    assert isinstance(made, Calibration)
    monkeypatch.setattr(made._watchdog, "beat", lambda: emulator.order(fault="dead", servo=2))
    with pytest.raises(PipenavError, match=r"Torque may still be on at theta1: switch the supply off"), guarded(made):
        made.nudge("theta1")
    made.close()


def test_an_arm_that_is_closed_without_an_answer_names_its_joints(emulator: Emulator) -> None:
    with pytest.raises(TorqueUnconfirmed, match="still be on at theta2: switch"), driver(emulator) as arm:
        switch_on(arm)
        emulator.order(fault="dead", servo=3)
