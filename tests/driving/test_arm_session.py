"""`pipenav drive` on an emulated arm in real time: it moves as it is driven, and torque is off whatever ends it."""

from __future__ import annotations

import os
import pty
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from helpers.command import run
from helpers.emulated import driver
from helpers.waiting import wait_until
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings

from pipenav.backends.messages import Reading
from pipenav.backends.safety import Stopped
from pipenav.deployment.session import Ending
from pipenav.deployment.telemetry import read_telemetry
from pipenav.driving.arm_session import LOST_TICKS, ArmScene, HandMission, drive_by_hand
from pipenav.driving.ask import Ask, Operator, OperatorLost, Seen
from pipenav.driving.door import Door, Scene
from pipenav.robots.robot import load_robot

ROBOT = load_robot("basic")
IDS = (1, 2, 3, 4)


class Fingers:
    """Bends the first hinge, and after some ticks does what it is told."""

    def __init__(self, ticks: int, last: Ask | None = None) -> None:
        self._ticks, self._last = ticks, last

    def ask(self, seen: Seen) -> Ask:
        if seen.tick < self._ticks:
            return Ask(active=True, joints={"theta1": 0.5})
        if self._last is None:
            raise OperatorLost("MIDI port 'panel'")
        return self._last


def session(folder: Path, operator: Operator) -> tuple[Ending, Path]:
    """A session on an emulated arm, and the log of its bus."""
    with Emulator(ROBOT, EmulatorSettings(boot_time=0.0)) as emulator, driver(emulator) as arm:
        given = ArmScene(Scene(None, 0.0, None), 0.0, folder, folder / "STOP", 40)
        mission = HandMission(ROBOT, Door(ROBOT, operator, False), given, None)
        ending = drive_by_hand(arm, mission, given, lambda _: None, {"robot": ROBOT.name})
        log = folder / "bus.jsonl"
        log.write_bytes(emulator.log_path.read_bytes())
        return ending, log


def off(log: Path) -> bool:
    """Whether no servo has torque in the end."""
    return not any(on for on, _ in byte_log.torque(log, IDS).values())


@pytest.mark.realtime
@pytest.mark.parametrize(
    ("last", "outcome"),
    [(Ask(end=True), "ended"), (Ask(stop=True), "e-stop"), (None, "operator")],
    ids=["the end key", "the stop key", "a panel that vanishes"],
)
def test_a_person_moves_the_arm_and_it_is_without_torque_afterwards(
    last: Ask | None, outcome: str, tmp_path: Path
) -> None:
    ending, log = session(tmp_path, Fingers(8, last))
    assert ending.outcome == outcome
    assert off(log)
    recording = read_telemetry(tmp_path / "telemetry.jsonl")
    moved = [tick for tick in recording.ticks if tick.get("stage") == "person"]
    assert moved[0]["asked"] == {"active": True, "joints": {"theta1": 0.5}}
    assert moved[-1]["q"][1] > moved[0]["q"][1] + 0.05
    assert recording.end is not None


@pytest.mark.realtime
def test_no_goal_on_the_wire_is_farther_than_a_step(tmp_path: Path) -> None:
    _, log = session(tmp_path, Fingers(20, Ask(end=True)))
    sent = [tick["sent"] for tick in read_telemetry(tmp_path / "telemetry.jsonl").ticks if tick.get("sent")]
    steps = np.abs(np.diff(sent, axis=0))
    assert len(steps) > 10
    assert (steps <= ROBOT.speed_limits * 0.1 + 0.006).all()  # a count is 5 mrad
    assert off(log)


class Absent:
    def ask(self, seen: Seen) -> Ask:  # noqa: ARG002
        raise OperatorLost("the gamepad")


def test_a_lost_device_holds_the_arm_and_then_stops_it(tmp_path: Path) -> None:
    given = ArmScene(Scene(None, 0.0, None), 0.0, tmp_path, tmp_path / "STOP", None)
    mission = HandMission(ROBOT, Door(ROBOT, Absent(), False), given, None)
    reading = Reading(np.full((1, 4), 0.01), np.zeros((1, 4)), np.full((1, 10), 0.1), np.zeros(1))
    for _ in range(LOST_TICKS):
        decision = mission.decide(reading)
        assert decision.stage == "hold"
        assert decision.command is not None
        assert np.allclose(decision.command.values, 0.01)
    with pytest.raises(Stopped, match=r"stopped \(operator\): the gamepad is gone; connect it again"):
        mission.decide(reading)


@contextmanager
def keyboard(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A terminal as stdin; its other end."""
    ours, theirs = pty.openpty()
    with os.fdopen(theirs) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        yield ours
    os.close(ours)


@pytest.mark.realtime
def test_the_command_drives_an_emulated_arm_by_keys(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "driven"
    log = folder / "telemetry.jsonl"
    with keyboard(monkeypatch) as wire:

        def press() -> None:
            wait_until(lambda: log.exists() and len(log.read_text().splitlines()) > 3, "ticks are recorded")
            os.write(wire, b"4")
            wait_until(lambda: '"theta1": 1.0' in log.read_text(), "the key is recorded")
            os.write(wire, b" ")

        threading.Thread(target=press, daemon=True).start()
        code = run("drive", "--emulate", "--allow-slow-bus", "--patience", "8", "--out", str(folder))
    assert code == 1
    assert "the stop key was pressed" in capsys.readouterr().err
    assert off(folder / "bus.jsonl")
