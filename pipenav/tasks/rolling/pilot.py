"""What one robot in space knows and does besides its policy: where it is, and when and how far to roll.

It knows the pipe's drawing: the diameter, and how every corner turns and is rolled. All else it finds out from its own
sensors (`senses`). Around a corner the policy drives, until the rear half heads along the next straight. Then the robot
clamps, goes on until there is room, turns its plane into that of the next corner, and goes on until its laser sees the
straight end. Where it stalls it tries another way.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.spatial import SpaceReading
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling import senses
from pipenav.tasks.rolling.clamp import HALF, RollForward, steepness
from pipenav.tasks.rolling.manoeuvre import Roll, RollPhase

BEHIND = 0.85
"""Share of a corner's turn by which the rear half heads another way than before the corner when that is behind."""

STEADY = 3
"""Control steps for which the robot has to see something before it acts on it."""

MARGIN = 0.03
"""How far behind it leaves a corner before it rolls, besides what it stretches backwards [m]."""

TOLERANCE = math.radians(6.0)
"""How far the robot's plane may be from a corner's."""

GOES, TRIES = 3, 4
"""How often it rolls at most before a corner, and backs out of it or goes back to its end."""

STALL = 20
"""Control steps in which a robot is stalled that has not moved."""

STILL, ON_THE_SPOT = 0.15, 0.03
"""A robot has not moved if no joint has by more than this [rad] nor, where it drives itself, its wheels by this [m]."""

BACK = 0.2
"""How far it backs out of a corner in which it stalled [m]."""


class Mode(IntEnum):
    """Who drives: the policy around a corner; or the robot itself, on from a corner to where it may roll, rolling, on
    to the next corner, or back out of one in which the policy stalled."""

    CORNER = 0
    LEAVE = 1
    ROLL = 2
    APPROACH = 3
    BACK_OUT = 4


