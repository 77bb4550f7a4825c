"""Storing an arm's settings in its servos' EEPROM, which keeps the arm safe when no program can."""

from __future__ import annotations

from pathlib import Path

from pipenav.errors import PipenavError
from pipenav_hardware import table
from pipenav_hardware.arm_config import ArmConfig, load_arm
from pipenav_hardware.dynamixel import Bus
from pipenav_hardware.serial_port import Mode
from pipenav_hardware.servo_config import Servo
from pipenav_hardware.servo_flaws import MOST_TEMPERATURE, named

STORED = {
    table.RETURN_DELAY: 0,
    table.RETURN_LEVEL: 2,
    table.SHUTDOWN: table.SHUTDOWN_ALARMS,
}
"""Content of every servo's EEPROM besides its limits."""

UNLOCK = "switch the supply off and on"


def store_described(path: Path) -> list[str]:
    """Store what an arm's description says in its servos; see `store_settings`."""
    arm = load_arm(path)
    bus = Bus(arm.port, arm.baud)
    try:
        return store_settings(arm, bus)
    finally:
        bus.close()


def store_settings(arm: ArmConfig, bus: Bus) -> list[str]:
    """Store an arm's settings in its servos, and read them back.

    Returns:
        What was stored, one line for each servo.

    Raises:
        PipenavError: a servo does not answer, is locked, or does not keep a value.
    """
    bus.mode = Mode.DRIVE
    try:
        return [_store(servo, bus) for servo in arm.servos]
    finally:
        bus.mode = Mode.STOPPED


def make_ready(servo: Servo, bus: Bus) -> None:
    """Have a servo answer every question, with its torque off and its EEPROM open.

    Raises:
        PipenavError: it does not answer at all, or its EEPROM is locked.
    """
    mode, bus.mode = bus.mode, Mode.DRIVE
    try:
        bus.write_register(
            servo.id, table.TORQUE_ENABLE, 0, retries=0
        )  # a servo changes its EEPROM only without torque
        if bus.read_register(servo.id, table.MODEL) is None:
            if bus.ping(servo.id).data is None:
                raise PipenavError(f"{named(servo)} does not answer: run pipenav hw-check.")
            if not bus.write_register(servo.id, table.RETURN_LEVEL, STORED[table.RETURN_LEVEL]):
                raise PipenavError(
                    f"{named(servo)} answers PING but no other question, and keeps its status return level: its EEPROM "
                    f"may be locked; {UNLOCK}, then start again."
                )
        if bus.read_register(servo.id, table.LOCK):
            raise PipenavError(
                f"{named(servo)}: its EEPROM is locked until it loses power: {UNLOCK}, then start again."
            )
    finally:
        bus.mode = mode


def _store(servo: Servo, bus: Bus) -> str:
    make_ready(servo, bus)
    low, high = servo.count_limits
    values = {table.CW_LIMIT: low, table.CCW_LIMIT: high, table.MAX_TORQUE: servo.torque_counts, **STORED}
    if (bus.read_register(servo.id, table.TEMPERATURE_LIMIT) or 0) > MOST_TEMPERATURE:
        values[table.TEMPERATURE_LIMIT] = MOST_TEMPERATURE
    for register, value in values.items():
        if not bus.write_register(servo.id, register, int(value)):
            raise PipenavError(
                f"{named(servo)} does not keep {int(value)} in register {register.address}: check its cable, {UNLOCK}, "
                "then start again."
            )
    share = servo.torque_limit_percent
    return f"{named(servo)}: limits {low}-{high}, torque {share:.0f} %, delay 0"
