"""Late ticks are counted, and stop the arm where they are much too late or late twice."""

from __future__ import annotations

import time

import pytest
from helpers.emulated import PATIENCE, driver, switch_on, tick
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.servos import Servos

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Command
from pipenav.backends.safety import DEADLINE, LAST_DEADLINE, Stopped

pytestmark = pytest.mark.realtime


LATE, MUCH_TOO_LATE = (share * CONTROL_PERIOD * PATIENCE for share in (1.05 * DEADLINE, 2.0 * LAST_DEADLINE))
"""Delays that make a tick late, and so late that the arm stops at once [s]."""


def test_a_slow_decision_stops_before_its_command_is_sent(emulator: Emulator) -> None:
    with driver(emulator) as arm:
        target = switch_on(arm) + 0.02
        arm.read()
        before = len(list(byte_log.goals(emulator.log_path)))
        time.sleep(MUCH_TOO_LATE)
        with pytest.raises(Stopped) as stopped:
            arm.send(Command("position", target))
        assert stopped.value.cause == "deadline"
        assert len(list(byte_log.goals(emulator.log_path))) == before


@pytest.fixture
def slow_sending(monkeypatch: pytest.MonkeyPatch) -> None:
    send_goals = Servos.send_goals

    def slowly(servos: Servos, goals: dict[int, tuple[int, int]]) -> bytes:
        time.sleep(LATE)
        return send_goals(servos, goals)

    monkeypatch.setattr(Servos, "send_goals", slowly)


@pytest.mark.usefixtures("slow_sending")
def test_a_tick_whose_goals_go_out_late_is_late(emulator: Emulator) -> None:
    with driver(emulator) as arm:
        target = switch_on(arm) + 0.02
        arm.read()
        arm.send(Command("position", target))
        assert arm.raw()["late"] == 1
        with pytest.raises(Stopped, match="a tick took") as stopped:
            arm.wait()
            tick(arm, target)
        assert stopped.value.cause == "deadline"
        assert arm.raw()["late"] == 2


def test_recording_a_tick_belongs_to_it(emulator: Emulator) -> None:
    with driver(emulator) as arm:
        target = switch_on(arm) + 0.02
        arm.read()
        arm.send(Command("position", target))
        assert arm.raw()["late"] == 0
        time.sleep(MUCH_TOO_LATE)
        with pytest.raises(Stopped, match="a tick took"):
            arm.wait()
        assert arm.raw()["late"] == 1
