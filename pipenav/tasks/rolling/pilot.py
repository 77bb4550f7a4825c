"""Decisions of robots in space besides their policy: who drives, and when and how far to roll.

A robot knows the pipe's drawing (`drawings`): diameters and straights, and how every corner turns and is rolled. All
else it finds out from its own sensors (`senses`, `place`). In a passage, a corner or several without room between
them, the policy drives until the passage is behind. Then the robot clamps, rolls on until there is room, turns its
plane into that of the next corner, and rolls on until its laser sees the end of the straight. Where it stalls, it backs
out and tries again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntEnum

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.spatial import SpaceReading
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import MAX_CORNERS
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling import senses
from pipenav.tasks.rolling.clamp import HALF, RollForward
from pipenav.tasks.rolling.drawings import Drawings
from pipenav.tasks.rolling.manoeuvre import Roll, RollCommand, RollPhase
from pipenav.tasks.rolling.place import Place

STEADY = 3
"""Control steps in a row for which the robot has to see something before it acts on it."""

TOLERANCE = math.radians(6.0)
"""Largest angle between the robot's plane and a corner's that needs no roll."""

MAX_ROLLS, MAX_RETRIES = 3, 4
"""Largest number of rolls before one corner, and of times that the robot backs out of it or returns to its end."""

STALL = 20
"""Control steps without motion after which a robot counts as stalled."""

STILL, ON_THE_SPOT = 0.15, 0.03
"""Largest motion of a stalled robot: of any joint [rad] and, where the robot drives itself, of its wheels [m]."""

BACK = 0.2
"""Distance by which the robot backs out of a corner in which it stalled [m]."""


class Mode(IntEnum):
    """Modes of driving: by the policy, or by the robot itself."""

    CORNER = 0
    """The policy drives through a passage."""
    LEAVE = 1
    """The robot rolls forward from a corner to where it has room to turn its plane."""
    ROLL = 2
    """The robot turns its plane."""
    APPROACH = 3
    """The robot rolls forward to the next corner."""
    BACK_OUT = 4
    """The robot rolls back out of a corner in which the policy stalled."""


class Pilot:
    """Drivers of n robots, which decide when the policy acts and when a robot rolls by itself.

    Args:
        robot: the robot, as `check_robot` accepts it.
        n: number of robots.

    Attributes:
        mode: mode of driving now, a `Mode`, (n,).
        corner: number of the corner ahead of or around each robot, from 0, (n,).
        plane: angle of each robot's plane from the untwisted frame of the straight, as far as it knows, (n,) [rad].
        set_points: set-points of the joints in the last control period, (n, 6) [rad].
    """

    def __init__(self, robot: RobotSpec, n: int) -> None:
        self._robot, self._drawings, self._every = robot, Drawings(robot, n), np.arange(n)
        self.mode, self.corner = np.full(n, Mode.CORNER.value), np.zeros(n, np.intp)
        self.plane, self.set_points = np.zeros(n), np.zeros((n, 2 * HALF))
        self._forward, self._roll = RollForward(robot, n), Roll(robot, n)
        self._rolls, self._retries = np.zeros((2, n), int)
        self._steps_seen = np.zeros(n, int)  # control steps for which a robot has seen what it waits for
        self._place = Place(robot, self._drawings, n)
        # Joints and rolled distance in the last control steps, a ring of rows, and how many steps a mode has lasted.
        self._history, self._ring_row, self._lasted = np.zeros((STALL + 1, n, 2 * HALF + 1)), 0, np.zeros(n, int)

    def start(self, rows: Ints, routes: Sequence[PipeRoute], set_points: Floats) -> None:
        """Begin anew with some robots, before the first corners of their routes.

        Args:
            rows: which robots, (k,).
            routes: routes that they are in, k of them.
            set_points: set-points of their joints now, (k, 6) [rad].
        """
        self._drawings.put(rows, routes)
        self._begin(rows, Mode.CORNER)
        self.corner[rows], self._rolls[rows], self._retries[rows] = 0, 0, 0
        self.plane[rows], self.set_points[rows] = [route.corners[0].roll for route in routes], set_points
        self._place.start(rows)

    @property
    def doing(self) -> list[str]:
        """Description of who drives each robot, in words."""
        words = {Mode.CORNER: "policy in ", Mode.LEAVE: "making room before ", Mode.APPROACH: "rolling to "}
        return [
            f"rolling: {RollPhase(phase).name.lower().replace('_', ' ')}"
            if mode == Mode.ROLL
            else words.get(Mode(mode), "back out of ") + f"corner {corner + 1}"
            for mode, phase, corner in zip(self.mode, self._roll.phase, self.corner, strict=True)
        ]

    @property
    def policy_drives(self) -> Flags:
        """Whether the policy drives each robot, (n,)."""
        return np.asarray(self.mode == Mode.CORNER)

    @property
    def turn_sign(self) -> Floats:
        """+1 where a robot's corner turns to its left, -1 where it turns to its right, (n,)."""
        return self._turn_sign(self.corner)

    @property
    def neighbours(self) -> Floats:
        """Turn signs of the corners before and after in the same passage, 0 where there is none, (n, 2)."""
        at = self._every, self.corner
        before = np.where(self.corner > self._drawings.first[at], self._turn_sign(self.corner - 1), 0.0)
        after = np.where(self.corner < self._drawings.last[at], self._turn_sign(self.corner + 1), 0.0)
        return np.stack([before, after], axis=1)

    @property
    def straight_on(self) -> Floats:
        """1 where a robot's route goes straight on at its corner, else 0, (n,)."""
        return self._drawings.straight_on[self._every, self.corner].astype(float)

    @property
    def busy(self) -> Flags:
        """Whether each robot is busy with something other than to advance, (n,)."""
        return np.asarray((self.mode == Mode.ROLL) | (self.mode == Mode.BACK_OUT))

    def _turn_sign(self, corner: Ints) -> Floats:
        inside = self._drawings.inside[self._every, np.minimum(corner, MAX_CORNERS - 1)]
        return np.where(np.cos(inside - self.plane) > 0, 1.0, -1.0)

    @property
    def _rolls_forward(self) -> Flags:
        mode = self.mode
        return np.asarray((mode == Mode.LEAVE) | (mode == Mode.APPROACH) | (mode == Mode.BACK_OUT))

    def command(self, reading: SpaceReading, wanted: Floats) -> RollCommand:
        """Set-points for one control period.

        Args:
            reading: readings of the robots.
            wanted: set-points of joints and wheels by the policy, (n, 12); used where the policy drives.
        """
        bends, wheel_speeds = reading.body.q, reading.body.wheel_speeds
        assert wheel_speeds is not None
        values, roll = wanted.copy(), np.zeros(len(wanted))
        if len(rows := np.flatnonzero(self.mode == Mode.ROLL)):
            felt = bends[rows], reading.roll[rows], wheel_speeds[rows], reading.down[rows]
            values[rows], roll[rows] = self._roll.act(rows, *felt)
        if len(rows := np.flatnonzero(self._rolls_forward)):
            values[rows] = self._forward.act(rows, bends[rows], wheel_speeds[rows])
        self.set_points = values[:, : 2 * HALF].copy()
        return RollCommand(values, roll)

    def sense(self, reading: SpaceReading) -> None:
        """Take in the readings of the robots after a control period, and decide who drives each of them next."""
        stalled, mode, forward = self._stalled(reading), self.mode, self._forward
        self.plane += reading.turned[:, :, 0].mean(axis=1)
        self._place.move(reading, self.policy_drives, mode == Mode.ROLL)
        self.corner = np.where(self.policy_drives, self._place.corner_in_passage(self.corner), self.corner)
        behind, at = self._place.behind(self.corner, self.plane), (self._every, self.corner)
        seen = self._seen_steadily(np.where(self.policy_drives, behind, self._ends(reading)))
        clamped = self._rolls_forward & forward.clamped
        retry = stalled & (self._retries < MAX_RETRIES)
        leaves = self.policy_drives & seen & (self._drawings.last[at] + 1 < self._drawings.corners)
        approaches, makes_room = mode == Mode.APPROACH, mode == Mode.LEAVE
        # A robot that makes room and stalls when it is clamped has slid into the next corner.
        backs_out = retry & ((self.policy_drives & ~leaves) | approaches | (makes_room & clamped))
        enters = approaches & ~backs_out & (seen | stalled)
        has_room = makes_room & clamped & ~backs_out & (seen | stalled | (forward.distance >= self._drawings.room[at]))
        returns = makes_room & ~clamped & retry  # the corner was not behind
        is_back = (mode == Mode.BACK_OUT) & (stalled | (forward.distance <= -BACK))
        rolled = (mode == Mode.ROLL) & (self._roll.phase == RollPhase.DONE)
        self._go(np.flatnonzero(leaves), np.flatnonzero(backs_out), reading)
        self._place.enter(arriving := np.flatnonzero(enters), self.corner[arriving], seen[arriving])
        self._enter(arriving, np.flatnonzero(returns))
        self._retries[has_room] = 0
        self._roll_or_approach(np.flatnonzero(has_room | is_back | rolled), reading)

    def _ends(self, reading: SpaceReading) -> Flags:
        """Whether the straight of each robot that rolls forward ends ahead, (n,); no laser sees a narrower bore."""
        at, forward = (self._every, self.corner), self._forward
        body, radius = reading.body, self._drawings.radius[at]
        seen = senses.sees_end(self._robot, body.q, body.ranges, radius, forward.zigzag_sign)
        reached = self._drawings.reducer[at] & self._place.reaches(self.corner)
        return np.asarray(self._rolls_forward & forward.clamped & (seen | reached))

    def _go(self, leaving: Ints, backing: Ints, reading: SpaceReading) -> None:
        """Let some robots roll on from a corner that is behind, and some back from where they stalled."""
        last = self._drawings.last[leaving, self.corner[leaving]]
        self._place.leave(leaving, last)
        self.corner[leaving] = last + 1
        self._rolls[leaving], self._rolls[backing] = 0, 0
        self._retries[backing] += 1
        self._roll_forward(leaving, Mode.LEAVE, reading)
        self._roll_forward(backing, Mode.BACK_OUT, reading, direction=-1.0)

    def _enter(self, arriving: Ints, returning: Ints) -> None:
        """Let the policy drive in the next corner, or in the one before where that was not behind."""
        self._begin(arriving, Mode.CORNER)
        self.corner[returning] -= 1
        self._place.return_to(returning, self.corner[returning])
        self._retries[returning] += 1
        self._begin(returning, Mode.CORNER)
        self._steps_seen[returning] = -STALL

    def _begin(self, rows: Ints, mode: Mode) -> None:
        self.mode[rows], self._steps_seen[rows], self._lasted[rows] = mode, 0, 0

    def _seen_steadily(self, seen: Flags) -> Flags:
        self._steps_seen = np.where(seen, self._steps_seen + 1, np.minimum(self._steps_seen, 0))
        return np.asarray(self._steps_seen >= STEADY)

    def _roll_forward(self, rows: Ints, mode: Mode, reading: SpaceReading, direction: float = 1.0) -> None:
        self._begin(rows, mode)
        radius = self._drawings.radius[rows, self.corner[rows]]
        self._forward.begin(rows, radius, reading.body.q[rows], self.set_points[rows], direction)

    def _roll_or_approach(self, rows: Ints, reading: SpaceReading) -> None:
        """Let some robots turn their planes into those of the corners ahead, and roll to these where they fit."""
        if not len(rows):
            return
        corner, bends, down = self.corner[rows], reading.body.q[rows], reading.down[rows]
        seen = senses.plane_angle(self._robot, bends, down, self._drawings.axes[rows, corner])
        self.plane[rows] = np.where(np.isnan(seen), self.plane[rows], seen)
        away = _remainder(self._drawings.inside[rows, corner] - self.plane[rows], math.pi)
        turns = (np.abs(away) > TOLERANCE) & (self._rolls[rows] < MAX_ROLLS)
        turning = rows[turns]
        self._rolls[turning] += 1
        self._begin(turning, Mode.ROLL)
        radius = self._drawings.radius[turning, corner[turns]]
        self._roll.begin(turning, radius, away[turns], bends[turns], down[turns])
        self._roll_forward(rows[~turns], Mode.APPROACH, reading)

    def _stalled(self, reading: SpaceReading) -> Flags:
        """Whether each robot has not moved for a while, (n,)."""
        distance = np.where(self._rolls_forward, self._forward.distance, 0.0)
        self._history[self._ring_row] = np.concatenate([reading.body.q, distance[:, None]], axis=1)
        self._ring_row = (self._ring_row + 1) % (STALL + 1)
        self._lasted += 1
        moved = np.ptp(self._history, axis=0)
        still = (moved[:, :-1] < STILL).all(axis=1) & (moved[:, -1] < ON_THE_SPOT)
        return np.asarray((self._lasted > STALL) & still)


def _remainder(angle: Floats, period: float) -> Floats:
    """Angles less the nearest multiples of a period, from -period/2 to period/2, (n,)."""
    rest = np.fmod(angle, period)
    return np.asarray(rest - period * (np.abs(rest) > period / 2) * np.sign(rest))
