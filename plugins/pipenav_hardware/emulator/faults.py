"""Scripts of faults: what goes wrong, when, and with which device; drawn with a seed where they are random."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import Field, ValidationError

from pipenav.arrays import Table
from pipenav.errors import ConfigError, OutOfRange, PipenavError

BUS_FAULTS = {
    "drop": "an answer is not sent",
    "delay": "an answer comes `value` seconds late",
    "corrupt": "one bit of an answer is wrong",
    "truncate": "an answer ends early",
    "garbage": "noise comes before an answer",
    "bare_error": "an answer to a READ has an error byte (`value`) and no data",
    "wrong_id": "an answer carries another servo's id",
    "echo": "the adapter sends back what the host sends",
    "deaf": "the adapter takes no more bytes",
    "unplug": "the adapter is pulled out",
}
SERVO_FAULTS = {
    "dead": "a servo does not answer and does not move",
    "stuck": "a shaft is held",
    "overload": "a servo reports overload",
    "overheat": "a servo is at `value` deg C",
    "voltage": "a servo is supplied with `value` V",
    "power_dip": "a servo loses power for a moment",
    "model": "a servo says that its model number is `value`",
    "wheel": "a servo's EEPROM is set to wheel mode",
    "return_level": "a servo's status return level is `value`",
    "duplicate": "a servo has the id `value`",
    "auto_torque": "a servo switches its torque on when a goal is written",
    "shutdown": "a servo's alarm shutdown (register 18) is `value`",
    "lock": "a servo's EEPROM is locked until it loses power",
    "baud": "a servo's register 4 is `value`",
    "torque_on": "a servo's torque is on from the beginning",
}
SENSOR_FAULTS = {
    "drop": "a scan or reading is not sent",
    "freeze": "the same distances are sent again and again, as new ones",
    "stuck": "the same message is sent again and again",
    "late": "a scan comes `value` seconds late",
    "corrupt": "one bit of a scan or reading is wrong",
    "truncate": "a scan ends early",
    "blind": "every point of a scan is an error code, a reading is out of range",
    "minimum": "patches of a scan, `probability` of it in all, read the scanner's smallest range",
    "noise": "every point has noise of `value` metres, one sigma",
    "unplug": "the sensor is pulled out",
}
SCANNER_FAULTS = SENSOR_FAULTS | {
    "laser": "its laser cannot be switched on",
    "trouble": "it stops measuring with the status `value`, 21 to 97",
    "time_mode": "an earlier program left it in time-stamp mode",
}
FAULTS = {"bus": BUS_FAULTS | SERVO_FAULTS, "scanner": SCANNER_FAULTS, "front": SENSOR_FAULTS}

ONCE = {
    "power_dip", "overheat", "model", "wheel", "return_level", "duplicate", "unplug",
    "shutdown", "lock", "baud", "torque_on", "time_mode",
}  # fmt: skip
"""Faults that change something once, when they begin."""


VALUES = {
    "bare_error": (0.0, 255.0),
    "delay": (0.0, 3600.0),
    "duplicate": (0.0, 253.0),
    "late": (0.0, 3600.0),
    "model": (0.0, 65_535.0),
    "noise": (0.0, 10.0),
    "overheat": (0.0, 255.0),
    "return_level": (0.0, 2.0),
    "voltage": (0.0, 25.5),
}
"""Smallest and largest `value` of a fault that has one: what its register holds, an hour, or the scanner's range."""

LONGEST, MOST = 1e6, 10**9
"""Longest time [s], and most ticks and times."""


