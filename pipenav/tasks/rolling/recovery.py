"""Recovery of n robots from jams: a robot that its own sensors say is stuck clamps, rolls back and tries again.

The thesis's first recommendation. Three things tell a robot that it is stuck: neither its joints nor, by their
odometry, its wheels have moved it for a while; or the wheels have not for three times as long, whatever the joints do;
or its wheels turn, its joints have not moved for twice as long, and it is not clamped as robots are that roll along a
straight.
"""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.messages import Reading
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import ZIGZAG, RollForward, nearest_zigzag, rolled_distance, steepness

STALL, SPIN, IDLE = 20, 40, 60
"""Control steps without motion after which a robot counts as stuck: of joints and wheels, of joints alone, and of
wheels alone."""

STILL, ON_THE_SPOT = 0.3, 0.03
"""Largest motion of a stuck robot in that time: of any joint [rad], and of its wheels by their odometry [m]."""

CLAMPED = 0.35
"""Largest distance of any joint from the zigzag of a robot that is clamped [rad]."""

BACK = 0.2
"""Distance by which the robot rolls back [m]."""

LONGEST = 60
"""Control steps after which it goes on by the policy even if it is not so far back."""

MAX_TRIES = 12
"""Most recoveries of an episode: a robot that needs more is given up."""


class Recovery:
    """Recoveries of n robots.

    Args:
        robot: the robot, as `clamp.check_robot` accepts it.
        n: number of robots.

    Attributes:
        busy: whether each robot recovers, (n,): then it drives itself, and the policy does not.
    """

    def __init__(self, robot: RobotSpec, n: int) -> None:
        self._robot = robot
        self._back = RollForward(robot, n)
        self._lasted, self._tries = np.zeros((2, n), int)
        self._still, self._idle = np.zeros((2, n), int)
        self._bends, self._rolled = np.full((n, len(robot.joints)), np.inf), np.zeros(n)
        self.busy = np.zeros(n, bool)

    def start(self, indices: Ints) -> None:
        """Begin anew with some robots, (k,)."""
        self.busy[indices], self._tries[indices] = False, 0
        self._still[indices] = self._idle[indices] = 0
        self._bends[indices], self._rolled[indices] = np.inf, 0.0  # nothing is left of the episode before

    def sense(self, reading: Reading, radius: Floats, set_points: Floats) -> None:
        """Take in the readings after a control period, and decide which robots recover.

        Args:
            reading: readings of the robots' own sensors.
            radius: radius of the narrowest bore of each robot's pipe, which it knows from the drawing, (n,) [m].
            set_points: set-points of the joints now, (n, joints) [rad].
        """
        assert reading.wheel_speeds is not None
        self._watch(reading.q, rolled_distance(self._robot, reading.q, reading.wheel_speeds))
        is_back = self.busy & ((self._back.distance <= -BACK) | (self._lasted >= LONGEST))
        begins = ~self.busy & self._stuck(reading.q, radius) & (self._tries < MAX_TRIES)
        self.busy = (self.busy & ~is_back) | begins
        self._still[is_back] = self._idle[is_back] = 0
        rows = np.flatnonzero(begins)
        self._tries[rows] += 1
        self._lasted[rows] = 0
        # Where one zigzag does not come free, its mirror image may: every other time it clamps in the farther one.
        nearer = np.where(self._tries[rows] % 2 == 1, 1.0, -1.0)[:, None]
        self._back.begin(rows, radius[rows], nearer * reading.q[rows], set_points[rows], direction=-1.0)

    def command(self, rows: Ints, reading: Reading) -> Floats:
        """Set-points of joints and wheels of busy robots, for one control period, (k, 12) [rad, then rad/s]."""
        assert reading.wheel_speeds is not None
        self._lasted[rows] += 1
        values = self._back.act(rows, reading.q[rows], reading.wheel_speeds[rows])
        joints = len(self._robot.joints)
        values[:, :joints] = np.clip(values[:, :joints], self._robot.lower, self._robot.upper)
        return values

    def _watch(self, bends: Floats, rolled: Floats) -> None:
        """Count the steps since joints, (n, joints) [rad], and wheels, that rolled so far, (n,) [m], were elsewhere."""
        moved = np.asarray((np.abs(bends - self._bends) > STILL).any(axis=1))
        self._bends = np.where(moved[:, None], bends, self._bends)
        self._still = np.where(moved, 0, self._still + 1)
        self._rolled += rolled
        went = np.abs(self._rolled) > ON_THE_SPOT
        self._rolled = np.where(went, 0.0, self._rolled)
        self._idle = np.where(went, 0, self._idle + 1)

    def _stuck(self, bends: Floats, radius: Floats) -> Flags:
        """Whether each robot is stuck, (n,), by its joints, (n, joints) [rad], in a bore of a radius, (n,) [m]."""
        zigzag = (nearest_zigzag(bends) * steepness(self._robot, radius))[:, None] * ZIGZAG
        clamped = np.abs(bends - zigzag).max(axis=1) < CLAMPED
        still = self._still >= np.where(clamped, np.inf, SPIN)
        return np.asarray(still | ((self._still >= STALL) & (self._idle >= STALL)) | (self._idle >= IDLE))
