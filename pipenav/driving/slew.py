"""Set-points that never jump: at most a step's distance from the last ones, and for a person at a speed that changes
little by little.

A step's distance is what the joint can move in a control period without load. While a person drives, and for a while
after a hand-over, also the change of that distance is bounded, so that the commanded speed goes on without a break; a
set-point brakes early enough to stand at the joint's limit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.robots.robot import RobotSpec

TO_FULL_SPEED = 3
"""Control steps in which a person's joint comes to its full speed: short for a hand, long for a gear."""

EASING = 1.3
"""Factor by which the bound on changes of speed grows in every control step after a hand-over to a policy."""

EASED = 8
"""Control steps after which that bound says nothing any more: 2 steps' distance, from one third of one, by `EASING`."""


class SlewLimits(NamedTuple):
    """Limits of the commands to joints and wheels, (actuators,) each.

    Attributes:
        step: largest change in a control step [rad or m; for wheels rad/s].
        change: largest change of that change while a person drives, same units.
        lower, upper: smallest and largest command [rad or m; for wheels rad/s].
    """

    step: Floats
    change: Floats
    lower: Floats
    upper: Floats

    @classmethod
    def of(cls, robot: RobotSpec) -> SlewLimits:
        """Limits of a robot: no faster than its motors turn without load."""
        wheels = np.array([robot.actuators[wheel.actuator].speed_limit for wheel in robot.wheels])
        joint_step = robot.speed_limits * CONTROL_PERIOD
        step = np.concatenate([joint_step, wheels])
        return cls(
            step,
            step / TO_FULL_SPEED,
            np.concatenate([robot.lower, -wheels]),
            np.concatenate([robot.upper, wheels]),
        )


class Slew:
    """Commands of one robot that never jump.

    Args:
        limits: its limits.
        joints: number of its joints; the commands after those are speeds of wheels.

    Attributes:
        last: the last command, (actuators,).
        pace: change of the joints' set-points in the last control step, (joints,).
    """

    def __init__(self, limits: SlewLimits, joints: int) -> None:
        self._limits, self._joints = limits, joints
        self.last = np.zeros(len(limits.step))
        self.pace = np.zeros(joints)
        self._since = EASED

    def start(self, q: Floats) -> None:
        """Begin where the joints are, (joints,), at rest."""
        self.last = np.concatenate([q, np.zeros(len(self.last) - self._joints)])
        self.pace, self._since = np.zeros(self._joints), EASED

    def hand_over(self) -> None:
        """Begin to ease the bound on changes of speed: a policy drives from now on."""
        self._since = 0

    def person(self, goal: Floats, speed: Floats | float = 1.0) -> Floats:
        """The next command while a person drives, (actuators,).

        Args:
            goal: set-points to go to, then speeds of wheels, (actuators,).
            speed: largest speed of the joints as a share of the fastest, in [0, 1], (joints,) or one number.
        """
        return self._next(goal, speed, self._limits.change)

    def policy(self, goal: Floats) -> Floats:
        """The next command while a policy drives, (actuators,); arguments as `person`."""
        if self._since >= EASED:
            return self._next(goal, 1.0, 2 * self._limits.step, brakes=False)
        change = self._limits.change * EASING**self._since
        self._since += 1
        return self._next(goal, 1.0, change)

    def _next(self, goal: Floats, speed: Floats | float, change: Floats, brakes: bool = True) -> Floats:
        joints, limits = self._joints, self._limits
        goal = np.clip(goal, limits.lower, limits.upper)
        pace = self._joint_pace(goal[:joints], speed, change[:joints], brakes)
        rolling = self.last[joints:]
        change = np.minimum(change, limits.step)[joints:]
        wheels = rolling + np.clip(goal[joints:] - rolling, -change, change)
        before = self.last[:joints]
        now = np.clip(before + pace, limits.lower[:joints], limits.upper[:joints])
        self.pace = now - before
        self.last = np.concatenate([now, wheels])
        return self.last.copy()

    def _joint_pace(self, goal: Floats, speed: Floats | float, change: Floats, brakes: bool) -> Floats:
        """Change of the joints' set-points in the next control step, (joints,)."""
        before, limits = self.last[: self._joints], self._limits
        step, bound = limits.step[: self._joints], limits.change[: self._joints]
        away = goal - before
        most = step * np.asarray(speed)
        most = np.minimum(most, braking(np.abs(away), change)) if brakes else np.minimum(most, np.abs(away))
        wanted = np.clip(away, -most, most)
        eased = np.clip(np.clip(wanted, self.pace - change, self.pace + change), -step, step)
        # In front of a stop everyone brakes as a person does, so that a person may take over there.
        up = braking(np.maximum(limits.upper[: self._joints] - before, 0.0), bound)
        down = braking(np.maximum(before - limits.lower[: self._joints], 0.0), bound)
        return np.clip(eased, -down, up)


def braking(distance: Floats, change: Floats) -> Floats:
    """Largest change in the next control step after which a set-point can still come to stand within a distance.

    A set-point that moves by v and then by a less in every control step comes to stand after n steps and
    n v - a n (n - 1) / 2, where n is the smallest number with v <= n a.

    Args:
        distance: distance to go [rad or m].
        change: largest change a of the change v in a control step, same unit.
    """
    steps = np.maximum(np.ceil((np.sqrt(1.0 + 8.0 * distance / change) - 1.0) / 2.0), 1.0)
    return np.asarray(distance / steps + change * (steps - 1.0) / 2.0)
