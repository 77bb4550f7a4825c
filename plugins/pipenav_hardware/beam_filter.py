"""The robot's beams, from a scan that is finer than they are."""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.robots import Laser, laser
from pipenav_hardware.ranging import RangeScan

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