class Fault(Table):
    """Entry of a fault script."""

    fault: str = Field(max_length=50, description="name of the fault, see `FAULTS`")
    device: Literal["bus", "scanner", "front"] = "bus"
    servo: int | None = Field(None, ge=0, le=253, description="id of the servo concerned; all servos if none is named")
    at: float = Field(0.0, ge=0, le=LONGEST, description="when it begins, after the emulator's start [s]")
    tick: int | None = Field(None, ge=0, le=MOST, description="goal packet with which it begins, instead of a time")
    span: float | None = Field(None, gt=0, le=LONGEST, description="how long it lasts [s]; forever if nothing is given")
    count: int | None = Field(None, ge=1, le=MOST, description="how many times it happens at most")
    probability: float = Field(1.0, ge=0, le=1, description="probability for each answer, scan or reading concerned")
    value: float = Field(0.0, ge=0, le=65_535, description="how much goes wrong; `FAULTS` says what it stands for")

    def require_known(self) -> None:
        """Refuse a fault that its device does not have.

        Raises:
            PipenavError: the device has no such fault.
        """
        if self.fault not in FAULTS[self.device]:
            raise PipenavError(f"{self.device} has no fault {self.fault!r}: choose {', '.join(FAULTS[self.device])}.")
        low, high = VALUES.get(self.fault, (0.0, 65_535.0))
        if not low <= self.value <= high:
            raise OutOfRange(f"value of the fault {self.fault!r}", self.value, low, high)


def fault_script(entries: Sequence[Mapping[str, Any]]) -> tuple[Fault, ...]:
    """The faults of a script, checked.

    Raises:
        ConfigError: an entry has a wrong key or value.
        PipenavError: there is no such fault.
    """
    script = []
    for number, entry in enumerate(entries, start=1):
        try:
            fault = Fault.model_validate(entry)
        except ValidationError as error:
            raise ConfigError.from_validation(f"fault {number}", error, Fault.model_fields) from error
        try:
            fault.require_known()
        except PipenavError as error:
            raise ConfigError(f"fault {number}: {error}") from error
        script.append(fault)
    return tuple(script)


@dataclass
class _Entry:
    """A fault, when it begins [s], and how often it has happened."""

    fault: Fault
    begin: float
    happened: int = 0


class FaultScript:
    """The faults that hold now.

    Attributes:
        now: time since the emulator's start [s].
        ticks: number of goal packets that have come.
    """

    def __init__(self, script: list[Fault], seed: int) -> None:
        self._random = random.Random(seed)
        self._entries: list[_Entry] = []
        self.now, self.ticks = 0.0, 0
        for fault in script:
            self.add(fault)

    def add(self, fault: Fault) -> None:
        """Add a fault; its time counts from now.

        Raises:
            PipenavError: the device has no such fault.
        """
        fault.require_known()
        self._entries.append(_Entry(fault, self.now + fault.at))

    def clear(self) -> None:
        """Drop all faults."""
        self._entries.clear()

    def due(self) -> list[Fault]:
        """Faults that change something once and begin now; every one is given only once."""
        begun = [entry for entry in self._entries if entry.fault.fault in ONCE and self._holds(entry)]
        self._entries = [entry for entry in self._entries if entry not in begun]
        return [entry.fault for entry in begun]

    def active(self, kind: str, device: str = "bus", servo: int | None = None) -> Fault | None:
        """The fault of this kind that strikes now, which then counts as having happened; None where there is none."""
        for entry in self._entries:
            fault = entry.fault
            concerned = fault.servo is None or servo is None or fault.servo == servo
            if fault.fault != kind or fault.device != device or not concerned or not self._holds(entry):
                continue
            if fault.count is not None and entry.happened >= fault.count:
                continue
            if fault.probability < 1 and kind != "minimum" and self._random.random() >= fault.probability:
                continue
            entry.happened += 1
            return fault
        return None

    def number(self, below: int) -> int:
        """A random integer from 0 on."""
        return self._random.randrange(below)

    def _holds(self, entry: _Entry) -> bool:
        """Whether a fault's time has come and not passed."""
        fault = entry.fault
        if fault.tick is not None:
            return self.ticks >= fault.tick
        return entry.begin <= self.now and (fault.span is None or self.now < entry.begin + fault.span)
