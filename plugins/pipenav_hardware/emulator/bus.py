"""The half-duplex line with its servos: which of them answers what, when, and with which faults."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from pipenav_hardware import packets, table
from pipenav_hardware.emulator.faults import Fault, FaultScript
from pipenav_hardware.emulator.line import Send
from pipenav_hardware.emulator.plant import Plant
from pipenav_hardware.emulator.servo import CONTROL_LOOP, EmulatedServo
from pipenav_hardware.packets import Packet, Stream

BITS_PER_BYTE = 10
PATIENCE = 0.1
"""A servo forgets a packet whose rest does not come within this time [s] (AX-12 manual)."""

SET = {"return_level": table.RETURN_LEVEL, "shutdown": table.SHUTDOWN, "baud": table.BAUD}
"""Faults that set a register to their value."""


class _Reply(NamedTuple):
    """A servo and its status packet."""

    servo: EmulatedServo
    answer: bytes


class ServoBus:
    """Servos on one line, each the motor of a shaft of the plant."""

    def __init__(
        self, servos: Sequence[EmulatedServo], plant: Plant, faults: FaultScript, send: Send, adapter_latency: float
    ) -> None:
        self.servos, self._plant, self._faults = list(servos), plant, faults
        self._send, self._latency = send, adapter_latency
        self._stream = Stream()
        self._heard, self._felt = 0.0, 0.0
        self._stuck: set[int] = set()

    def receive(self, now: float, data: bytes, baud: int) -> None:
        """Take in bytes from the host, sent at the speed that it has set."""
        if self._stream.waiting and now - self._heard > PATIENCE:
            self._stream.forget()
        self._heard = now
        if self._faults.active("echo"):
            self._send(0.0, data)
        listening = [servo for servo in self.servos if table.baud_of(servo.get(table.BAUD)) == baud]
        for packet in self._stream.feed(data):
            self._faults.ticks += packet.code == packets.SYNC_WRITE
            self._carry_out(now, packet, listening)

    def feel(self, now: float) -> None:
        """Bring every servo's readings up to date."""
        self._strike(now)
        shafts = self._plant.shafts(now)
        dt, self._felt = min(now - self._felt, 1.0) if self._felt else 0.0, now
        for servo, shaft in zip(self.servos, shafts, strict=True):
            voltage = self._faults.active("voltage", servo=servo.id)
            sag = 0.3 * sum(abs(one.load) for one in shafts) / len(shafts)
            servo.volts = voltage.value if voltage else 12.0 - sag
            servo.forced = table.Alarm.OVERLOAD if self._faults.active("overload", servo=servo.id) else table.Alarm(0)
            servo.auto_torque_on_goal = self._faults.active("auto_torque", servo=servo.id) is not None
            servo.feel(shaft, dt)

    def begin(self, fault: Fault) -> None:
        """Begin a fault that changes servos once."""
        for i, servo in enumerate(self.servos):
            if fault.servo is not None and fault.servo != servo.id:
                continue
            if fault.fault == "power_dip":
                servo.power_on(servo.get(table.PRESENT_POSITION))
            elif fault.fault == "overheat":
                servo.heat = fault.value
            elif fault.fault == "model":
                servo.model = int(fault.value)
            elif fault.fault == "wheel":
                servo.set(table.CW_LIMIT, 0)
                servo.set(table.CCW_LIMIT, 0)
            elif fault.fault in SET:
                servo.set(SET[fault.fault], int(fault.value))
            elif fault.fault in ("lock", "torque_on"):
                servo.set(table.LOCK if fault.fault == "lock" else table.TORQUE_ENABLE, 1)
            elif fault.fault == "duplicate":
                servo.set(table.ID, int(fault.value))
                break
            self._stuck.discard(i)

    def command(self, now: float) -> None:
        """Give the plant the commands of all motors."""
        self._plant.command(now, [servo.command for servo in self.servos])

    def _strike(self, now: float) -> None:
        """Find out which shafts are held now."""
        self._faults.now = now
        self._plant.stuck = {
            i
            for i, servo in enumerate(self.servos)
            if self._faults.active("stuck", servo=servo.id) or self._faults.active("dead", servo=servo.id)
        }

    def _carry_out(self, now: float, packet: Packet, listening: list[EmulatedServo]) -> None:
        """Have the servos that hear a packet obey it, and send the answer."""
        self.feel(now)
        before = [[servo.get(register) for register in CONTROL_LOOP] for servo in self.servos]
        replies: list[_Reply] = []
        for servo in listening:
            if self._faults.active("dead", servo=servo.id) is None:
                answer = servo.answer(packet)
                if answer is not None:
                    replies.append(_Reply(servo, answer))
        if before != [[servo.get(register) for register in CONTROL_LOOP] for servo in self.servos]:
            self.command(now)
        if replies:
            self._send_answer(packet, replies[0], crowd=len(replies) > 1)

    def _send_answer(self, packet: Packet, reply: _Reply, crowd: bool) -> None:
        """Send an answer in the time that bytes, servo and adapter take, with what goes wrong on the way."""
        faults, asked, answer = self._faults, reply.servo.id, reply.answer
        if faults.active("drop", servo=asked):
            return
        if crowd:  # two servos talk at once: what arrives is neither
            answer = bytes(byte & 0x5A for byte in answer)
        if packet.code == packets.READ and (bare := faults.active("bare_error", servo=asked)):
            answer = Packet(asked, int(bare.value), b"").encode()
        if faults.active("wrong_id", servo=asked):
            answer = Packet(asked + 1, answer[4], answer[5:-1]).encode()
        if faults.active("corrupt", servo=asked):
            position = 2 + faults.number(len(answer) - 2)
            answer = answer[:position] + bytes([answer[position] ^ 1 << faults.number(8)]) + answer[position + 1 :]
        if faults.active("truncate", servo=asked):
            answer = answer[: 3 + faults.number(len(answer) - 4)]
        if faults.active("garbage", servo=asked):
            answer = bytes(faults.number(255) for _ in range(5)) + answer
        byte_time = BITS_PER_BYTE / table.baud_of(reply.servo.get(table.BAUD))
        delay = byte_time * (len(packet.parameters) + 6 + len(answer)) + 2e-6 * reply.servo.get(table.RETURN_DELAY)
        late = faults.active("delay", servo=asked)
        self._send(delay + self._latency + (late.value if late else 0.0), answer)
