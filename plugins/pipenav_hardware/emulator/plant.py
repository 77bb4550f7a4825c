"""The mechanics behind the servos, as a seam: where their shafts go when the motors are commanded."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

from pipenav.arrays import Floats

NOLOAD_SPEED = 6.18
"""Fastest speed of an AX-12A at 12 V [rad/s]."""

SLOPE = 32
"""Position error at which the servo gives all the torque that it is allowed [counts]: the compliance slope's initial
value."""


class ServoCommand(NamedTuple):
    """The command of one servo's motor.

    Attributes:
        goal_counts: goal position [counts].
        speed: the Moving Speed register; 0 is no speed control at all.
        torque_share: allowed share of the servo's torque; 0 where torque is off.
        wheel: whether it turns for ever, in wheel mode.
    """

    goal_counts: int
    speed: int
    torque_share: float
    wheel: bool = False


class Shaft(NamedTuple):
    """The state of one servo's shaft.

    Attributes:
        position: position [counts].
        speed: speed [rad/s].
        load: signed share of the servo's torque.
    """

    position: float
    speed: float
    load: float


class Plant(ABC):
    """The mechanics behind the servos.

    Attributes:
        stuck: indices of shafts that something holds.
    """

    stuck: set[int]

    @abstractmethod
    def command(self, now: float, commands: Sequence[ServoCommand]) -> None:
        """Command every motor from now on [s]."""

    @abstractmethod
    def shafts(self, now: float) -> list[Shaft]:
        """State of every shaft at a time that never runs backwards [s]."""

    @abstractmethod
    def distances(self, now: float, angles: Floats) -> Floats:
        """True distance from the tip along rays at these angles from the tip link's axis, (k,) [m]; inf: no wall."""
