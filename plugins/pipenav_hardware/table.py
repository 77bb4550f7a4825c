"""The AX-12A as data: its control table with the manual's addresses, its error bits and its units.

Source: ROBOTIS e-manual, AX-12A (control table, resolutions) and protocol 1.0 (error bits).
"""

from __future__ import annotations

import math
from enum import IntFlag
from typing import NamedTuple

MODEL_NUMBER = 12
COUNTS = 1023
"""Largest position: counts 0 to 1023 span the 300 deg that the servo can measure."""

TRAVEL = math.radians(300.0)
COUNT = TRAVEL / COUNTS
"""One position count [rad]."""

CENTRE = COUNTS / 2
SPEED_UNIT = 0.111 * 2 * math.pi / 60
"""One count of Moving Speed and Present Speed in joint mode [rad/s]: 0.111 rpm."""

SHARE_UNIT = 1 / COUNTS
"""One count of Torque Limit, Max Torque and Present Load, as a share of the servo's most."""

DIRECTION = 1024
"""Bit 10 of a signed value: set when it turns clockwise."""


class Register(NamedTuple):
    """One entry of the control table.

    Attributes:
        address: of its first byte.
        size: bytes, little endian.
        writable: whether a WRITE may change it.
        initial: value in a new servo, or at power-on.
        low, high: the values that the servo accepts.
    """

    address: int
    size: int
    writable: bool = False
    initial: int = 0
    low: int = 0
    high: int = 255

    @property
    def eeprom(self) -> bool:
        """Kept without power; it can be changed only while torque is off."""
        return self.address < RAM_START

    @property
    def end(self) -> int:
        return self.address + self.size


RAM_START = 24
TABLE_END = 50

MODEL = Register(0, 2, initial=MODEL_NUMBER, high=0xFFFF)
FIRMWARE = Register(2, 1, initial=24)
ID = Register(3, 1, True, 1, 0, 253)
BAUD = Register(4, 1, True, 1, 0, 254)
RETURN_DELAY = Register(5, 1, True, 250, 0, 254)
CW_LIMIT = Register(6, 2, True, 0, 0, COUNTS)
CCW_LIMIT = Register(8, 2, True, COUNTS, 0, COUNTS)
TEMPERATURE_LIMIT = Register(11, 1, True, 70, 0, 99)
MIN_VOLTAGE = Register(12, 1, True, 60, 50, 160)
MAX_VOLTAGE = Register(13, 1, True, 140, 50, 160)
MAX_TORQUE = Register(14, 2, True, COUNTS, 0, COUNTS)
RETURN_LEVEL = Register(16, 1, True, 2, 0, 2)
ALARM_LED = Register(17, 1, True, 36, 0, 127)
SHUTDOWN = Register(18, 1, True, 36, 0, 127)
TORQUE_ENABLE = Register(24, 1, True, 0, 0, 1)
LED = Register(25, 1, True, 0, 0, 1)
CW_MARGIN = Register(26, 1, True, 1)
CCW_MARGIN = Register(27, 1, True, 1)
CW_SLOPE = Register(28, 1, True, 32, 1, 254)
CCW_SLOPE = Register(29, 1, True, 32, 1, 254)
GOAL_POSITION = Register(30, 2, True, 0, 0, COUNTS)
MOVING_SPEED = Register(32, 2, True, 0, 0, 2047)
TORQUE_LIMIT = Register(34, 2, True, COUNTS, 0, COUNTS)
PRESENT_POSITION = Register(36, 2, high=COUNTS)
PRESENT_SPEED = Register(38, 2, high=2047)
PRESENT_LOAD = Register(40, 2, high=2047)
PRESENT_VOLTAGE = Register(42, 1)
PRESENT_TEMPERATURE = Register(43, 1)
REGISTERED = Register(44, 1, high=1)
MOVING = Register(46, 1, high=1)
LOCK = Register(47, 1, True, 0, 0, 1)
PUNCH = Register(48, 2, True, 32, 32, COUNTS)

REGISTERS: dict[str, Register] = {
    name.lower(): register for name, register in globals().items() if isinstance(register, Register)
}

STATE_ADDRESS, STATE_SIZE = PRESENT_POSITION.address, PRESENT_TEMPERATURE.end - PRESENT_POSITION.address
"""Position, speed, load, voltage and temperature lie side by side: one READ of 8 bytes brings them all."""

GOAL_ADDRESS, GOAL_SIZE = GOAL_POSITION.address, MOVING_SPEED.end - GOAL_POSITION.address
"""Goal and speed lie side by side too: one SYNC_WRITE sets both in every servo."""

SETTINGS_ADDRESS, SETTINGS_SIZE = TORQUE_ENABLE.address, TORQUE_LIMIT.end - TORQUE_ENABLE.address
"""What a power dip resets, torque enable to torque limit; the state begins where it ends."""

BAUD_VALUES = {1_000_000: 1, 500_000: 3, 115_200: 16, 57_600: 34, 19_200: 103, 9_600: 207}
"""Baud rates that both the servo and the SDK can do, with the value of register 4: 2,000,000 / (value + 1)."""


class Alarm(IntFlag):
    """Bits of a status packet's error byte. They are the servo's state, not a verdict on the request."""

    VOLTAGE = 0x01
    ANGLE = 0x02
    OVERHEAT = 0x04
    RANGE = 0x08
    CHECKSUM = 0x10
    OVERLOAD = 0x20
    INSTRUCTION = 0x40


class State(NamedTuple):
    """A servo's 8 bytes from address 36: counts, signed counts, signed share of 1023, 0.1 V, deg C."""

    position: int
    speed: int
    load: int
    decivolts: int
    temperature: int


def signed(raw: int) -> int:
    """A speed or load: bit 10 means clockwise, which counts as negative."""
    magnitude = raw & (DIRECTION - 1)
    return -magnitude if raw & DIRECTION else magnitude


def raw_signed(value: int) -> int:
    """The register's form of a signed value of at most 1023."""
    magnitude = min(abs(value), DIRECTION - 1)
    return magnitude | DIRECTION if value < 0 else magnitude


def word(data: bytes, offset: int) -> int:
    return data[offset] | data[offset + 1] << 8


def decode_state(data: bytes) -> State:
    """The state in the bytes of a READ of `STATE_SIZE` at `STATE_ADDRESS`."""
    return State(word(data, 0), signed(word(data, 2)), signed(word(data, 4)), data[6], data[7])


def baud_of(value: int) -> int:
    """Baud rate of a value of register 4; those of `BAUD_VALUES` exactly, as the host must set them."""
    named = {register: baud for baud, register in BAUD_VALUES.items()}
    return named.get(value, round(2_000_000 / (value + 1)))
