"""The roll manoeuvre: a whole robot turns its plane about a straight pipe's axis, one half after the other.

One half clamps with its three wheels; the other one stretches along a wall and is turned by the roll joint. Then that
one clamps in its new plane, the first one stretches, and follows as the roll joint turns back. All is decided from the
robot's own sensors: joints, wheel odometry, and which side of a half hangs low.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import HALF, PRESS, SPEED, forwards, nearest, steepness

REAR, FRONT = 0, 1

TILT = 0.08
"""How far the half that is stretched leans away from the wall along which it lies [rad]."""

SETTLED = 0.1
"""How near to their set-points joints that do not press are when a phase is over [rad]."""

DWELL, PATIENCE = 3, 15
"""Control steps for which a phase goes on after its set-points have arrived: at least, and if joints do not settle."""

HOLD = 3.0
"""How fast standing wheels turn back to where they stood, per angle by which they were turned [1/s]."""

LEVEL = 0.1
"""A plane across which less than this share of the weight pulls has no lower side."""


class RollPhase(IntEnum):
    """What a robot is doing. The first half is the one that is turned first."""

    CLAMP = 0
    STRETCH_FIRST = 1
    TURN_FIRST = 2
    CLAMP_FIRST = 3
    STRETCH_SECOND = 4
    TURN_SECOND = 5
    CLAMP_BOTH = 6
    DONE = 7


class Roll:
    """One robot's manoeuvre.

    Args:
        robot: see `check_robot`.
        radius: of the bore [m].
        turn: by how much to turn the plane, by the right-hand rule about the direction of travel [rad].
        bends: joint positions now, (6,) [rad].
        down: as `SpaceReading.down`, (halves, 3).
    """

    def __init__(self, robot: RobotSpec, radius: float, turn: float, bends: Floats, down: Floats) -> None:
        self._turn = turn
        self._speed = SPEED * np.append(robot.speed_limits, robot.speed_limits[0]) * CONTROL_PERIOD
        self._steep = steepness(robot, radius)
        third = nearest(bends)
        self._sides = np.array([third, -third])  # the walls of the inner wheels, 3 and 4
        # The first half is stretched along the wall on which the other half's inner wheel stands: the lower one.
        self._first = REAR if lower_side(down[REAR]) == -third else FRONT
        self.phase, self._since = RollPhase.CLAMP, 0
        self._from, self._roll_from = np.array(bends), 0.0
        self._to, self._press = self._pose()
        self._odometer = np.zeros(2)  # how far each half has rolled forwards since it was put down [rad]

    @property
    def _second(self) -> int:
        return 1 - self._first

    def act(self, bends: Floats, roll: float, wheel_speeds: Floats, down: Floats) -> tuple[Floats, float]:
        """Set-points of joints and wheels, (12,), and of the roll joint [rad], for one control period.

        Args:
            bends: joint positions, (6,) [rad].
            roll: position of the roll joint [rad].
            wheel_speeds: (6,) [rad/s].
            down: as `SpaceReading.down`, (halves, 3).
        """
        onwards = forwards(bends)
        self._odometer += CONTROL_PERIOD * (wheel_speeds * onwards).reshape(2, HALF).mean(axis=1)
        if self._arrived(bends, roll):
            self._next(down)
        self._since += 1
        ways = np.append(self._to - self._from, self._roll_to - self._roll_from)
        share = min(1.0, self._since / max(1.0, float(np.abs(ways / self._speed).max())))
        back = np.repeat(np.where(self._holds, -HOLD * self._odometer, 0.0), HALF) * onwards
        set_points = self._from + share * (self._to - self._from) + self._press
        return np.concatenate([set_points, back]), self._roll_from + share * (self._roll_to - self._roll_from)

    def _arrived(self, bends: Floats, roll: float) -> bool:
        ways = np.append(self._to - self._from, self._roll_to - self._roll_from)
        after = self._since - float(np.abs(ways / self._speed).max())
        away = np.where(self._press == 0, np.abs(self._to - bends), 0.0).max()
        settled = max(away, abs(self._roll_to - roll)) <= SETTLED
        return after >= PATIENCE or (after >= DWELL and bool(settled))

    def _next(self, down: Floats) -> None:
        held = self._holds
        self._from, self._roll_from = self._to, self._roll_to
        self.phase, self._since = RollPhase(self.phase + 1), 0
        if self.phase is RollPhase.CLAMP_FIRST:
            low = lower_side(down[self._first])
            self._sides[self._first] = low or self._sides[self._first]
        elif self.phase is RollPhase.CLAMP_BOTH:
            self._sides[self._second] = -self._sides[self._first]
        self._to, self._press = self._pose()
        self._odometer[self._holds & ~held] = 0.0

    @property
    def _roll_to(self) -> float:
        turned = RollPhase.TURN_FIRST <= self.phase < RollPhase.TURN_SECOND
        return self._turn * (1 if self._first == FRONT else -1) * turned

    @property
    def _holds(self) -> Flags:
        """Which halves' wheels keep their places, (halves,)."""
        one = np.arange(2) == (self._second if self.phase < RollPhase.STRETCH_SECOND else self._first)
        return one if RollPhase.CLAMP < self.phase < RollPhase.CLAMP_BOTH else np.ones(2, bool)

    def _pose(self) -> tuple[Floats, Floats]:
        """The joints' set-points in this phase, and how much farther those that press are set, (6,) each [rad]."""
        clamp = np.array([-self._steep, 2 * self._steep, -self._steep])  # from the middle outwards, on the left wall
        press, phase = np.array([0.0, PRESS, 0.0]), self.phase
        both = phase in (RollPhase.CLAMP, RollPhase.CLAMP_BOTH, RollPhase.DONE)
        bends, presses = np.zeros((2, HALF)), np.zeros((2, HALF))
        for half in (REAR, FRONT):
            stretched = half == self._first and phase in (RollPhase.STRETCH_FIRST, RollPhase.TURN_FIRST)
            stretched |= half == self._second and phase in (RollPhase.STRETCH_SECOND, RollPhase.TURN_SECOND)
            if stretched:
                continue
            inner = -self._steep if both else 0.0 if half == self._first and phase is RollPhase.CLAMP_FIRST else -TILT
            bends[half] = self._sides[half] * (clamp + np.array([inner, 0.0, 0.0]))
            presses[half] = self._sides[half] * press
        order = np.concatenate([bends[REAR, ::-1], bends[FRONT]])
        return order, np.concatenate([presses[REAR, ::-1], presses[FRONT]])


def lower_side(down: Floats) -> float:
    """Which side of a half hangs low, +1 the left, -1 the right, 0 neither; of `down` in its frame, (3,)."""
    return float(np.sign(down[1])) if abs(down[1]) > LEVEL else 0.0