class Pilot:
    """One robot's.

    Attributes:
        mode: who drives.
        corner: the corner ahead or around the robot.
        plane: how the robot's plane is turned from the straights' untwisted frames, as far as it knows [rad].
        set_points: of the joints, (6,) [rad].
    """

    def __init__(self, robot: RobotSpec, route: PipeRoute, set_points: Floats) -> None:
        self._robot, self._route = robot, route
        self.mode, self.corner, self.set_points = Mode.CORNER, 0, set_points
        self.plane = route.corners[0].roll
        self._drive: RollForward | None = None
        self._roll: Roll | None = None
        self._goes, self._tries = 0, 0
        self._seen = 0  # control steps for which it has seen what it waits for
        self._heading = 0.0  # of the divided link, by its gyroscope
        self._before: float | None = None  # that of the rear half before the corner
        self._past: list[Floats] = []  # joints and way gone in the last control steps of this mode
        stretch = 2 * float(robot.lengths[HALF]) * (1 - math.cos(steepness(robot, route.radius)))
        self._leave = float(robot.lengths[0]) + stretch + MARGIN

    @property
    def doing(self) -> str:
        """Who drives, in words."""
        if self._roll is not None:
            return f"rolling: {self._roll.phase.name.lower().replace('_', ' ')}"
        words = {Mode.CORNER: "policy in ", Mode.LEAVE: "room before ", Mode.APPROACH: "on to "}
        return words.get(self.mode, "back out of ") + f"corner {self.corner + 1}"

    @property
    def turn_sign(self) -> float:
        """+1 where the corner turns to the robot's left, -1 to its right."""
        return 1.0 if math.cos(float(self._route.legs.inside[self.corner]) - self.plane) > 0 else -1.0

    def command(self, reading: SpaceReading, of_policy: Floats) -> tuple[Floats, float]:
        """Set-points of joints and wheels, (12,), and of the roll joint [rad].

        Args:
            reading: one robot's, as `SpaceReading.row` gives it.
            of_policy: what the policy wants of joints and wheels, (12,).
        """
        bends, wheels, roll = reading.body.q, reading.body.wheel_speeds, 0.0
        assert wheels is not None
        command = of_policy
        if self._roll is not None:
            command, roll = self._roll.act(bends, float(reading.roll), wheels, reading.down)
        elif self._drive is not None:
            command = self._drive.act(bends, wheels)
        self.set_points = command[: 2 * HALF].copy()
        return command, roll

    def sense(self, reading: SpaceReading) -> None:
        """Take in what one robot's sensors give after a control period, and decide who drives next."""
        stalled = self._stalled(reading)
        self.plane += float(reading.turned[:, 0].mean())
        self._heading += float(reading.turned[0, 2])
        if self._drive is not None:
            self._go_on(self._drive, reading, stalled)
        elif self._roll is None:
            self._around(reading, stalled)
        elif self._roll.phase is RollPhase.DONE:
            self._roll_or_approach(reading)

    def _around(self, reading: SpaceReading, stalled: bool) -> None:
        """The policy drives: is the corner behind?"""
        rear = self._heading - senses.from_rear_half(self._robot, reading.body.q)
        self._before = rear if self._before is None else self._before
        turn = math.pi - self._route.corners[self.corner].angle
        behind = (rear - self._before) * self.turn_sign >= BEHIND * turn
        if self._lasts(behind) and self.corner + 1 < len(self._route.corners):
            self.corner, self._goes = self.corner + 1, 0
            self._begin_driving(Mode.LEAVE, reading)
        elif stalled and self._tries < TRIES:
            self._back_out(reading)

    def _go_on(self, drive: RollForward, reading: SpaceReading, stalled: bool) -> None:
        """The robot drives itself: is it where it wants to be?"""
        near = self._lasts(drive.clamped and senses.sees_end(self._robot, reading, self._route.radius, drive.third))
        if self.mode is Mode.BACK_OUT:
            if stalled or drive.gone <= -BACK:
                self._roll_or_approach(reading)
        elif self.mode is Mode.APPROACH:
            if stalled and self._tries < TRIES:
                self._back_out(reading)
            elif near or stalled:
                self._begin(Mode.CORNER)
                self._before = None
        elif drive.clamped and stalled and self._tries < TRIES:  # it slid into the next corner
            self._back_out(reading)
        elif drive.clamped and (near or stalled or drive.gone >= self._leave):
            self._tries = 0
            self._roll_or_approach(reading)
        elif stalled and self._tries < TRIES:  # the corner was not behind
            self.corner, self._tries = self.corner - 1, self._tries + 1
            self._begin(Mode.CORNER)
            self._seen = -STALL

    def _back_out(self, reading: SpaceReading) -> None:
        self._goes, self._tries = 0, self._tries + 1
        self._begin_driving(Mode.BACK_OUT, reading, direction=-1.0)

    def _begin(self, mode: Mode) -> None:
        self.mode, self._drive, self._roll = mode, None, None
        self._seen, self._past = 0, []

    def _lasts(self, seen: bool) -> bool:
        self._seen = self._seen + 1 if seen else min(self._seen, 0)
        return self._seen >= STEADY

    def _begin_driving(self, mode: Mode, reading: SpaceReading, direction: float = 1.0) -> None:
        self._begin(mode)
        self._drive = RollForward(self._robot, self._route.radius, reading.body.q, self.set_points, direction)

    def _roll_or_approach(self, reading: SpaceReading) -> None:
        """Roll where the plane is not that of the corner ahead, else go on to it."""
        seen = senses.plane_of(self._robot, reading, self._route.legs.axes[self.corner])
        self.plane = self.plane if seen is None else seen
        away = math.remainder(float(self._route.legs.inside[self.corner]) - self.plane, math.pi)
        if abs(away) > TOLERANCE and self._goes < GOES:
            self._goes += 1
            self._begin(Mode.ROLL)
            self._roll = Roll(self._robot, self._route.radius, away, reading.body.q, reading.down)
        else:
            self._begin_driving(Mode.APPROACH, reading)

    def _stalled(self, reading: SpaceReading) -> bool:
        """Whether it has not moved for a while."""
        gone = 0.0 if self._drive is None else self._drive.gone
        self._past = [*self._past[-STALL:], np.append(reading.body.q, gone)]
        moved = np.ptp(self._past, axis=0)
        return len(self._past) > STALL and bool((moved[:-1] < STILL).all() and moved[-1] < ON_THE_SPOT)
