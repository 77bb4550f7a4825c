"""Decisions of one robot in space besides its policy: where it is, and when and how far to roll.

The robot knows the pipe's drawing: the diameter, and how every corner turns and is rolled. All else it finds out from
its own sensors (`senses`). Around a corner the policy drives, until the rear half heads along the next straight. Then
the robot clamps, rolls on until there is room, turns its plane into that of the next corner, and rolls on until its
laser sees the end of the straight. Where it stalls, it backs out and tries again.
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
from pipenav.tasks.rolling.manoeuvre import Roll, RollCommand, RollPhase

BEHIND = 0.85
"""Share of a corner's turn angle by which the rear half must have turned for the corner to count as behind."""

STEADY = 3
"""Control steps in a row for which the robot has to see something before it acts on it."""

MARGIN = 0.03
"""Distance to leave between a corner and the robot before it rolls, besides what it stretches backwards [m]."""

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
    """The policy drives around a corner."""
    LEAVE = 1
    """The robot rolls forward from a corner to where it has room to turn its plane."""
    ROLL = 2
    """The robot turns its plane."""
    APPROACH = 3
    """The robot rolls forward to the next corner."""
    BACK_OUT = 4
    """The robot rolls back out of a corner in which the policy stalled."""


class Pilot:
    """Driver of one robot, which decides when the policy acts and when the robot rolls by itself.

    Args:
        robot: the robot, as `check_robot` accepts it.
        route: the route that it is in, before the first corner.
        set_points: set-points of its joints now, (6,) [rad].

    Attributes:
        mode: mode of driving now.
        corner: number of the corner ahead of or around the robot, from 0.
        plane: angle of the robot's plane from the untwisted frame of the straight, as far as the robot knows [rad].
        set_points: set-points of the joints in the last control period, (6,) [rad].
    """

    def __init__(self, robot: RobotSpec, route: PipeRoute, set_points: Floats) -> None:
        self._robot, self._route = robot, route
        self.mode, self.corner, self.set_points = Mode.CORNER, 0, set_points
        self.plane = route.corners[0].roll
        self._forward: RollForward | None = None
        self._roll: Roll | None = None
        self._rolls, self._retries = 0, 0
        self._steps_seen = 0  # control steps for which the robot has seen what it waits for
        self._heading = 0.0  # heading of the divided link, by its gyroscope
        self._rear_before: float | None = None  # heading of the rear half before the corner
        self._history: list[Floats] = []  # joints and rolled distance in the last control steps of this mode
        stretch = 2 * float(robot.lengths[HALF]) * (1 - math.cos(steepness(robot, route.radius)))
        self._room = float(robot.lengths[0]) + stretch + MARGIN

    @property
    def doing(self) -> str:
        """Description of who drives, in words."""
        if self._roll is not None:
            return f"rolling: {self._roll.phase.name.lower().replace('_', ' ')}"
        words = {Mode.CORNER: "policy in ", Mode.LEAVE: "making room before ", Mode.APPROACH: "rolling to "}
        return words.get(self.mode, "back out of ") + f"corner {self.corner + 1}"

    @property
    def _radius(self) -> float:
        """Radius of the bore before the corner [m]."""
        return float(self._route.legs.radius[self.corner])

    @property
    def turn_sign(self) -> float:
        """+1 where the corner turns to the robot's left, -1 where it turns to its right."""
        return 1.0 if math.cos(float(self._route.legs.inside[self.corner]) - self.plane) > 0 else -1.0

    def command(self, reading: SpaceReading, wanted: Floats) -> RollCommand:
        """Set-points for one control period.

        Args:
            reading: readings of this robot, as `SpaceReading.row` gives them.
            wanted: set-points of joints and wheels by the policy, (12,); used where the policy drives.
        """
        bends, wheel_speeds = reading.body.q, reading.body.wheel_speeds
        assert wheel_speeds is not None
        command = RollCommand(wanted, 0.0)
        if self._roll is not None:
            command = self._roll.act(bends, float(reading.roll), wheel_speeds, reading.down)
        elif self._forward is not None:
            command = RollCommand(self._forward.act(bends, wheel_speeds), 0.0)
        self.set_points = command.values[: 2 * HALF].copy()
        return command

    def sense(self, reading: SpaceReading) -> None:
        """Take in the readings of this robot after a control period, and decide who drives next."""
        stalled = self._stalled(reading)
        self.plane += float(reading.turned[:, 0].mean())
        self._heading += float(reading.turned[0, 2])
        if self._forward is not None:
            self._after_rolling_forward(self._forward, reading, stalled)
        elif self._roll is None:
            self._after_policy(reading, stalled)
        elif self._roll.phase is RollPhase.DONE:
            self._roll_or_approach(reading)

    def _after_policy(self, reading: SpaceReading, stalled: bool) -> None:
        """Take over from the policy where the corner is behind, or where the robot stalled."""
        rear = self._heading - senses.heading_from_rear_half(self._robot, reading.body.q)
        self._rear_before = rear if self._rear_before is None else self._rear_before
        turn_angle = math.pi - self._route.corners[self.corner].angle
        behind = (rear - self._rear_before) * self.turn_sign >= BEHIND * turn_angle
        if self._seen_steadily(behind) and self.corner + 1 < len(self._route.corners):
            self.corner, self._rolls = self.corner + 1, 0
            self._roll_forward(Mode.LEAVE, reading)
        elif stalled and self._retries < MAX_RETRIES:
            self._back_out(reading)

    def _after_rolling_forward(self, forward: RollForward, reading: SpaceReading, stalled: bool) -> None:
        """Go on to the next mode where the robot has arrived, or where it stalled."""
        end_ahead = forward.clamped and senses.sees_end(self._robot, reading, self._radius, forward.zigzag_sign)
        near = self._seen_steadily(end_ahead)
        if self.mode is Mode.BACK_OUT:
            if stalled or forward.distance <= -BACK:
                self._roll_or_approach(reading)
        elif self.mode is Mode.APPROACH:
            if stalled and self._retries < MAX_RETRIES:
                self._back_out(reading)
            elif near or stalled:
                self._begin(Mode.CORNER)
                self._rear_before = None
        elif forward.clamped and stalled and self._retries < MAX_RETRIES:  # it slid into the next corner
            self._back_out(reading)
        elif forward.clamped and (near or stalled or forward.distance >= self._room):
            self._retries = 0
            self._roll_or_approach(reading)
        elif stalled and self._retries < MAX_RETRIES:  # the corner was not behind
            self.corner, self._retries = self.corner - 1, self._retries + 1
            self._begin(Mode.CORNER)
            self._steps_seen = -STALL

    def _back_out(self, reading: SpaceReading) -> None:
        self._rolls, self._retries = 0, self._retries + 1
        self._roll_forward(Mode.BACK_OUT, reading, direction=-1.0)

    def _begin(self, mode: Mode) -> None:
        self.mode, self._forward, self._roll = mode, None, None
        self._steps_seen, self._history = 0, []

    def _seen_steadily(self, seen: bool) -> bool:
        self._steps_seen = self._steps_seen + 1 if seen else min(self._steps_seen, 0)
        return self._steps_seen >= STEADY

    def _roll_forward(self, mode: Mode, reading: SpaceReading, direction: float = 1.0) -> None:
        self._begin(mode)
        self._forward = RollForward(self._robot, self._radius, reading.body.q, self.set_points, direction)

    def _roll_or_approach(self, reading: SpaceReading) -> None:
        """Turn the plane where it is not that of the corner ahead, else roll forward to the corner."""
        seen = senses.plane_angle(self._robot, reading, self._route.legs.axes[self.corner])
        self.plane = self.plane if seen is None else seen
        away = math.remainder(float(self._route.legs.inside[self.corner]) - self.plane, math.pi)
        if abs(away) > TOLERANCE and self._rolls < MAX_ROLLS:
            self._rolls += 1
            self._begin(Mode.ROLL)
            self._roll = Roll(self._robot, self._radius, away, reading.body.q, reading.down)
        else:
            self._roll_forward(Mode.APPROACH, reading)

    def _stalled(self, reading: SpaceReading) -> bool:
        """Whether the robot has not moved for a while."""
        distance = 0.0 if self._forward is None else self._forward.distance
        self._history = [*self._history[-STALL:], np.append(reading.body.q, distance)]
        moved = np.ptp(self._history, axis=0)
        return len(self._history) > STALL and bool((moved[:-1] < STILL).all() and moved[-1] < ON_THE_SPOT)
