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
"""Angle that the servo can measure [rad]."""

COUNT = TRAVEL / COUNTS
"""Angle of one position count [rad]."""

CENTRE = COUNTS / 2
SPEED_UNIT = 0.111 * 2 * math.pi / 60
"""Speed of one count of Moving Speed and Present Speed in joint mode [rad/s]: 0.111 rpm."""

SHARE_UNIT = 1 / COUNTS
"""Share of the servo's largest torque in one count of Torque Limit, Max Torque and Present Load."""

DIRECTION = 1024
"""Bit 10 of a signed value: set when the servo turns clockwise."""


class Register(NamedTuple):
    """Entry of the control table.

    Attributes:
        address: address of its first byte.
        size: number of bytes, little endian.
        writable: whether a WRITE may change it.
        initial: value in a new servo, or at power-on.
        low, high: smallest and largest value that the servo accepts.
    """

    address: int
    size: int
    writable: bool = False
    initial: int = 0
    low: int = 0
    high: int = 255

    @property
    def eeprom(self) -> bool:
        """Whether it is kept without power; such a register can be changed only while torque is off."""
        return self.address < RAM_START

    @property
    def end(self) -> int:
        """Address after its last byte."""
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
"""Registers that a power dip resets, torque enable to torque limit; the state begins where they end."""

EEPROM = (0, SHUTDOWN.end)
"""Address and size of a READ that brings everything that is compared with the arm's description."""

WHEEL_MODE = (0, 0)
"""Angle limits of a servo that turns for ever."""

BAUD_VALUES = {
    1_000_000: 1, 500_000: 3, 400_000: 4, 250_000: 7, 200_000: 9, 115_200: 16, 57_600: 34, 19_200: 103, 9_600: 207,
}  # fmt: skip
"""Baud rates of the manual, with the value of register 4: 2,000,000 / (value + 1)."""


class ServoGoal(NamedTuple):
    """The goal of a servo, as its registers hold it.

    Attributes:
        counts: goal position [counts].
        speed: moving speed [counts]; 0 would be no speed control at all.
    """

    counts: int
    speed: int


class Alarm(IntFlag):
    """Bits of a status packet's error byte. They are the servo's state, no judgement of the request."""

    VOLTAGE = 0x01
    ANGLE = 0x02
    OVERHEAT = 0x04
    RANGE = 0x08
    CHECKSUM = 0x10
    OVERLOAD = 0x20
    INSTRUCTION = 0x40


SHUTDOWN_ALARMS = Alarm.OVERLOAD | Alarm.OVERHEAT
"""Alarms on which every servo must switch its torque off by itself."""


class State(NamedTuple):
    """A servo's 8 bytes from address 36.

    Attributes:
        position: position [counts].
        speed: signed speed [counts].
        load: signed share of the servo's torque [1/1023].
        decivolts: supply [0.1 V].
        temperature: temperature [deg C].
    """

    position: int
    speed: int
    load: int
    decivolts: int
    temperature: int


class Eeprom(NamedTuple):
    """Registers of a servo that are kept without power.

    Attributes:
        model: model number.
        firmware: version of the firmware.
        return_delay: delay of every answer [2 us].
        limits: angle limits, clockwise and counter-clockwise [counts]; `WHEEL_MODE` where it turns for ever.
        max_torque: Torque Limit at power-on [counts].
        return_level: which instructions it answers; 2 for all.
        temperature_limit: temperature above which it is overheated [deg C].
        shutdown: alarms that switch its torque off.
    """

    model: int
    firmware: int
    return_delay: int
    limits: tuple[int, int]
    max_torque: int
    return_level: int
    shutdown: int
    temperature_limit: int


def signed(raw: int) -> int:
    """Signed value of a speed or load register: bit 10 means clockwise, which counts as negative."""
    magnitude = raw & (DIRECTION - 1)
    return -magnitude if raw & DIRECTION else magnitude


def raw_signed(value: int) -> int:
    """Register's form of a signed value; its magnitude ends at 1023."""
    magnitude = min(abs(value), DIRECTION - 1)
    return magnitude | DIRECTION if value < 0 else magnitude


def word(data: bytes, offset: int) -> int:
    """16-bit value at an offset, little endian."""
    return data[offset] | data[offset + 1] << 8


def decode_state(data: bytes) -> State:
    """The state in the bytes of a READ of `STATE_SIZE` at `STATE_ADDRESS`."""
    return State(word(data, 0), signed(word(data, 2)), signed(word(data, 4)), data[6], data[7])


def decode_eeprom(data: bytes) -> Eeprom:
    """The registers in the bytes of a READ of `EEPROM`."""
    return Eeprom(
        model=word(data, MODEL.address),
        firmware=data[FIRMWARE.address],
        return_delay=data[RETURN_DELAY.address],
        limits=(word(data, CW_LIMIT.address), word(data, CCW_LIMIT.address)),
        max_torque=word(data, MAX_TORQUE.address),
        return_level=data[RETURN_LEVEL.address],
        shutdown=data[SHUTDOWN.address],
        temperature_limit=data[TEMPERATURE_LIMIT.address],
    )


def baud_of(value: int) -> int:
    """Baud rate of a value of register 4; exact for `BAUD_VALUES`, as the host must set them."""
    named = {register: baud for baud, register in BAUD_VALUES.items()}
    return named.get(value, round(2_000_000 / (value + 1)))
