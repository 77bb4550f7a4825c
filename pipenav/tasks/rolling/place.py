"""Places of robots along their routes, by dead reckoning: how far the wheels rolled, and how the rear half turned.

The wheels' median is right to a tenth where the robot clamps, and to a quarter where a policy drives; what the laser
and a turn of the rear half tell puts it right at every corner.
"""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.spatial import SpaceReading
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling import senses
from pipenav.tasks.rolling.clamp import rolled_distance
from pipenav.tasks.rolling.drawings import Drawings

AHEAD = 0.1
"""Distance of the tip from a corner's begin when the laser has seen it, and at the start of an episode [m]."""

BEHIND, MOSTLY = 0.85, 0.6
"""Shares of a corner's turn angle by which the rear half must have turned for the corner to count as behind: where
nothing else is known, and where the robot has also rolled `FAR`."""

NEARLY = math.radians(15.0)
"""Largest distance of the rear half's heading from that of the straight behind a passage of several corners or a
reducer, when that counts as behind; twice as much where the robot has rolled `FAR`."""

CLOSE, FAR = 0.1, 0.15
"""Distance from the rear end to a passage's end, ahead, when the passage may count as behind (behind a reducer the rear
end must be as far past, as no wheel clamps in a cone), and distance past it, by which the rear end is likely to be
outside however the wheels slipped [m]."""


class Place:
    """Places of n robots, as far as they know.

    Args:
        robot: the robot, as `check_robot` accepts it.
        drawings: routes of the robots.
        n: number of robots.

    Attributes:
        middle: place of each robot's middle, as `Drawings` counts places, (n,) [m].
    """

    def __init__(self, robot: RobotSpec, drawings: Drawings, n: int) -> None:
        self._robot, self._drawings = robot, drawings
        self._every = np.arange(n)
        self.middle = np.zeros(n)
        self._heading, self._rear = np.zeros(
            (2, n)
        )  # headings of the divided link, by its gyroscope, and the rear half
        self._rear_before = np.zeros(n)  # heading of the rear half before the passage; NaN until the policy drives

    def start(self, rows: Ints) -> None:
        """Begin anew with some robots, before the first corners of their routes."""
        self._heading[rows], self._rear_before[rows] = 0.0, np.nan
        self.middle[rows] = -AHEAD - self._drawings.reach[rows, 0]

    def move(self, reading: SpaceReading, driven: Flags, stays: Flags) -> None:
        """Take in a control period.

        Args:
            reading: readings of the robots after it.
            driven: whether the policy drove each robot, (n,).
            stays: whether each robot meant to stay where it is, (n,).
        """
        bends, wheel_speeds = reading.body.q, reading.body.wheel_speeds
        assert wheel_speeds is not None
        self._heading += reading.turned[:, 0, 2]
        self._rear = self._heading - senses.heading_from_rear_half(self._robot, bends)
        self._rear_before = np.where(driven & np.isnan(self._rear_before), self._rear, self._rear_before)
        self.middle += np.where(stays, 0.0, rolled_distance(self._robot, bends, wheel_speeds))

    def reaches(self, corner: Ints) -> Flags:
        """Whether the tip of each robot is at its corner's begin, (n,)."""
        tip = self.middle + self._drawings.reach[self._every, corner]
        return np.asarray(tip >= self._drawings.begin[self._every, corner] - AHEAD)

    def behind(self, corner: Ints, plane: Floats) -> Flags:
        """Whether the passage that each robot's corner belongs to is behind it, (n,).

        Args:
            corner: corner of each robot, (n,).
            plane: angle of each robot's plane, (n,) [rad].
        """
        drawings, at = self._drawings, (self._every, corner)
        first, last, net_turn = drawings.first[at], drawings.last[at], drawings.net_turn[at]
        sign = np.where(np.cos(drawings.inside[self._every, first] - plane) > 0, 1.0, -1.0)
        turned = (self._rear - self._rear_before) * sign
        past = self.middle - drawings.reach[at] - drawings.end[self._every, last]
        far, away = past >= FAR, np.abs(turned - net_turn)
        alone = (turned >= BEHIND * net_turn) | (far & (turned >= MOSTLY * net_turn))
        needed = np.where(drawings.reducer[self._every, last], CLOSE, -CLOSE)
        several = (past >= needed) & (away <= np.where(far, 2 * NEARLY, NEARLY))
        return np.where((first == last) & ~drawings.reducer[at], alone, several)

    def corner_in_passage(self, corner: Ints) -> Ints:
        """The corner of its passage that each robot is in: the first that its middle has not passed, (n,).

        Args:
            corner: corner of each robot before, (n,); it never goes back.
        """
        last = self._drawings.last[self._every, corner]
        passed = self.middle >= self._drawings.end[self._every, corner]
        return np.where(passed & (corner < last), corner + 1, corner)

    def enter(self, rows: Ints, corner: Ints, seen: Flags) -> None:
        """Let some robots come to their corners.

        Args:
            rows: which robots, (k,).
            corner: their corners, (k,).
            seen: whether the laser saw the corner, (k,).
        """
        begin, reach = self._drawings.begin[rows, corner], self._drawings.reach[rows, corner]
        before = self.middle[rows] < begin - reach / 2  # else the robot comes again, from the middle of it
        known = seen & (self.middle[rows] < begin)
        self.middle[rows] = np.where(known, begin - AHEAD - reach, self.middle[rows])
        # A robot that comes again to a single corner has mostly slid out of it, and stands as it did at first.
        alone = self._drawings.first[rows, corner] == self._drawings.last[rows, corner]
        self._rear_before[rows] = np.where(before | alone, np.nan, self._rear_before[rows])

    def leave(self, rows: Ints, corner: Ints) -> None:
        """Let some robots leave the passages that end with the corners (k,): their rear ends are about there."""
        begin, end, reach = (
            values[rows, corner] for values in (self._drawings.begin, self._drawings.end, self._drawings.reach)
        )
        self.middle[rows] = np.clip(self.middle[rows] - reach, (begin + end) / 2, end + CLOSE) + reach

    def return_to(self, rows: Ints, corner: Ints) -> None:
        """Let some robots know that the corners (k,) are not behind after all: their rear ends are still before."""
        reach, end = self._drawings.reach[rows, corner], self._drawings.end[rows, corner]
        self.middle[rows] = np.minimum(self.middle[rows], end + reach - 2 * CLOSE)
