"""The arm's servos as one: checked when they are met, switched on without a jump, read and told together."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import NamedTuple

from pipenav.backends import Stopped
from pipenav.errors import PipenavError
from pipenav_hardware import table
from pipenav_hardware.arm_config import ArmConfig, Servo
from pipenav_hardware.dynamixel import Bus, BusLost, Mode
from pipenav_hardware.table import Alarm, State

PINGS = 10
SLOW, TOO_SLOW = 0.004, 0.012
"""Median answer time that deserves a warning, and that is refused [s]: FTDI adapters wait 16 ms unless told not to."""

LATENCY_REMEDY = (
    'set the adapter\'s latency to 1 ms with the udev rule SUBSYSTEM=="usb-serial", ATTR{latency_timer}="1"'
)


class Told(NamedTuple):
    """One tick's answers: state and settings of each servo as bytes or None, and their alarms."""

    states: tuple[bytes | None, ...]
    settings: tuple[bytes | None, ...]
    alarms: tuple[Alarm, ...]


class Servos:
    """What is said to all servos of an arm.

    Attributes:
        latency: median answer time, measured when they were met [s].
        warnings: what is worth knowing and no reason to refuse.
    """

    def __init__(self, arm: ArmConfig, bus: Bus, allow_slow: bool = False) -> None:
        self._arm, self._bus = arm, bus
        self.warnings: list[str] = []
        if bus.echoes():
            raise PipenavError(
                f"the adapter on {bus.name} sends back what is sent: use one that switches direction by itself "
                "(USB2Dynamixel, U2D2), or wire its receiver so that it is off while it sends."
            )
        for index, servo in enumerate(arm.servos):
            self._meet(index, servo)
        self.latency = self._measure(allow_slow)
        self._written: dict[int, tuple[int, int, int]] = {}

    def read(self) -> Told:
        """Settings and state of every servo: single READs, for the AX-12A knows neither sync read nor bulk read.

        Both lie side by side, and 12 bytes more take a tenth of the time that a question of their own would.
        """
        size = table.SETTINGS_SIZE
        answers = [self._bus.read(servo, table.SETTINGS_ADDRESS, size + table.STATE_SIZE) for servo in self._arm.ids]
        known = [answer.data for answer in answers]
        return Told(
            states=tuple(data and data[size:] for data in known),
            settings=tuple(data and data[:size] for data in known),
            alarms=tuple(answer.alarms for answer in answers),
        )

    def enable(self, speeds: list[int], alive: Callable[[], None]) -> list[int]:
        """Switch torque on without a jump, one servo after the other: goal := where it is, read back, then torque.

        Args:
            speeds: Moving Speed of each servo.
            alive: called often, for the supervisor.

        Returns:
            The goals, in joint order.

        Raises:
            PipenavError: a joint outside its limits, or a servo that does not take a value.
        """
        positions = [self._position_of(servo) for servo in self._arm.servos]
        self._bus.mode = Mode.DRIVE
        for servo, position, speed in zip(self._arm.servos, positions, speeds, strict=True):
            values = {
                table.TORQUE_LIMIT: servo.torque_counts,
                table.MOVING_SPEED: speed,
                table.GOAL_POSITION: position,
                table.TORQUE_ENABLE: 1,
            }
            for register, value in values.items():
                alive()
                if not self._bus.write_register(servo.id, register, value):
                    raise Stopped(
                        "comms", f"servo {servo.id} ({servo.joint}) does not take a value", "run pipenav hw-check"
                    )
            self._written[servo.id] = (1, speed, servo.torque_counts)
        return positions

    def tell(self, goals: dict[int, tuple[int, int]]) -> bytes:
        """Send every servo its goal; the packet."""
        return self._bus.send_goals(goals)

    def verify(self, settings: tuple[bytes | None, ...]) -> None:
        """Whether every servo still has the settings that it was given: one that lost power comes back without, and
        answers as if nothing had happened.

        Args:
            settings: as they were read; None where a servo did not answer.

        Raises:
            Stopped: one has not.
        """
        offset = table.SETTINGS_ADDRESS
        for servo, data in zip(self._arm.servos, settings, strict=True):
            if data is None:
                continue
            speed, limit = (table.word(data, r.address - offset) for r in (table.MOVING_SPEED, table.TORQUE_LIMIT))
            if (data[0], speed, limit) != self._written[servo.id]:
                raise Stopped(
                    "power-dip",
                    f"servo {servo.id} ({servo.joint}) lost its settings (torque {data[0]}, speed {speed}, "
                    f"limit {limit})",
                    "it lost power or shut itself down: check supply and cables, then start again",
                )

    def _meet(self, index: int, servo: Servo) -> None:
        """Compare one servo with the arm's description."""
        name, bus = f"servo {servo.id} ({servo.joint})", self._bus
        answer = bus.read(servo.id, 0, table.SHUTDOWN.end)
        if answer.data is None:
            raise PipenavError(
                f"{name} does not answer: {self._cable(index, answer.problem)}, or run pipenav hw-check."
            )
        eeprom = answer.data
        model = table.word(eeprom, table.MODEL.address)
        if model != table.MODEL_NUMBER:
            raise PipenavError(f"{name} says it is model {model}, an AX-12A is model {table.MODEL_NUMBER}: replace it.")
        limits = (table.word(eeprom, table.CW_LIMIT.address), table.word(eeprom, table.CCW_LIMIT.address))
        if limits == (0, 0):
            raise PipenavError(
                f"{name} is in wheel mode, in which it keeps turning when this program dies: "
                "set its angle limits with pipenav calibrate --write-servos."
            )
        if limits != servo.count_limits:
            raise PipenavError(
                f"{name} has angle limits {limits[0]} to {limits[1]} in its EEPROM, arm.toml says "
                f"{servo.count_limits[0]} to {servo.count_limits[1]}: run pipenav calibrate --write-servos."
            )
        if eeprom[table.RETURN_LEVEL.address] != 2:
            level = eeprom[table.RETURN_LEVEL.address]
            raise PipenavError(
                f"{name} has status return level {level}, 2 is needed: pipenav calibrate --write-servos."
            )
        if table.word(eeprom, table.MAX_TORQUE.address) > servo.torque_counts:
            raise PipenavError(
                f"{name} has max torque {table.word(eeprom, table.MAX_TORQUE.address)} in its EEPROM, arm.toml allows "
                f"{servo.torque_counts}: after a power dip it would be too strong; pipenav calibrate --write-servos."
            )
        if eeprom[table.SHUTDOWN.address] & 36 != 36:
            self.warnings.append(f"{name} does not shut down on overload and overheating (register 18)")
        if eeprom[table.RETURN_DELAY.address]:
            delay = 2 * eeprom[table.RETURN_DELAY.address]
            self.warnings.append(f"{name} waits {delay} us before it answers: pipenav calibrate --write-servos sets 0")

    def _cable(self, index: int, problem: str) -> str:
        before = self._arm.servos[index - 1]
        start = f"from servo {before.id} ({before.joint}) on" if index else "from the adapter on, and the power supply"
        twins = "; two servos may have this id" if "damaged" in problem else ""
        return f"{problem}{twins}; check the cable {start}"

    def _measure(self, allow_slow: bool) -> float:
        """Median time of a PING."""
        times, bus = [], self._bus
        for i in range(PINGS):
            start = time.monotonic()
            answered = bus.ping(self._arm.ids[i % len(self._arm.ids)]).data is not None
            if answered:
                times.append(time.monotonic() - start)
        latency = statistics.median(times) if times else float("inf")
        if times:
            bus.expect(max(0.0, latency - SLOW))
        if latency > TOO_SLOW and not allow_slow:
            raise PipenavError(
                f"servos answer after {latency * 1e3:.1f} ms, which is too slow: {LATENCY_REMEDY}, or --allow-slow-bus."
            )
        if latency > SLOW:
            self.warnings.append(f"servos answer after {latency * 1e3:.1f} ms: {LATENCY_REMEDY}")
        return latency

    def _position_of(self, servo: Servo) -> int:
        data = self._bus.read(servo.id, table.STATE_ADDRESS, table.STATE_SIZE).data
        if data is None:
            raise BusLost(self._bus.name, f"servo {servo.id} ({servo.joint}) does not answer")
        state: State = table.decode_state(data)
        low, high = servo.count_limits
        if not low <= state.position <= high:
            raise PipenavError(
                f"joint {servo.joint} is outside its limits ({state.position} counts, allowed {low} to {high}): "
                "move it back by hand, then start again."
            )
        return state.position
