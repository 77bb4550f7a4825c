"""Time that a tick waits for the servos, on a clock that only waiting moves: no busy machine changes it."""

from __future__ import annotations

import heapq
import types
from collections.abc import Sequence

import pytest
from pipenav_hardware import dynamixel, serial_port
from pipenav_hardware.arm_config import ScannerConfig, default_arm
from pipenav_hardware.dynamixel import Bus
from pipenav_hardware.emulator.bus import ServoBus
from pipenav_hardware.emulator.faults import Fault, FaultScript
from pipenav_hardware.emulator.free_plant import FreePlant
from pipenav_hardware.emulator.servo import EmulatedServo
from pipenav_hardware.serial_port import READ_SLICE, Port
from pipenav_hardware.servos import Servos

from pipenav.robots.robot import load_robot

BAUD = 1_000_000
ARM = default_arm(load_robot("real-setup"), "servos", ScannerConfig(driver="scip2", port="scanner"), None)
HEALTHY, ONE_DEAD = 0.010, 0.040
"""Longest reading of all servos that is promised [s]: behind an adapter of 1 ms; with a dead one, of up to 3 ms."""


class Wire:
    """The emulated servos without a terminal and without a process."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, latency: float) -> None:
        self.now, self._heard = 0.0, b""
        self._answers: list[tuple[float, bytes]] = []
        self.faults = FaultScript([], 0)
        servos = [EmulatedServo(servo.id, servo.count_limits, servo.torque_counts) for servo in ARM.servos]
        self._bus = ServoBus(servos, FreePlant(len(servos)), self.faults, self._answer, latency)
        for module in (dynamixel, serial_port):
            monkeypatch.setattr(module, "time", types.SimpleNamespace(monotonic=lambda: self.now))
        for name in ("setupPort", "writePort", "readPort", "clearPort", "flush"):
            method = getattr(self, name)
            monkeypatch.setattr(Port, name, lambda _port, *given, method=method: method(*given))
        monkeypatch.setattr(Port, "tx_time_per_byte", 10_000 / BAUD, raising=False)

    def setupPort(self, _flag: int) -> bool:
        return True

    def writePort(self, packet: Sequence[int]) -> int:
        self._bus.receive(self.now, bytes(packet), BAUD)
        return len(packet)

    def readPort(self, length: int) -> bytes:
        if not self._heard:
            if self._answers and self._answers[0][0] <= self.now + READ_SLICE:
                due, answer = heapq.heappop(self._answers)
                self.now, self._heard = max(self.now, due), answer
            else:
                self.now += READ_SLICE
        data, self._heard = self._heard[:length], self._heard[length:]
        return data

    def clearPort(self) -> None:
        self._heard = b""

    def flush(self) -> None:
        self._heard = b""

    def _answer(self, delay: float, data: bytes) -> None:
        heapq.heappush(self._answers, (self.now + delay, data))


@pytest.mark.parametrize("latency", [0.0, 0.001, 0.003])
@pytest.mark.parametrize("dead", [None, 1, 2, 3, 4])
def test_no_servo_uses_up_a_tick(monkeypatch: pytest.MonkeyPatch, dead: int | None, latency: float) -> None:
    wire = Wire(monkeypatch, latency)
    servos = Servos(ARM, Bus("servos", BAUD))
    if dead is not None:
        wire.faults.add(Fault(fault="dead", servo=dead))
    for _ in range(3):  # an arm stops in the second such tick; in none of them a question waits for an earlier answer
        begun = wire.now
        told = servos.read()
        assert [state is None for state in told.states] == [servo == dead for servo in ARM.ids]
        assert wire.now - begun <= (ONE_DEAD if dead else HEALTHY + 4 * max(0.0, latency - 0.001))
        wire.now += 0.06
