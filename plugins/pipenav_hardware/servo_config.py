"""A servo in the arm's description: which joint it moves, how it is mounted, and how far it may turn."""

from __future__ import annotations

import math
from typing import Annotated, Generic, Literal, NamedTuple, Self, TypeVar

from pydantic import Field, model_validator

from pipenav.arrays import Table
from pipenav.units import deg_to_rad, mm_to_m
from pipenav_hardware.table import COUNT, COUNTS, SHARE_UNIT, TRAVEL

STOP_MARGIN = 4
"""Number of counts that stay free at either end of the servo's 300 deg: beyond them its reading is undefined."""

PINION_TRAVEL = TRAVEL - 2 * STOP_MARGIN * COUNT
"""Longest travel of a rack, in pinion radii: 5.236 less the margin. More needs more than one turn, and an AX-12A
cannot count turns: it has no reading in 60 of 360 deg."""

LONGEST_RACK = 20_000.0
"""Largest position of a rack [mm]: the longest leg of a pipe."""


Number = TypeVar("Number", int, float)


class Range(NamedTuple, Generic[Number]):
    """Smallest and largest value of something."""

    lower: Number
    upper: Number


class _Servo(Table):
    """A servo and how it is mounted."""

    joint: str = Field(description="name of the joint in robot.toml")
    id: int = Field(ge=0, le=252, description="ID of the servo")
    sign: Literal[1, -1] = Field(description="1: the joint's positive direction is the servo's counter-clockwise")
    zero_count: float = Field(ge=0, le=COUNTS, description="position count where the joint is at 0")
    torque_limit_percent: float = Field(ge=0.1, lt=100, description="allowed share of the servo's torque")

    @property
    def unit(self) -> float:
        """Joint travel per servo angle [rad/rad, or m/rad]."""
        raise NotImplementedError

    @property
    def limits(self) -> Range[float]:
        """Allowed joint positions [rad, or m]."""
        raise NotImplementedError

    @property
    def torque_counts(self) -> int:
        """Allowed torque, as the torque registers hold it [counts]."""
        return int(self.torque_limit_percent / 100 / SHARE_UNIT)

    def to_counts(self, position: float) -> float:
        """Servo position [counts] of a joint position [rad, or m]; not rounded."""
        return self.zero_count + self.sign * position / (self.unit * COUNT)

    def to_position(self, counts: float) -> float:
        """Joint position [rad, or m] of a servo position [counts]."""
        return self.sign * (counts - self.zero_count) * self.unit * COUNT

    @property
    def count_limits(self) -> Range[int]:
        """Goals inside the joint's limits [counts]."""
        low, high = sorted(map(self.to_counts, self.limits))
        return Range(math.ceil(low - 1e-9), math.floor(high + 1e-9))

    @model_validator(mode="after")
    def _reachable(self) -> Self:
        lower, upper = self.limits
        if not lower < 0 < upper:
            raise ValueError("the straight pose, 0, must lie strictly between the limits")
        self._require_a_turn()
        low, high = self.count_limits
        if low < STOP_MARGIN or high > COUNTS - STOP_MARGIN:
            raise ValueError(
                f"{self.joint!r}: its limits are servo counts {low} to {high}, allowed are {STOP_MARGIN} to "
                f"{COUNTS - STOP_MARGIN}: narrow the limits, or mount the servo so that 0 lies elsewhere"
            )
        return self

    def _require_a_turn(self) -> None:
        """Raise a ValueError where the travel needs more than the servo's single turn, however it is mounted."""


class HingeServo(_Servo):
    """A servo whose horn turns the joint."""

    drive: Literal["hinge"]
    lower_deg: float = Field(ge=-360, le=360)
    upper_deg: float = Field(ge=-360, le=360)

    @property
    def unit(self) -> float:
        return 1.0

    @property
    def limits(self) -> Range[float]:
        return Range(deg_to_rad(self.lower_deg), deg_to_rad(self.upper_deg))


class PinionServo(_Servo):
    """A servo that moves the arm along a rack by a pinion, within a single turn."""

    drive: Literal["pinion"]
    pinion_radius_mm: float = Field(ge=0.1, le=1000)
    lower_mm: float = Field(ge=-LONGEST_RACK, le=LONGEST_RACK)
    upper_mm: float = Field(ge=-LONGEST_RACK, le=LONGEST_RACK)

    @property
    def unit(self) -> float:
        return mm_to_m(self.pinion_radius_mm)

    @property
    def limits(self) -> Range[float]:
        return Range(mm_to_m(self.lower_mm), mm_to_m(self.upper_mm))

    def _require_a_turn(self) -> None:
        longest = PINION_TRAVEL * self.pinion_radius_mm
        if self.upper_mm - self.lower_mm > longest:
            raise ValueError(
                f"{self.joint!r} would travel {self.upper_mm - self.lower_mm:g} mm, a pinion of "
                f"{self.pinion_radius_mm:g} mm radius moves the rack {longest:.0f} mm at most (300 deg, single turn): "
                "narrow the limits or use a larger pinion"
            )


Servo = Annotated[HingeServo | PinionServo, Field(discriminator="drive")]


def reachable(lower: float, upper: float, sign: int, zero_count: float, unit: float) -> Range[float]:
    """The part of a joint's travel that its servo reaches without coming near its ends.

    Args:
        lower, upper: the joint's own limits [rad or m].
        sign, zero_count: how the servo is mounted, see `arm.toml`.
        unit: joint travel per servo angle [1, or m/rad].
    """
    ends = [sign * (counts - zero_count) * unit * COUNT for counts in (STOP_MARGIN, COUNTS - STOP_MARGIN)]
    return Range(max(lower, min(ends) + 1e-9), min(upper, max(ends) - 1e-9))
