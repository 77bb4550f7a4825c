"""The roll manoeuvre: a whole robot turns its plane about a straight pipe's axis, one half after the other.

One half clamps with its three wheels. The other half stretches along a wall, is turned by the roll joint, and clamps in
the new plane. Then the first half stretches and follows as the roll joint turns back. All is decided from the robot's
own sensors: its joints, its wheel odometry, and which side of a half hangs low.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import HALF, PRESS, SPEED, forward_directions, nearest_zigzag, steepness

REAR, FRONT = 0, 1
"""Rows of the two halves."""

TILT = 0.08
"""Angle by which the stretched half leans away from the wall along which it lies [rad]."""

SETTLED = 0.1
"""Largest distance from their set-points of joints that do not press when a phase ends [rad]."""

DWELL, PATIENCE = 3, 15
"""Control steps for which a phase goes on after its set-points have arrived: at least, and if joints do not settle."""

HOLD = 3.0
"""Rate at which standing wheels turn back to where they stood [1/s]: speed per angle by which they were turned."""

LEVEL = 0.1
"""Share of the weight that must pull across a half for one of its sides to be the lower one."""


class RollPhase(IntEnum):
    """Phase of the manoeuvre. The first half is the one that is turned first."""

    CLAMP = 0
    """Both halves clamp in the old plane."""
    STRETCH_FIRST = 1
    """The first half stretches along a wall."""
    TURN_FIRST = 2
    """The roll joint turns the first half into the new plane."""
    CLAMP_FIRST = 3
    """The first half clamps in the new plane."""
    STRETCH_SECOND = 4
    """The second half stretches along a wall."""
    TURN_SECOND = 5
    """The roll joint turns back, and the second half follows into the new plane."""
    CLAMP_BOTH = 6
    """Both halves clamp in the new plane."""
    DONE = 7
    """The manoeuvre is over."""


class RollCommand(NamedTuple):
    """Set-points of one robot for one control period.

    Attributes:
        values: set-points of joints and wheels, (12,) [rad, then rad/s].
        roll: set-point of the roll joint [rad].
    """

    values: Floats
    roll: float


class _Pose(NamedTuple):
    """Pose of the joints in one phase.

    Attributes:
        bends: joint positions that fit the bore, (6,) [rad].
        press: distance of the set-points beyond them, 0 where a joint does not press, (6,) [rad].
    """

    bends: Floats
    press: Floats


class Roll:
    """The manoeuvre of one robot.

    Args:
        robot: the robot, as `check_robot` accepts it.
        radius: radius of the bore [m].
        roll_angle: angle by which to roll the plane, by the right-hand rule about the direction of travel [rad].
        bends: joint positions now, (6,) [rad].
        down: direction of down in each half's frame, as `SpaceReading.down`, (halves, 3).

    Attributes:
        phase: the phase now.
    """

    def __init__(self, robot: RobotSpec, radius: float, roll_angle: float, bends: Floats, down: Floats) -> None:
        self._roll_angle = roll_angle
        self._speed = SPEED * np.append(robot.speed_limits, robot.speed_limits[0]) * CONTROL_PERIOD
        self._steepness = steepness(robot, radius)
        sign = nearest_zigzag(bends)
        self._inner_walls = np.array([sign, -sign])  # +1 where a half's inner wheel, 3 or 4, stands on the left wall
        # The first half is stretched along the wall on which the other half's inner wheel stands: the lower one.
        self._first = REAR if lower_side(down[REAR]) == -sign else FRONT
        self.phase, self._since = RollPhase.CLAMP, 0
        self._from, self._roll_from = np.array(bends), 0.0
        self._to = self._pose()
        self._odometer = np.zeros(2)  # angle that each half's wheels have rolled forwards since it was put down [rad]

    @property
    def _second(self) -> int:
        return 1 - self._first

    def act(self, bends: Floats, roll: float, wheel_speeds: Floats, down: Floats) -> RollCommand:
        """Set-points for one control period.

        Args:
            bends: joint positions, (6,) [rad].
            roll: position of the roll joint [rad].
            wheel_speeds: wheel speeds, (6,) [rad/s].
            down: direction of down in each half's frame, as `SpaceReading.down`, (halves, 3).
        """
        directions = forward_directions(bends)
        self._odometer += CONTROL_PERIOD * (wheel_speeds * directions).reshape(2, HALF).mean(axis=1)
        if self._arrived(bends, roll):
            self._begin_next_phase(down)
        self._since += 1
        share = min(1.0, self._since / max(1.0, self._duration))
        back = np.repeat(np.where(self._holds, -HOLD * self._odometer, 0.0), HALF) * directions
        set_points = self._from + share * (self._to.bends - self._from) + self._to.press
        roll_set_point = self._roll_from + share * (self._roll_to - self._roll_from)
        return RollCommand(np.concatenate([set_points, back]), roll_set_point)

    @property
    def _duration(self) -> float:
        """Control steps in which the set-points of this phase arrive, not rounded."""
        changes = np.append(self._to.bends - self._from, self._roll_to - self._roll_from)
        return float(np.abs(changes / self._speed).max())

    def _arrived(self, bends: Floats, roll: float) -> bool:
        after = self._since - self._duration
        away = np.where(self._to.press == 0, np.abs(self._to.bends - bends), 0.0).max()
        settled = max(away, abs(self._roll_to - roll)) <= SETTLED
        return after >= PATIENCE or (after >= DWELL and bool(settled))

    def _begin_next_phase(self, down: Floats) -> None:
        held = self._holds
        self._from, self._roll_from = self._to.bends, self._roll_to
        self.phase, self._since = RollPhase(self.phase + 1), 0
        if self.phase is RollPhase.CLAMP_FIRST:
            lower = lower_side(down[self._first])
            self._inner_walls[self._first] = lower or self._inner_walls[self._first]
        elif self.phase is RollPhase.CLAMP_BOTH:
            self._inner_walls[self._second] = -self._inner_walls[self._first]
        self._to = self._pose()
        self._odometer[self._holds & ~held] = 0.0

    @property
    def _roll_to(self) -> float:
        turned = RollPhase.TURN_FIRST <= self.phase < RollPhase.TURN_SECOND
        return self._roll_angle * (1 if self._first == FRONT else -1) * turned

    @property
    def _holds(self) -> Flags:
        """Whether the wheels of each half keep their positions, (halves,)."""
        one = np.arange(2) == (self._second if self.phase < RollPhase.STRETCH_SECOND else self._first)
        return one if RollPhase.CLAMP < self.phase < RollPhase.CLAMP_BOTH else np.ones(2, bool)

    def _pose(self) -> _Pose:
        """Pose of this phase."""
        steep, phase = self._steepness, self.phase
        clamp = np.array([-steep, 2 * steep, -steep])  # from the middle outwards, inner wheel on the left wall
        press = np.array([0.0, PRESS, 0.0])
        both = phase in (RollPhase.CLAMP, RollPhase.CLAMP_BOTH, RollPhase.DONE)
        bends, presses = np.zeros((2, HALF)), np.zeros((2, HALF))
        for half in (REAR, FRONT):
            stretched = half == self._first and phase in (RollPhase.STRETCH_FIRST, RollPhase.TURN_FIRST)
            stretched |= half == self._second and phase in (RollPhase.STRETCH_SECOND, RollPhase.TURN_SECOND)
            if stretched:
                continue
            inner = -steep if both else 0.0 if half == self._first and phase is RollPhase.CLAMP_FIRST else -TILT
            bends[half] = self._inner_walls[half] * (clamp + np.array([inner, 0.0, 0.0]))
            presses[half] = self._inner_walls[half] * press
        order = np.concatenate([bends[REAR, ::-1], bends[FRONT]])
        return _Pose(order, np.concatenate([presses[REAR, ::-1], presses[FRONT]]))


def lower_side(down: Floats) -> float:
    """Side of a half that hangs low: +1 the left, -1 the right, 0 neither.

    Args:
        down: direction of down in the half's frame, (3,).
    """
    return float(np.sign(down[1])) if abs(down[1]) > LEVEL else 0.0
