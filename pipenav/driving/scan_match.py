"""Distance along a pipe's first leg, told by comparing scans with those that the pipe's drawing gives."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import laser
from pipenav.robots.robot import RobotSpec

AROUND, SPACING = 0.08, 0.002
"""Largest error of the distance that is looked for, and the distance between errors that are compared [m]."""

BLUR = 0.01
"""Difference between a beam's reading and the drawing that begins to count against a distance [m]: twice the laser's
resolution, for links that do not lie quite as they are thought to."""

WORST = 3.0
"""Largest such difference that counts, in `BLUR`: a beam that passes an edge says no more than that."""

FORGETTING = 0.9
"""Share of what the scans before have said that still counts in the next control step: wheels slip."""


class ScanMatch:
    """Error of a distance along the first leg, from all scans so far.

    Args:
        robot: the robot with the laser.
        pipe: the pipe, as it is drawn.
    """

    def __init__(self, robot: RobotSpec, pipe: PipeCorner) -> None:
        self._laser, self._segments = robot.laser, pipe.segments[None]
        self._errors = np.arange(-AROUND, AROUND + SPACING / 2, SPACING)
        self._score = np.zeros(len(self._errors))

    def error(self, tip: Floats, heading: float, ranges: Floats) -> float:
        """Correction of the distance, which the caller makes: later scans count from there [m].

        Args:
            tip: where the laser is thought to be, in the pipe's frame, (2,) [m].
            heading: its heading there [rad].
            ranges: its scan from right to left, (beams,) [m].
        """
        errors, n = self._errors, len(self._errors)
        origins = tip + np.stack([errors, np.zeros(n)], axis=1)
        headings = np.full((n, 1), heading) + self._laser.angles
        drawn = laser.measure(self._laser, laser.cast(origins, headings, np.repeat(self._segments, n, axis=0)))
        away = np.minimum(np.abs(drawn - ranges) / BLUR, WORST)
        self._score = FORGETTING * self._score - (away**2).sum(axis=1)
        weight = np.exp((self._score - self._score.max()) / (2 * len(ranges)))
        shift = round(float((weight * errors).sum() / weight.sum()) / SPACING) * SPACING
        least = float(self._score.min())
        self._score = np.interp(errors + shift, errors, self._score, least, least)
        return shift
