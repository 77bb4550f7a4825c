"""The interface of range sensors, and the policy's beams from a scan that is finer than they are."""

from __future__ import annotations

import contextlib
import math
import os
import select
import termios
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import serial

from pipenav.arrays import Floats
from pipenav.backends import CONTROL_PERIOD
from pipenav.errors import PipenavError
from pipenav.robots import Laser, laser
from pipenav_hardware.arm_config import ScannerConfig
from pipenav_hardware.port_problems import port_problem


class SensorLost(PipenavError):
    """A range sensor that is gone or does not answer."""

    def __init__(self, name: str, problem: str) -> None:
        super().__init__(f"the {name} {problem}: check its cable and its port in arm.toml.")


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
    """

    angles: Floats
    range_min: float
    range_max: float
    rejected: int

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
"""How long after a scan a tick begins [s]: scans do not come quite regularly."""

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
    """How much earlier the tick after the one at `due` is to come, so that ticks keep beginning just after a scan [s].

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


class SerialLine:
    """A serial device that sends lines."""

    def __init__(self, port: str, baud: int, name: str) -> None:
        self._name, self._buffer = name, b""
        try:
            self._serial = serial.Serial(port, baud, timeout=0, write_timeout=0.2, exclusive=True)
            self._serial.reset_input_buffer()
        except (OSError, termios.error) as error:
            raise port_problem(port, error) from error

    def fileno(self) -> int:
        return int(self._serial.fileno())

    def write(self, data: bytes) -> None:
        with self._edge():
            self._serial.write(data)

    def lines(self, wait: float = 0.0) -> Iterator[str]:
        """Lines that are complete now, without their end.

        Args:
            wait: longest wait for the first bytes [s].
        """
        with self._edge():
            if wait:
                select.select([self.fileno()], [], [], wait)
            if self._readable():
                arrived = os.read(self.fileno(), 65536)
                if not arrived:
                    raise OSError("unplugged")
                self._buffer += arrived
        *whole, self._buffer = self._buffer.split(b"\n")
        yield from (line.rstrip(b"\r").decode("latin-1") for line in whole)

    def close(self, farewell: bytes = b"") -> None:
        with contextlib.suppress(OSError, termios.error):
            self._serial.write(farewell)
            self._serial.close()

    def _readable(self) -> bool:
        return bool(select.select([self.fileno()], [], [], 0)[0])

    @contextlib.contextmanager
    def _edge(self) -> Iterator[None]:
        try:
            yield
        except (OSError, termios.error, ValueError, TypeError) as error:
            raise SensorLost(self._name, f"is lost ({error})") from error


NEIGHBOURHOOD = math.radians(2.5)
"""Half width of the neighbourhood whose median a beam is [rad]: with every third point lost to dropouts or noise of
10 mm, the median of a dozen is within 5 mm of the truth; wider, it would round off edges."""

IMPLAUSIBLE_DROP = 0.1
"""A beam that reads the sensor's minimum although it read this much more just before [m] is not believed: in a control
period the tip moves by a quarter of it."""

DISBELIEF = 3
"""Number of scans in a row for which a beam keeps its earlier value instead."""


class BeamFilter:
    """Turns scans into the robot's beams: the same scans give the same beams.

    Scanners return their smallest range where they see nothing (the thesis's scanner failed 40 % of its searches for an
    open pipe by that), so a smallest range that comes from nowhere is not believed for a while.

    Attributes:
        all_invalid: whether the last scan had no valid point.
    """

    def __init__(self, fan: Laser, angles: Floats, range_min: float, range_max: float) -> None:
        self._laser, self._range_min, self._range_max = fan, range_min, range_max
        near = np.abs(angles[None, :] - fan.angles[:, None]) <= NEIGHBOURHOOD  # (beams, points)
        if not near.any(axis=1).all():
            blind = math.degrees(fan.angles[int(np.argmin(near.any(axis=1)))])
            raise PipenavError(
                f"the scanner does not see the beam at {blind:.0f} deg that the robot's policy needs: "
                "check mounting_deg in arm.toml, or use a scanner with a wider fan."
            )
        self._windows = [slice(int(row.argmax()), int(row.argmax() + row.sum())) for row in near]  # points are in order
        self._before = np.full(len(self._windows), -np.inf)  # nothing is known yet: the first scan is believed
        self._doubted = np.zeros(len(self._windows), int)
        self.all_invalid = False

    def beams(self, scan: RangeScan, front: float | None) -> Floats:
        """The robot's beams, (beams,) [m].

        Args:
            scan: a new scan.
            front: reading of the front sensor [m], None without one. It replaces the middle beams where the scanner is
                too close to the wall to measure.
        """
        distances = (np.array(scan.distances, float) / 1e3).tolist()  # a beam has a dozen: faster without NumPy
        self.all_invalid = max(distances) < self._range_min
        beams = np.array([self._beam(distances[window]) for window in self._windows])
        lowest = max(self._range_min, self._laser.range_min) + self._laser.resolution
        doubtful = (beams <= lowest) & (self._before - beams > IMPLAUSIBLE_DROP) & (self._doubted < DISBELIEF)
        self._doubted = np.where(doubtful, self._doubted + 1, 0)
        beams = np.where(doubtful, self._before, beams)
        if front is not None and front < self._range_min:
            middle = np.abs(self._laser.angles) <= np.abs(self._laser.angles).min() + 1e-9
            beams = np.where(middle, front, beams)
        self._before = beams
        return laser.measure(self._laser, beams)

    def _beam(self, distances: list[float]) -> float:
        """Median of a beam's points. Points at the minimum count only where most are: they may be dropouts."""
        seen = [distance for distance in distances if distance >= self._range_min]
        real = [distance for distance in seen if distance > self._range_min + 0.001]
        if len(real) * 4 >= len(seen) and real:
            return _median(real)
        return _median(seen) if seen else self._laser.range_max  # no echo: nothing within reach


def _median(values: list[float]) -> float:
    values = sorted(values)
    return (values[(len(values) - 1) // 2] + values[len(values) // 2]) / 2
