"""The roll manoeuvre: a whole robot turns its plane about a straight pipe's axis, one half after the other.

One half clamps with its three wheels. The other half stretches along a wall, is turned by the roll joint, and clamps in
the new plane. Then the first half stretches and follows as the roll joint turns back. All is decided from the robot's
own sensors: its joints, its wheel odometry, and which side of a half hangs low.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
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
    """Set-points of n robots for one control period.

    Attributes:
        values: set-points of joints and wheels, (n, 12) [rad, then rad/s].
        roll: set-points of the roll joints, (n,) [rad].
    """

    values: Floats
    roll: Floats


class _Pose(NamedTuple):
    """Pose that each of n robots goes to in its phase.

    Attributes:
        bends: joint positions that fit the bore, (n, 6) [rad].
        press: distance of the set-points beyond them, 0 where a joint does not press, (n, 6) [rad].
        roll: position of the roll joint, (n,) [rad].
    """

    bends: Floats
    press: Floats
    roll: Floats


class Roll:
    """The manoeuvre of n robots, each from when it begins.

    Args:
        robot: the robot, as `check_robot` accepts it.
        n: number of robots.

    Attributes:
        phase: each robot's phase, a `RollPhase`, (n,).
    """

    def __init__(self, robot: RobotSpec, n: int) -> None:
        self._robot = robot
        self._speed = SPEED * np.append(robot.speed_limits, robot.speed_limits[0]) * CONTROL_PERIOD
        self.phase, self._since = np.full(n, RollPhase.DONE.value), np.zeros(n, int)
        self._roll_angle, self._steepness = np.zeros((2, n))
        self._inner_walls = np.ones((n, 2))  # +1 where a half's inner wheel, 3 or 4, stands on the left wall
        self._first = np.full(n, FRONT)
        self._odometer = np.zeros((n, 2))  # angle that each half's wheels rolled forwards since it was put down [rad]
        joints = len(robot.joints)
        self._from = _Pose(np.zeros((n, joints)), np.zeros((n, joints)), np.zeros(n))
        self._to = _Pose(np.zeros((n, joints)), np.zeros((n, joints)), np.zeros(n))

    def begin(self, rows: Ints, radius: Floats, roll_angle: Floats, bends: Floats, down: Floats) -> None:
        """Let some robots begin.

        Args:
            rows: which robots, (k,).
            radius: radius of the bore, (k,) [m].
            roll_angle: angle by which to roll the plane, by the right-hand rule about the direction of travel, (k,)
                [rad].
            bends: joint positions now, (k, 6) [rad].
            down: direction of down in each half's frame, as `SpaceReading.down`, (k, halves, 3).
        """
        self._roll_angle[rows], self._steepness[rows] = roll_angle, steepness(self._robot, radius)
        sign = nearest_zigzag(bends)
        self._inner_walls[rows] = np.stack([sign, -sign], axis=1)
        # The first half is stretched along the wall on which the other half's inner wheel stands: the lower one.
        self._first[rows] = np.where(lower_side(down[:, REAR]) == -sign, REAR, FRONT)
        self.phase[rows], self._since[rows], self._odometer[rows] = RollPhase.CLAMP, 0, 0.0
        self._from.bends[rows], self._from.roll[rows] = bends, 0.0
        self._set_out(rows)

    def act(self, rows: Ints, bends: Floats, roll: Floats, wheel_speeds: Floats, down: Floats) -> RollCommand:
        """Set-points of some robots for one control period.

        Args:
            rows: which robots, (k,).
            bends: joint positions, (k, 6) [rad].
            roll: positions of the roll joints, (k,) [rad].
            wheel_speeds: wheel speeds, (k, 6) [rad/s].
            down: direction of down in each half's frame, as `SpaceReading.down`, (k, halves, 3).
        """
        directions = forward_directions(bends)
        self._odometer[rows] += CONTROL_PERIOD * (wheel_speeds * directions).reshape(-1, 2, HALF).mean(axis=2)
        arrived = self._arrived(rows, bends, roll)
        self._begin_next_phase(rows[arrived], down[arrived])
        self._since[rows] += 1
        start, to = (_Pose(*(column[rows] for column in pose)) for pose in (self._from, self._to))
        share = np.minimum(1.0, self._since[rows] / np.maximum(1.0, self._duration(rows)))
        back = np.where(self._holds(rows), -HOLD * self._odometer[rows], 0.0).repeat(HALF, axis=1) * directions
        set_points = start.bends + share[:, None] * (to.bends - start.bends) + to.press
        roll_set_points = start.roll + share * (to.roll - start.roll)
        return RollCommand(np.concatenate([set_points, back], axis=1), roll_set_points)

    def _duration(self, rows: Ints) -> Floats:
        """Control steps in which the set-points of the phase arrive, not rounded, (k,)."""
        bends, roll = self._to.bends[rows] - self._from.bends[rows], self._to.roll[rows] - self._from.roll[rows]
        changes = np.concatenate([bends, roll[:, None]], axis=1)
        return np.asarray(np.abs(changes / self._speed).max(axis=1))

    def _arrived(self, rows: Ints, bends: Floats, roll: Floats) -> Flags:
        after, to = self._since[rows] - self._duration(rows), self._to.bends[rows]
        away = np.where(self._to.press[rows] == 0, np.abs(to - bends), 0.0).max(axis=1)
        settled = np.maximum(away, np.abs(self._to.roll[rows] - roll)) <= SETTLED
        return np.asarray((after >= PATIENCE) | ((after >= DWELL) & settled))

    def _begin_next_phase(self, rows: Ints, down: Floats) -> None:
        if not len(rows):
            return
        held, first, k = self._holds(rows), self._first[rows], np.arange(len(rows))
        self._from.bends[rows], self._from.roll[rows] = self._to.bends[rows], self._to.roll[rows]
        self.phase[rows] += 1
        self._since[rows] = 0
        phase, walls = self.phase[rows], self._inner_walls[rows]
        lower = lower_side(down[k, first])
        clamps_first = (phase == RollPhase.CLAMP_FIRST) & (lower != 0)
        walls[k, first] = np.where(clamps_first, lower, walls[k, first])
        walls[k, 1 - first] = np.where(phase == RollPhase.CLAMP_BOTH, -walls[k, first], walls[k, 1 - first])
        self._inner_walls[rows] = walls
        self._set_out(rows)
        self._odometer[rows] = np.where(self._holds(rows) & ~held, 0.0, self._odometer[rows])

    def _holds(self, rows: Ints) -> Flags:
        """Whether the wheels of each half keep their positions, (k, halves)."""
        phase, first = self.phase[rows, None], self._first[rows, None]
        one = np.arange(2) == np.where(phase < RollPhase.STRETCH_SECOND, 1 - first, first)
        return np.asarray(one | (phase <= RollPhase.CLAMP) | (phase >= RollPhase.CLAMP_BOTH))

    def _set_out(self, rows: Ints) -> None:
        """Set the pose that some robots go to in their phases."""
        steep, phase, first = self._steepness[rows], self.phase[rows, None], self._first[rows, None] == np.arange(2)
        both = (phase == RollPhase.CLAMP) | (phase >= RollPhase.CLAMP_BOTH)
        stretched = first & ((phase == RollPhase.STRETCH_FIRST) | (phase == RollPhase.TURN_FIRST))
        stretched |= ~first & ((phase == RollPhase.STRETCH_SECOND) | (phase == RollPhase.TURN_SECOND))
        lean = np.where(first & (phase == RollPhase.CLAMP_FIRST), 0.0, -TILT)
        inner = np.where(both, -steep[:, None], lean)  # bend of the joint beside the divided link, (k, halves)
        walls = np.where(stretched, 0.0, self._inner_walls[rows])
        bends = np.zeros((len(rows), 2, HALF))  # from the middle outwards, inner wheel on the left wall
        bends[:, :, 0], bends[:, :, 1], bends[:, :, 2] = inner - steep[:, None], 2 * steep[:, None], -steep[:, None]
        press = np.array([0.0, PRESS, 0.0])
        self._to.bends[rows] = _in_order(walls[:, :, None] * bends)
        self._to.press[rows] = _in_order(walls[:, :, None] * press)
        turned = (phase[:, 0] >= RollPhase.TURN_FIRST) & (phase[:, 0] < RollPhase.TURN_SECOND)
        self._to.roll[rows] = self._roll_angle[rows] * np.where(first[:, FRONT], 1.0, -1.0) * turned


def _in_order(halves: Floats) -> Floats:
    """Values of the joints from the rear to the front, (k, 6), from those of the halves outwards, (k, halves, 3)."""
    return np.concatenate([halves[:, REAR, ::-1], halves[:, FRONT]], axis=1)


def lower_side(down: Floats) -> Floats:
    """Side of a half that hangs low: +1 the left, -1 the right, 0 neither, (k,).

    Args:
        down: direction of down in the half's frame, (k, 3).
    """
    return np.where(np.abs(down[:, 1]) > LEVEL, np.sign(down[:, 1]), 0.0)
