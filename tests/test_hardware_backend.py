"""The whole driver against the emulator's process, judged by the bytes that reached the servos."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from emulated import PATIENCE, ROBOT, driver, switch_on, tick
from pipenav_hardware import packets
from pipenav_hardware.backend import HardwareBackend, HardwareOptions
from pipenav_hardware.emulator import judge
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings
from pipenav_hardware.servos import Servos

from pipenav.backends.messages import Command
from pipenav.backends.safety import Stopped
from pipenav.deployment.loop import hold_until
from pipenav.errors import PipenavError

pytestmark = pytest.mark.flaky(reruns=2)  # real time over a serial line: a busy machine may miss a deadline


@pytest.fixture
def emulator() -> Iterator[Emulator]:
    with Emulator(ROBOT, EmulatorSettings(boot_time=0.0)) as started:
        yield started


def test_the_arm_goes_where_it_is_told_within_its_limits(emulator: Emulator) -> None:
    with driver(emulator) as machine:
        start = switch_on(machine)
        target = start + np.array([[0.03, 0.5, -0.5, 0.3]])
        tick(machine, target, 8)
        assert machine.read().q == pytest.approx(target, abs=0.01)
        steps = machine._codec.bounds.step
        assert machine.off() == []
    limits = {servo.id: servo.count_limits for servo in emulator.arm.servos}
    goals = list(judge.goals(emulator.log_path))
    assert len(goals) >= 4 * 8
    for goal in goals:
        low, high = limits[goal.servo]
        step = steps[goal.servo - 1]
        assert low <= goal.goal <= high
        assert goal.present is not None and abs(goal.goal - goal.present) <= step + 2
        assert goal.last is None or abs(goal.goal - goal.last) <= step
        assert goal.speed is None or goal.speed >= 1
    assert not any(on for on, _ in judge.torque(emulator.log_path, (1, 2, 3, 4)).values())


@pytest.mark.parametrize("auto", [False, True])
def test_torque_comes_on_without_a_jump(emulator: Emulator, auto: bool) -> None:
    """Whatever the start pose; also with servos that switch torque on when they get a goal."""
    if auto:
        emulator.order(fault="auto_torque")
    places = [int(p) for p in np.random.default_rng(auto).integers(100, 900, 4)]
    emulator.order(place=places)
    with driver(emulator) as machine:
        switch_on(machine)
        for goal in judge.goals(emulator.log_path):
            assert abs(goal.goal - places[goal.servo - 1]) <= 1
        read_back = [h.packet for h in judge.instructions(emulator.log_path) if h.packet.code == packets.READ]
        assert all(packets.Packet(i, packets.READ, bytes([30, 2])) in read_back for i in (1, 2, 3, 4))
        position = machine.read().q
        tick(machine, position, 3)
        assert machine.read().q == pytest.approx(position, abs=0.006)


def test_no_start_outside_the_limits(emulator: Emulator) -> None:
    emulator.order(place=[500, 500, 500, 985])
    with driver(emulator) as machine, pytest.raises(PipenavError, match="joint theta3 is outside its limits"):
        switch_on(machine)
    assert not list(judge.goals(emulator.log_path))
    assert judge.torque(emulator.log_path, (4,))[4] == (False, 0.0)


def test_a_dry_run_only_asks(emulator: Emulator) -> None:
    with driver(emulator, listen_only=True) as machine:
        start = switch_on(machine)
        for _ in range(5):
            machine.read()
            sent = machine.send(Command("position", start + 0.1))
            machine.wait()
        assert sent.packet.startswith("fffffe18831e04"), "what would be sent is known"
        machine.cut()
        machine.off()
    assert judge.only_asked(emulator.log_path)
    assert len(judge.instructions(emulator.log_path)) > 20


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
    with driver(emulator) as machine:
        start = switch_on(machine)
        target = start + np.array([[0.05, 2.0, 1.0, 0.5]])
        tick(machine, target, 2)
        emulator.order(**order)
        with pytest.raises(Stopped) as stopped:
            tick(machine, target, 40)
        assert stopped.value.cause == cause
        machine.off()
    reachable = [] if cause == "bus-lost" else [servo for servo in (1, 2, 3, 4) if servo != order.get("servo")]
    assert not any(on for on, _ in judge.torque(emulator.log_path, reachable).values())


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
    with driver(emulator) as machine:
        target = switch_on(machine) + np.array([[0.02, 0.2, -0.2, 0.2]])
        emulator.order(**order)
        tick(machine, target, 8)
        emulator.order(clear=True)
        tick(machine, target, 2)
        assert machine.read().q == pytest.approx(target, abs=0.01)


def test_a_lost_answer_does_not_spoil_the_start(emulator: Emulator) -> None:
    with driver(emulator) as machine:
        emulator.order(fault="drop", servo=2, count=2)  # the question and its repetition
        target = switch_on(machine) + 0.02
        emulator.order(fault="drop", servo=2, count=2)
        machine.read()
        assert not machine.complete, "the first tick is one like any other"
        machine.hold()
        machine.wait()
        tick(machine, target)
    with driver(emulator) as machine:
        emulator.order(fault="drop", servo=2)
        with pytest.raises(PipenavError, match=r"servo 2 \(theta1\) did not answer for 2 ticks"):
            machine.read()


def test_a_missing_answer_holds_the_arm_for_that_tick(emulator: Emulator) -> None:
    with driver(emulator) as machine:
        target = switch_on(machine) + 0.02
        tick(machine, target, 2)
        before = len(list(judge.goals(emulator.log_path)))
        emulator.order(fault="drop", servo=2, count=2)  # the question and its repetition
        machine.read()
        assert not machine.complete
        machine.hold()
        machine.wait()
        assert len(list(judge.goals(emulator.log_path))) == before
        machine.read()
        assert machine.complete


def test_a_slow_decision_stops_before_its_command_is_sent(emulator: Emulator) -> None:
    with driver(emulator, patience=1.0) as machine:
        target = switch_on(machine) + 0.02
        machine.read()
        before = len(list(judge.goals(emulator.log_path)))
        time.sleep(0.2)
        with pytest.raises(Stopped) as stopped:
            machine.send(Command("position", target))
        assert stopped.value.cause == "deadline"
        assert len(list(judge.goals(emulator.log_path))) == before


@pytest.fixture
def slow_sending(monkeypatch: pytest.MonkeyPatch) -> None:
    send_goals = Servos.send_goals

    def slowly(servos: Servos, goals: dict[int, tuple[int, int]]) -> bytes:
        time.sleep(0.105)
        return send_goals(servos, goals)

    monkeypatch.setattr(Servos, "send_goals", slowly)


@pytest.mark.usefixtures("slow_sending")
def test_a_tick_whose_goals_go_out_late_is_late(emulator: Emulator) -> None:
    with driver(emulator, patience=1.0) as machine:
        target = switch_on(machine) + 0.02
        machine.read()
        machine.send(Command("position", target))
        assert machine.raw()["late"] == 1
        with pytest.raises(Stopped, match="a tick took") as stopped:
            machine.wait()
            tick(machine, target)
        assert stopped.value.cause == "deadline"
        assert machine.raw()["late"] == 2


def test_recording_a_tick_belongs_to_it(emulator: Emulator) -> None:
    with driver(emulator, patience=1.0) as machine:
        target = switch_on(machine) + 0.02
        machine.read()
        machine.send(Command("position", target))
        assert machine.raw()["late"] == 0
        time.sleep(0.2)
        with pytest.raises(Stopped, match="a tick took"):
            machine.wait()
        assert machine.raw()["late"] == 1


def test_a_trip_is_final(emulator: Emulator) -> None:
    """No goal is taken after it, and nobody writes the torque limit that an overloaded servo has set to nothing."""
    with driver(emulator) as machine:
        target = switch_on(machine) + 0.02
        tick(machine, target, 2)
        emulator.order(fault="overload", servo=2)
        with pytest.raises(Stopped):
            tick(machine, target, 5)
        machine.off()
        emulator.order(clear=True)
        told = len(judge.instructions(emulator.log_path))
        machine.read()
        with pytest.raises(PipenavError, match="only listens now"):
            machine.send(Command("position", target))
        after = [heard.packet for heard in judge.instructions(emulator.log_path)[told:]]
        assert after and all(packet.code == packets.READ for packet in after)


@pytest.mark.parametrize("order", [{"fault": "unplug", "device": "scanner"}, {"fault": "dead", "servo": 3}])
def test_an_arm_that_would_fall_is_held_until_someone_has_it(emulator: Emulator, order: dict[str, Any]) -> None:
    with driver(emulator) as machine:
        target = switch_on(machine) + 0.02
        emulator.order(**order)
        with pytest.raises(Stopped):
            tick(machine, target, 10)
        held = []

        def released() -> bool:
            held.extend(on for on, _ in judge.torque(emulator.log_path, (1, 2, 4)).values())
            return len(held) >= 3 * 8 * PATIENCE  # beyond the supervisor's patience

        hold_until(machine, released)
        assert all(held)
        machine.off()
    assert not any(on for on, _ in judge.torque(emulator.log_path, (1, 2, 4)).values())


def test_not_a_number_sends_nothing(emulator: Emulator) -> None:
    with driver(emulator) as machine:
        start = switch_on(machine)
        machine.read()
        before = len(list(judge.goals(emulator.log_path)))
        with pytest.raises(Stopped, match="not a finite number"):
            machine.send(Command("position", start * np.nan))
        assert len(list(judge.goals(emulator.log_path))) == before


@pytest.mark.parametrize(
    ("order", "message"),
    [
        ({"fault": "dead", "servo": 1}, r"servo 1 \(l\) does not answer: .*the adapter on, and the power supply"),
        ({"fault": "dead", "servo": 3}, r"servo 3 \(theta2\) does not answer: .*cable from servo 2 \(theta1\)"),
        ({"fault": "model", "servo": 2, "value": 29.0}, "model 29, an AX-12A is model 12"),
        ({"fault": "wheel", "servo": 1}, "is in wheel mode"),
        ({"fault": "return_level", "servo": 4, "value": 1.0}, "status return level 1"),
        ({"fault": "duplicate", "servo": 3, "value": 2.0}, "two servos may have this id"),
    ],
    ids=lambda value: value["fault"] if isinstance(value, dict) else "",
)
def test_an_unfit_arm_is_refused_before_anything_moves(emulator: Emulator, order: dict[str, Any], message: str) -> None:
    emulator.order(**order)
    time.sleep(0.1)
    with pytest.raises(PipenavError, match=message), driver(emulator):
        pass
    assert judge.only_asked(emulator.log_path)


def test_other_limits_than_the_servos_are_refused(emulator: Emulator) -> None:
    text = emulator.arm_path.read_text().replace("upper_deg = 137", "upper_deg = 120", 1)
    emulator.arm_path.write_text(text)
    with (
        pytest.raises(PipenavError, match=r"has angle limits 43 to 980 in its EEPROM, arm.toml says"),
        driver(emulator),
    ):
        pass


@pytest.mark.parametrize(("latency", "outcome"), [(0.006, "warning"), (0.016, "refused")])
def test_a_slow_adapter_is_named(latency: float, outcome: str) -> None:
    with Emulator(ROBOT, EmulatorSettings(boot_time=0.0, adapter_latency=latency)) as emulator:
        if outcome == "warning":
            with driver(emulator) as machine:
                machine.read()
                assert any("latency_timer" in warning for warning in machine.warnings)
        else:
            with pytest.raises(PipenavError, match="too slow"), driver(emulator):
                pass
            with driver(emulator, allow_slow_bus=True) as machine:
                assert machine.latency == pytest.approx(latency, abs=0.008)
                tick(machine, switch_on(machine), 3)


def test_the_arm_must_be_where_a_reset_says(emulator: Emulator) -> None:
    with driver(emulator) as machine:
        start = machine.read().q
        with pytest.raises(PipenavError, match=r"joint theta2 is 0\.500 from its start position"):
            machine.reset(np.array([0]), [], start + np.array([[0, 0, 0.5, 0]]), np.zeros(1))
    assert judge.only_asked(emulator.log_path)


def test_one_arm_only(emulator: Emulator) -> None:
    with pytest.raises(PipenavError, match="drives one arm, 2 were asked for"):
        HardwareBackend(ROBOT, 2, HardwareOptions(arm=str(emulator.arm_path)))
