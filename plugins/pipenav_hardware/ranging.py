"""The interface of range sensors, and how ticks keep in step with their scans."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends import CONTROL_PERIOD
from pipenav.errors import PipenavError
from pipenav_hardware.arm_config import ScannerConfig


class SensorLost(PipenavError):
    """A range sensor that is gone or does not answer."""

    def __init__(self, name: str, problem: str, remedy: str = "check its cable and its port in arm.toml") -> None:
        super().__init__(f"the {name} {problem}: {remedy}.")


class RangeScan(NamedTuple):
    """A scan as it came.

    Attributes:
        distances: distance at each angle of the sensor [mm]; below its smallest range they are error codes.
        stamp: when it arrived, on the monotonic clock [s].
        sequence: number that grows with every new measurement.
    """

    distances: tuple[int, ...]
    stamp: float
    sequence: int


class RangeSensor(ABC):
    """A scanner, which is polled and never blocks.

    Attributes:
        angles: angles of its points from the tip link's axis, left positive, ascending, (k,) [rad].
        range_min, range_max: smallest and largest distance that it can measure [m].
        rejected: number of scans that came damaged.
        words: what it says about its own state; empty where it says nothing.
    """

    angles: Floats
    range_min: float
    range_max: float
    rejected: int
    words: str = ""

    @abstractmethod
    def fileno(self) -> int:
        """A descriptor that becomes readable when there is something to `pump`; -1 where there is none."""

    @abstractmethod
    def pump(self, now: float) -> None:
        """Take in what has arrived."""

    @abstractmethod
    def latest(self) -> RangeScan | None:
        """The newest whole scan; None before the first."""

    @abstractmethod
    def close(self) -> None: ...


AFTER_SCAN = 0.003
"""Time from a scan to the beginning of a tick [s]: scans do not come quite regularly."""

MOST_SHIFT = 0.002
"""Farthest that a tick is moved to keep in step with a scanner of ten scans a second [s]: clocks drift apart slower."""


def await_scan(sensor: RangeSensor, listen: Callable[[float], None], timeout: float) -> None:
    """Wait until the next scan has just come.

    Args:
        sensor: the scanner.
        listen: takes in what has arrived until a time [s].
        timeout: longest wait [s].
    """
    before, deadline = sensor.latest(), time.monotonic() + timeout
    while sensor.latest() is before and time.monotonic() < deadline:
        time.sleep(0.001)
        listen(time.monotonic())


def late_for_scan(due: float, newest: RangeScan | None) -> float:
    """Time by which the tick after the one at `due` is to come earlier, to begin just after a scan [s].

    Joints are read where they are now, but a scan shows what was seen where they were when it was taken: in a tenth of
    a second the tip moves by several times what the map of a corner forgives.
    """
    if newest is None:
        return 0.0
    late = math.remainder(due - newest.stamp - AFTER_SCAN, CONTROL_PERIOD)
    return min(max(late, -MOST_SHIFT), MOST_SHIFT)


def mounted(angles: Floats, config: ScannerConfig) -> Floats:
    """Angles of the sensor's points from the tip link's axis. Points keep their order; see `BeamFilter`."""
    turned = -angles if config.upside_down else angles
    return np.asarray(turned + math.radians(config.mounting_deg))
