"""Faults of servos, sensors and lines: each stops the arm for its own reason, or is borne."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers.emulated import PATIENCE, driver, reach, strike, switch_on, tick
from pipenav_hardware import packets
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator

from pipenav.backends.messages import Command
from pipenav.backends.safety import Stopped
from pipenav.deployment.loop import hold_until
from pipenav.errors import PipenavError

pytestmark = pytest.mark.realtime


@pytest.mark.parametrize(
    ("order", "cause"),
    [
        ({"fault": "overload", "servo": 2}, "overload"),
        ({"fault": "overheat", "servo": 3, "value": 75.0}, "overheat"),
        ({"fault": "voltage", "value": 8.5}, "voltage"),
        ({"fault": "stuck", "servo": 2}, "stall"),
        ({"fault": "power_dip", "servo": 4}, "power-dip"),
        ({"fault": "dead", "servo": 1}, "comms"),
        ({"fault": "drop"}, "comms"),
        ({"fault": "unplug"}, "bus-lost"),
        ({"fault": "blind", "device": "scanner"}, "blind"),
        ({"fault": "freeze", "device": "scanner"}, "frozen"),
        ({"fault": "drop", "device": "scanner"}, "stale"),
        ({"fault": "corrupt", "device": "scanner"}, "stale"),
        ({"fault": "truncate", "device": "scanner"}, "stale"),
        ({"fault": "unplug", "device": "scanner"}, "sensor-lost"),
        ({"fault": "drop", "device": "front"}, "stale"),
        ({"fault": "unplug", "device": "front"}, "sensor-lost"),
        ({"fault": "stuck", "device": "scanner"}, "stale"),
        ({"fault": "stuck", "device": "front"}, "stale"),
        ({"fault": "corrupt", "device": "front"}, "stale"),
    ],
    ids=lambda value: "-".join(map(str, value.values())) if isinstance(value, dict) else value,
)
def test_what_goes_wrong_stops_the_arm_for_its_own_reason(
    emulator: Emulator, order: dict[str, Any], cause: str
) -> None:
    with driver(emulator) as arm:
        start = switch_on(arm)
        target = start + np.array([[0.05, 2.0, 1.0, 0.5]])
        tick(arm, target, 2)
        strike(emulator, **order)
        with pytest.raises(Stopped) as stopped:
            tick(arm, target, 40)
        assert stopped.value.cause == cause
        arm.off()
    reachable = [] if cause == "bus-lost" else [servo for servo in (1, 2, 3, 4) if servo != order.get("servo")]
    assert not any(on for on, _ in byte_log.torque(emulator.log_path, reachable).values())


@pytest.mark.parametrize(
    "order",
    [
        {"fault": "drop", "count": 1},
        {"fault": "delay", "value": 0.02, "count": 3},
        {"fault": "corrupt", "probability": 0.05},
        {"fault": "garbage", "probability": 0.2},
        {"fault": "voltage", "value": 9.2},
        {"fault": "overheat", "value": 55.0},
        {"fault": "late", "device": "scanner", "value": 0.1},
        {"fault": "corrupt", "device": "scanner", "count": 1},
        {"fault": "drop", "device": "scanner", "count": 1},
        {"fault": "blind", "device": "scanner", "count": 2},
        {"fault": "freeze", "device": "scanner", "count": 1},
        {"fault": "minimum", "device": "scanner", "probability": 0.3},
        {"fault": "drop", "device": "front", "count": 3},
    ],
    ids=lambda value: "-".join(map(str, value.values())),
)
def test_what_can_be_borne_is_borne(emulator: Emulator, order: dict[str, Any]) -> None:
    with driver(emulator) as arm:
        target = switch_on(arm) + np.array([[0.02, 0.2, -0.2, 0.2]])
        emulator.order(**order)
        tick(arm, target, 8)
        emulator.order(clear=True)
        reach(arm, target)


def test_a_lost_answer_does_not_spoil_the_start(emulator: Emulator) -> None:
    with driver(emulator) as arm:
        emulator.order(fault="drop", servo=2, count=2)  # the question and its repetition
        target = switch_on(arm) + 0.02
        emulator.order(fault="drop", servo=2, count=2)
        arm.read()
        assert not arm.complete, "the first tick is one like any other"
        arm.hold()
        arm.wait()
        tick(arm, target)
    with driver(emulator) as arm:
        emulator.order(fault="drop", servo=2)
        with pytest.raises(PipenavError, match=r"servo 2 \(theta1\) did not answer for 2 ticks"):
            arm.read()


def test_a_missing_answer_holds_the_arm_for_that_tick(emulator: Emulator) -> None:
    with driver(emulator) as arm:
        target = switch_on(arm) + 0.02
        tick(arm, target, 2)
        before = len(list(byte_log.goals(emulator.log_path)))
        emulator.order(fault="drop", servo=2, count=2)  # the question and its repetition
        arm.read()
        assert not arm.complete
        arm.hold()
        arm.wait()
        assert len(list(byte_log.goals(emulator.log_path))) == before
        arm.read()
        assert arm.complete


def test_a_trip_is_final(emulator: Emulator) -> None:
    """No goal is taken after it, and nobody writes the torque limit that an overloaded servo has set to nothing."""
    with driver(emulator) as arm:
        target = switch_on(arm) + 0.02
        tick(arm, target, 2)
        emulator.order(fault="overload", servo=2)
        with pytest.raises(Stopped):
            tick(arm, target, 5)
        arm.off()
        emulator.order(clear=True)
        told = len(byte_log.instructions(emulator.log_path))
        arm.read()
        with pytest.raises(PipenavError, match="only listens now"):
            arm.send(Command("position", target))
        after = [heard.packet for heard in byte_log.instructions(emulator.log_path)[told:]]
        assert after and all(packet.code == packets.READ for packet in after)


@pytest.mark.parametrize("order", [{"fault": "unplug", "device": "scanner"}, {"fault": "dead", "servo": 3}])
def test_an_arm_that_would_fall_is_held_until_someone_has_it(emulator: Emulator, order: dict[str, Any]) -> None:
    with driver(emulator) as arm:
        target = switch_on(arm) + 0.02
        emulator.order(**order)
        with pytest.raises(Stopped):
            tick(arm, target, 10)
        held = []

        def released() -> bool:
            held.extend(on for on, _ in byte_log.torque(emulator.log_path, (1, 2, 4)).values())
            return len(held) >= 3 * 8 * PATIENCE  # beyond the supervisor's patience

        hold_until(arm, released)
        assert all(held)
        arm.off()
    assert not any(on for on, _ in byte_log.torque(emulator.log_path, (1, 2, 4)).values())


@pytest.mark.parametrize(
    ("order", "message"),
    [
        ({"fault": "dead", "servo": 1}, r"servo 1 \(l\) does not answer: .*the adapter on, and the power supply"),
        ({"fault": "dead", "servo": 3}, r"servo 3 \(theta2\) does not answer: .*cable from servo 2 \(theta1\)"),
        ({"fault": "model", "servo": 2, "value": 29.0}, "model 29, an AX-12A is model 12"),
        ({"fault": "wheel", "servo": 1}, "is in wheel mode"),
        ({"fault": "return_level", "servo": 4, "value": 1.0}, "status return level 1"),
        ({"fault": "return_level", "servo": 4, "value": 0.0}, "answers PING but no other question: its cable works"),
        ({"fault": "shutdown", "servo": 4, "value": 0.0}, "does not switch itself off on overload and overheating"),
        ({"fault": "duplicate", "servo": 3, "value": 2.0}, "two servos may have this id"),
    ],
    ids=lambda value: value["fault"] if isinstance(value, dict) else "",
)
def test_an_unfit_arm_is_refused_before_anything_moves(emulator: Emulator, order: dict[str, Any], message: str) -> None:
    strike(emulator, **order)
    with pytest.raises(PipenavError, match=message), driver(emulator):
        pass
    assert byte_log.only_asked(emulator.log_path)
