"""The arm's servos as one: checked when they are met, switched on without a jump, read and commanded together."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from pipenav.backends import Finding, Stopped
from pipenav.errors import PipenavError
from pipenav_hardware import table
from pipenav_hardware.arm_config import DEFAULT_ARM, ArmConfig
from pipenav_hardware.dynamixel import Bus, BusLost
from pipenav_hardware.serial_port import Mode
from pipenav_hardware.servo_config import Servo
from pipenav_hardware.servo_flaws import (
    PING_BYTES,
    half_silent,
    memory_flaws,
    named,
    require,
    speed_flaw,
    storing,
    wire_time,
)
from pipenav_hardware.table import Alarm, ServoGoal, State

PINGS = 10
"""Number of questions by which the bus's latency is measured."""

SLOW, TOO_SLOW = 0.004, 0.012
"""Median answer time that deserves a warning, and that is refused [s]: FTDI adapters wait 16 ms by default."""

LATENCY_REMEDY = (
    'set the adapter\'s latency to 1 ms with the udev rule SUBSYSTEM=="usb-serial", ATTR{latency_timer}="1"'
)


def latency_finding(waiting: float, allow_slow: bool) -> Finding:
    """Finding about the time that the servos take to answer.

    Args:
        waiting: median time from a question to its answer, beside that of their bytes [s].
        allow_slow: whether a slow adapter is accepted.
    """
    what = f"servos answer after {waiting * 1e3:.1f} ms (median of {PINGS})"
    if waiting > TOO_SLOW and not allow_slow:
        return Finding(
            "problem", f"{what}, which is too slow", f"{LATENCY_REMEDY}, or add --allow-slow-bus to pipenav run-real"
        )
    return Finding("warning", what, LATENCY_REMEDY) if waiting > SLOW else Finding("ok", what)


class ServoAnswers(NamedTuple):
    """The servos' answers of one tick.

    Attributes:
        states: state of every servo as bytes; None where it did not answer.
        settings: settings of every servo as bytes; None where it did not answer.
        alarms: alarms of every servo.
    """

    states: tuple[bytes | None, ...]
    settings: tuple[bytes | None, ...]
    alarms: tuple[Alarm, ...]


class _Settings(NamedTuple):
    """Settings that a servo was given, and must keep."""

    torque_enable: int
    speed: int
    torque_limit: int


class Servos:
    """All servos of an arm.

    Attributes:
        latency: median answer time, measured when they were met [s].
        warnings: what is worth knowing and is no reason to refuse.
    """

    def __init__(self, arm: ArmConfig, bus: Bus, allow_slow: bool = False, path: Path = DEFAULT_ARM) -> None:
        """
        Args:
            arm: the arm's description.
            bus: its servo bus.
            allow_slow: whether an adapter that waits long before it hands on an answer is accepted.
            path: file of the description.
        """
        self._arm, self._bus, self._store = arm, bus, storing(path)
        self.warnings: list[str] = []
        if bus.echoes():
            raise PipenavError(
                f"the adapter on {bus.name} echoes what is sent: use one that switches direction by itself "
                "(USB2Dynamixel, U2D2), or wire its receiver so that it is off while it sends."
            )
        for index, servo in enumerate(arm.servos):
            self._meet(index, servo)
        self.latency = self._measure(allow_slow)
        self._written: dict[int, _Settings] = {}

    def read(self) -> ServoAnswers:
        """Read settings and state of every servo by single READs: the AX-12A knows neither sync read nor bulk read.

        Both lie side by side, and 12 bytes more take a tenth of the time that a question of their own would.
        """
        size = table.SETTINGS_SIZE
        answers = [self._bus.read(servo, table.SETTINGS_ADDRESS, size + table.STATE_SIZE) for servo in self._arm.ids]
        known = [answer.data for answer in answers]
        return ServoAnswers(
            states=tuple(data and data[size:] for data in known),
            settings=tuple(data and data[:size] for data in known),
            alarms=tuple(answer.alarms for answer in answers),
        )

    def enable(self, speeds: list[int], alive: Callable[[], None]) -> list[int]:
        """Switch torque on without a jump, one servo after the other: goal := where it is, read back, then torque.

        Args:
            speeds: Moving Speed of each servo [counts].
            alive: called often, for the supervisor.

        Returns:
            The goals, in joint order [counts].

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
            self._written[servo.id] = _Settings(1, speed, servo.torque_counts)
        return positions

    def send_goals(self, goals: Mapping[int, ServoGoal]) -> bytes:
        """Send every servo its goal, by id.

        Returns:
            The packet.
        """
        return self._bus.send_goals(goals)

    def verify(self, settings: tuple[bytes | None, ...]) -> None:
        """Make sure that every servo still has the settings that it was given.

        A servo that lost power comes back without them, and answers as if nothing had happened.

        Args:
            settings: settings as they were read; None where a servo did not answer.

        Raises:
            Stopped: a servo has other settings.
        """
        offset = table.SETTINGS_ADDRESS
        for servo, data in zip(self._arm.servos, settings, strict=True):
            if data is None:
                continue
            speed, limit = (table.word(data, r.address - offset) for r in (table.MOVING_SPEED, table.TORQUE_LIMIT))
            if _Settings(data[0], speed, limit) != self._written[servo.id]:
                raise Stopped(
                    "power-dip",
                    f"servo {servo.id} ({servo.joint}) lost its settings (torque {data[0]}, speed {speed}, "
                    f"limit {limit})",
                    "it lost power or shut itself down: check supply and cables, then start again",
                )

    def _meet(self, index: int, servo: Servo) -> None:
        """Compare one servo with the arm's description.

        Raises:
            PipenavError: it does not answer, or is not as described.
        """
        answer = self._bus.read(servo.id, *table.EEPROM)
        if answer.data is None:
            require(half_silent(servo, self._bus, self._store))
            cable = self._cable(index, answer.problem)
            raise PipenavError(f"{named(servo)} does not answer: {cable}, or run pipenav hw-check.")
        for finding in memory_flaws(servo, table.decode_eeprom(answer.data), self._store):
            require(finding)
            self.warnings.append(f"{finding.what}: {finding.remedy}")

    def _cable(self, index: int, problem: str) -> str:
        """Why a servo may not answer, and which cable to look at."""
        before = self._arm.servos[index - 1]
        start = f"from servo {before.id} ({before.joint}) on" if index else "from the adapter on, and the power supply"
        twins = "; two servos may have this id" if "damaged" in problem else ""
        return f"{problem}{twins}; check the cable {start}"

    def _measure(self, allow_slow: bool) -> float:
        """Measure the median time of a PING [s], and wait for answers no longer than it demands from now on."""
        times, bus = [], self._bus
        for i in range(PINGS):
            start = time.monotonic()
            answered = bus.ping(self._arm.ids[i % len(self._arm.ids)]).data is not None
            if answered:
                times.append(time.monotonic() - start)
        latency = statistics.median(times) if times else float("inf")
        waiting = latency - wire_time(PING_BYTES, self._arm.baud)
        if times:
            bus.expect(max(0.0, waiting - SLOW))
        finding = latency_finding(waiting, allow_slow)
        require(finding)
        require(speed_flaw(self._arm, waiting) if times and not allow_slow else None)
        if finding.level == "warning":
            self.warnings.append(f"{finding.what}: {finding.remedy}")
        return latency

    def _position_of(self, servo: Servo) -> int:
        """Position of a servo inside its limits [counts]."""
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
