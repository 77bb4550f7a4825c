"""The whole driver against the emulator's process, judged by the bytes that reached the servos."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.emulated import ROBOT, driver, reach, switch_on, tick
from pipenav_hardware import packets
from pipenav_hardware.backend import HardwareBackend, HardwareOptions
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings

from pipenav.backends.messages import Command
from pipenav.backends.safety import Stopped
from pipenav.errors import PipenavError

pytestmark = pytest.mark.realtime


def test_the_arm_goes_to_its_target_within_its_limits(emulator: Emulator) -> None:
    with driver(emulator) as arm:
        start = switch_on(arm)
        reach(arm, start + np.array([[0.03, 0.5, -0.5, 0.3]]))
        steps = arm._codec.bounds.step
        assert arm.off() == []
    limits = {servo.id: servo.count_limits for servo in emulator.arm.servos}
    goals = list(byte_log.goals(emulator.log_path))
    assert len(goals) > 4 * 3, "it takes several steps"
    for goal in goals:
        low, high = limits[goal.servo]
        step = steps[goal.servo - 1]
        assert low <= goal.goal <= high
        assert goal.present is not None and abs(goal.goal - goal.present) <= step + 2
        assert goal.last is None or abs(goal.goal - goal.last) <= step
        assert goal.speed is None or goal.speed >= 1
    assert not any(on for on, _ in byte_log.torque(emulator.log_path, (1, 2, 3, 4)).values())


@pytest.mark.parametrize("auto", [False, True])
def test_torque_comes_on_without_a_jump(emulator: Emulator, auto: bool) -> None:
    """It holds for every start pose, and for servos that switch torque on when they get a goal."""
    if auto:
        emulator.order(fault="auto_torque")
    places = [int(p) for p in np.random.default_rng(auto).integers(100, 900, 4)]
    emulator.order(place=places)
    with driver(emulator) as arm:
        switch_on(arm)
        for goal in byte_log.goals(emulator.log_path):
            assert abs(goal.goal - places[goal.servo - 1]) <= 1
        read_back = [h.packet for h in byte_log.instructions(emulator.log_path) if h.packet.code == packets.READ]
        assert all(packets.Packet(i, packets.READ, bytes([30, 2])) in read_back for i in (1, 2, 3, 4))
        position = arm.read().q
        tick(arm, position, 3)
        assert arm.read().q == pytest.approx(position, abs=0.006)


def test_no_start_outside_the_limits(emulator: Emulator) -> None:
    emulator.order(place=[500, 500, 500, 985])
    with driver(emulator) as arm, pytest.raises(PipenavError, match="joint theta3 is outside its limits"):
        switch_on(arm)
    assert not list(byte_log.goals(emulator.log_path))
    assert byte_log.torque(emulator.log_path, (4,))[4] == (False, 0.0)


def test_a_dry_run_only_asks(emulator: Emulator) -> None:
    with driver(emulator, listen_only=True) as arm:
        start = switch_on(arm)
        for _ in range(5):
            arm.read()
            sent = arm.send(Command("position", start + 0.1))
            arm.wait()
        assert sent.packet.startswith("fffffe18831e04"), "what would be sent is known"
        arm.cut()
        arm.off()
    assert byte_log.only_asked(emulator.log_path)
    assert len(byte_log.instructions(emulator.log_path)) > 20


def test_not_a_number_sends_nothing(emulator: Emulator) -> None:
    with driver(emulator) as arm:
        start = switch_on(arm)
        arm.read()
        before = len(list(byte_log.goals(emulator.log_path)))
        with pytest.raises(Stopped, match="not a finite number"):
            arm.send(Command("position", start * np.nan))
        assert len(list(byte_log.goals(emulator.log_path))) == before


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
            with driver(emulator) as arm:
                arm.read()
                assert any("latency_timer" in warning for warning in arm.warnings)
        else:
            with pytest.raises(PipenavError, match="too slow"), driver(emulator, allow_slow_bus=False):
                pass
            with driver(emulator) as arm:
                assert arm.latency > latency
                tick(arm, switch_on(arm), 3)


def test_the_arm_must_be_where_a_reset_says(emulator: Emulator) -> None:
    with driver(emulator) as arm:
        start = arm.read().q
        with pytest.raises(PipenavError, match=r"joint theta2 is 0\.500 rad from its start position"):
            arm.reset(np.array([0]), [], start + np.array([[0, 0, 0.5, 0]]), np.zeros(1))
    assert byte_log.only_asked(emulator.log_path)


def test_one_arm_only(emulator: Emulator) -> None:
    with pytest.raises(PipenavError, match="drives one arm, 2 were asked for"):
        HardwareBackend(ROBOT, 2, HardwareOptions(arm=str(emulator.arm_path)))
