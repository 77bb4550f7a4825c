"""Judgements of what servos say about themselves: the same for `hw-check` and for every connection."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

from pipenav.backends import CONTROL_PERIOD, Finding
from pipenav.errors import PipenavError
from pipenav_hardware import table
from pipenav_hardware.arm_config import DEFAULT_ARM, ArmConfig
from pipenav_hardware.dynamixel import Bus
from pipenav_hardware.servo_config import Servo

BITS_PER_BYTE = 10
PING_BYTES = 12
"""Bytes on the line for a PING and its answer."""

READ_BYTES = 8 + 6 + table.SETTINGS_SIZE + table.STATE_SIZE
"""Bytes on the line for one servo's question and answer of a tick."""

GOAL_BYTES = 1 + table.GOAL_SIZE
"""Bytes on the line for one servo's goal, beside the 8 of their packet."""

MOST_TEMPERATURE = table.TEMPERATURE_LIMIT.initial
"""Highest temperature limit; the manual says not to set a higher one [deg C]."""


def named(servo: Servo) -> str:
    """Name of a servo in messages."""
    return f"servo {servo.id} ({servo.joint})"


def storing(path: Path) -> str:
    """Advice to store an arm's settings in its servos, with a command that works as typed."""
    where = "" if path == DEFAULT_ARM else f" --arm {shlex.quote(str(path))}"
    return f"store the arm's settings in the servos: pipenav calibrate --store-only{where}"


def memory_flaws(servo: Servo, eeprom: table.Eeprom, store: str) -> Iterator[Finding]:
    """Settings in a servo's EEPROM that are not the arm's; a problem keeps the arm from being switched on.

    Args:
        servo: the servo's description.
        eeprom: what it says.
        store: advice to store the arm's settings, see `storing`.
    """
    name = named(servo)
    low, high = servo.count_limits
    if eeprom.model != table.MODEL_NUMBER:
        wanted = table.MODEL_NUMBER
        yield Finding("problem", f"{name} says it is model {eeprom.model}, an AX-12A is model {wanted}", "replace it")
    if eeprom.limits == table.WHEEL_MODE:
        yield Finding("problem", f"{name} is in wheel mode, in which it keeps turning when this program dies", store)
    elif eeprom.limits != (low, high):
        found = f"has angle limits {eeprom.limits[0]} to {eeprom.limits[1]} in its EEPROM"
        yield Finding("problem", f"{name} {found}, arm.toml says {low} to {high}", store)
    if eeprom.max_torque > servo.torque_counts:
        found = f"has max torque {eeprom.max_torque} in its EEPROM, arm.toml allows {servo.torque_counts}"
        yield Finding("problem", f"{name} {found}: after a power dip it would be too strong", store)
    if eeprom.shutdown & table.SHUTDOWN_ALARMS != table.SHUTDOWN_ALARMS:
        found = f"does not switch itself off on overload and overheating (register 18 is {eeprom.shutdown})"
        yield Finding("problem", f"{name} {found}", store)
    if eeprom.temperature_limit > MOST_TEMPERATURE:
        found = f"shuts down only at {eeprom.temperature_limit} deg C (register 11), {MOST_TEMPERATURE} is allowed"
        yield Finding("problem", f"{name} {found}", store)
    if eeprom.return_level != table.RETURN_LEVEL.initial:
        found = f"has status return level {eeprom.return_level}, {table.RETURN_LEVEL.initial} is needed"
        yield Finding("problem", f"{name} {found}: it answers questions but not orders", store)
    if eeprom.return_delay:
        yield Finding("warning", f"{name} waits {2 * eeprom.return_delay} us before it answers", store)


def half_silent(servo: Servo, bus: Bus, store: str) -> Finding | None:
    """The finding about a servo that gives no data and yet is there; None where it is silent altogether."""
    if bus.ping(servo.id).data is None and bus.ping(servo.id).data is None:
        return None
    what = f"{named(servo)} answers PING but no other question: its cable works, its status return level is 0"
    return Finding("problem", what, store)


def wire_time(size: int, baud: int) -> float:
    """Time that bytes take on the line [s]."""
    return size * BITS_PER_BYTE / baud


def tick_bytes(servos: int) -> int:
    """Number of bytes on the line in a tick: every servo's question and answer, and the packet of all goals."""
    return servos * READ_BYTES + 8 + servos * GOAL_BYTES


def speed_flaw(arm: ArmConfig, waiting: float = 0.0) -> Finding | None:
    """The finding about a bus whose speed cannot keep the control loop's rate; None where it can.

    Args:
        arm: the arm's description.
        waiting: time from a question to its answer, beside that of their bytes [s].
    """
    count, size, allowed = len(arm.servos), tick_bytes(len(arm.servos)), CONTROL_PERIOD
    parts = {
        f"{size} bytes a tick take": wire_time(size, arm.baud),
        "a question asked once more": wire_time(READ_BYTES, arm.baud),
        f"{count} waits for answers": count * waiting,
    }
    if sum(parts.values()) <= allowed:
        return None
    sum_of = ", ".join(f"{part} {time * 1e3:.0f} ms" for part, time in parts.items() if time)
    what = f"{arm.baud} baud is too slow for the arm: {sum_of}, a tick has {allowed * 1e3:.0f} ms"
    return Finding("problem", what, "set the servos (register 4 to 1) and baud in arm.toml to 1000000")


def require(finding: Finding | None) -> None:
    """Refuse a problem.

    Raises:
        PipenavError: there is one.
    """
    if finding is not None and finding.level == "problem":
        raise PipenavError(f"{finding.what}: {finding.remedy}.")
