"""The turning sequence in one corner: what a robot does in each phase, and when a phase is done.

All is decided from a pose, wherever that comes from: `baseline:sequence` knows it, and the steps of `pipenav drive`
estimate it from the robot's own sensors.
"""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.sequence_arm import FRONT_MOUNT, HINGES, FrontArm
from pipenav.policies.baselines.sequence_phases import CLAMPING, PRESSING, Course, RobotState, TurnPhase
from pipenav.policies.baselines.sequence_plan import PRESS, CornerPlan

SPEED = 0.8
"""Rolling speed where the joints need not bend, as a share of the wheels' no-load speed."""

LAG = 0.25
"""Distance of a joint from its set-point at which the robot no longer rolls on [rad]; it slows down towards that."""

LOOK_AHEAD = 0.010
"""Distance of the moving half's set-points ahead of the clamp [m]: about as much as that half lags behind."""

SETTLED = 0.15
"""Largest distance of any joint from its set-point when a clamp counts as closed [rad]."""

DWELL = 30
"""Control steps after which a clamp counts as closed anyway: a wheel may stand on a wall before its bend ends."""


class SequenceTurn:
    """The sequence in one corner.

    Args:
        pipe: the pipe, a left or a right turn.
        plan: the plan of the left turn.
        arm: a policy that brings the front half's tip to a target; None to lead that half along a line all the way.
    """

    def __init__(self, pipe: PipeCorner, plan: CornerPlan, arm: FrontArm | None) -> None:
        self._pipe, self._plan, self._arm = pipe, plan, arm

    def goal(self, course: Course, state: RobotState) -> Floats:
        """Joint angles in a left turn that a robot goes to in its phase, with those that press beyond, (6,) [rad]."""
        press = np.zeros(len(state.bends))
        press[PRESSING[course.phase]] = PRESS
        return self._bends(course, state) - press

    def speed(self, course: Course, state: RobotState) -> float:
        """Share of the wheels' no-load speed at which a robot rolls in its phase."""
        if course.phase in CLAMPING:
            return 0.0
        away = self._bends(course, state) - state.bends
        loose = np.ones(len(away), bool)
        loose[PRESSING[course.phase]] = False
        return SPEED * max(0.0, 1.0 - float(np.abs(away[loose]).max()) / LAG)

    def keep(self, course: Course, state: RobotState) -> None:
        """Remember the front half's pose in the phases in which it goes through the corner."""
        if course.phase in (TurnPhase.FRONT_TO_TARGET, TurnPhase.FRONT_ON):
            course.keep(state.rear_clamp, self._pose(state.bends))

    def done(self, course: Course, state: RobotState) -> bool:
        """Whether a robot's phase is done; the last one never is."""
        phase = course.phase
        if phase in CLAMPING:
            away = np.abs(self._bends(course, state) - state.bends)
            return float(away.max()) <= SETTLED or course.since >= DWELL
        if phase is TurnPhase.FRONT_TO_TARGET:
            return self._arm is None or self._arm.reached(state.points[-1], self._arm.target(self._pipe))
        if phase is TurnPhase.FRONT_ON:
            half_way = float(self._plan.line.distance[-1])
            # One end of the middle link may slip past the corner before the other.
            return state.rear_clamp >= half_way or state.front_clamp >= -half_way
        return phase is TurnPhase.REAR_THROUGH and state.rearmost_wheel >= self._plan.edge

    def begin(self, course: Course, phase: TurnPhase, state: RobotState) -> None:
        """Begin a phase; without a policy of the arm, that of bringing the tip to a target is the one after it."""
        course.begin(phase)
        if phase is TurnPhase.FRONT_TO_TARGET:
            course.start = float(state.points[FRONT_MOUNT, 0])
            if self._arm is None:
                course.begin(TurnPhase.FRONT_ON)
        elif phase is TurnPhase.FRONT_ON:
            course.ahead = self._plan.onto_line(state.rear_clamp, self._pose(state.bends), state.tip)

    def forward_signs(self, state: RobotState) -> Floats:
        """Signs of the actions that roll the wheels forwards on the wall that each is nearest to, (wheels,).

        An action assumes that a wheel stands on the outside of its bend. A wheel that is led past the inner edge does
        not.
        """
        wheels, angle = state.wheels, math.pi - self._pipe.angle
        second_leg = np.array([math.cos(angle), math.sin(angle)])
        in_second = wheels[:, 0] + wheels @ second_leg > 0
        offset = np.where(in_second, wheels @ np.array([-second_leg[1], second_leg[0]]), wheels[:, 1])
        return np.where((offset > 0) == (state.bends < 0), 1.0, -1.0)

    def _bends(self, course: Course, state: RobotState) -> Floats:
        """Joint angles in a left turn that belong to the robot's phase, without those that press, (6,) [rad]."""
        plan, phase = self._plan, course.phase
        steep = plan.steep
        clamped = np.array([steep, -2 * steep, steep])
        if phase is TurnPhase.CLAMP_FRONT:
            middle = float(plan.line.bends[-1, 0])
            return np.concatenate([clamped, clamped[::-1]]) + middle * np.array([0, 0, 1, 1, 0, 0])
        if phase is TurnPhase.CLAMP_REAR_AGAIN:
            return np.concatenate([clamped, clamped[::-1]])
        if phase is TurnPhase.REAR_THROUGH:
            # The front's poses from the last to the first, the joints counted from the other end.
            pose = course.front_motion.at(-state.front_clamp - LOOK_AHEAD)
            return np.concatenate([pose[:0:-1], [steep + pose[0]], clamped[1::-1]])
        if phase is TurnPhase.FRONT_ON or self._arm is None:
            pose = (course.ahead or plan.line).at(state.rear_clamp + LOOK_AHEAD)
        else:  # as the arm starts: straight along the axis, where its mount is
            pose = np.array([plan.slant, -plan.slant, 0.0, 0.0])
        return np.concatenate([clamped[:2], [steep + pose[0]], pose[1:]])

    def _pose(self, bends: Floats) -> Floats:
        """Bends as in `Poses`, (4,), of a robot whose rear half clamps."""
        return np.array([bends[2] - self._plan.steep, *bends[HINGES]])
