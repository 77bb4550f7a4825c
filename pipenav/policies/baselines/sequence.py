"""`baseline:sequence`: the turning sequence of the thesis's figure 1.2, composed of its parts for a whole robot.

One half of the robot clamps and drives while the other half, unclamped, goes through the corner. A half clamps with its
three wheels on the outer wall and the inner wall alternately, and the bending joint in its middle presses. The front
half is moved by a policy of the arm until its tip has reached a target beyond the corner, then along a line until both
halves can clamp (`baseline:sequence-line` follows the line from the start). The rear half passes as the front half did,
mirrored and reversed in time (approach II, 3.5): in a robot that is the same seen from either end, that is the front's
motion with the joints counted from the other end.
"""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.sequence_arm import FRONT_MOUNT, HINGES, FrontArm
from pipenav.policies.baselines.sequence_phases import CLAMPING, PRESSING, Course, RobotState, TurnPhase
from pipenav.policies.baselines.sequence_plan import PRESS, CornerPlan, plan
from pipenav.policies.controller import PrivilegedController
from pipenav.policies.policy import Policy
from pipenav.robots import frames
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.config import TraverseConfig

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


class SequenceController(PrivilegedController[TraverseBatch]):
    """The turning sequence, each robot in its own phase.

    Args:
        robot: two mirrored halves of three bending joints with a wheel at each.
        arm: a policy that brings an arm's tip to a target; None to lead the front half along a line all the way.
        task: settings of the whole robot's task.

    Raises:
        PipenavError: the robot is another one, or the policy cannot move its front half.
    """

    batch_type = TraverseBatch
    refusal = "baseline:sequence turns corners in one plane: choose a single corner, such as d=90,angle=90."

    def __init__(self, robot: RobotSpec, arm: Policy | None, task: TraverseConfig | None = None) -> None:
        _check_robot(robot)
        self.robot, self.task = robot, task or TraverseConfig(kind="traverse")
        self._arm = None if arm is None else FrontArm(robot, self.task, arm)
        self._courses: list[Course] = []
        self._plans: dict[PipeCorner, CornerPlan] = {}

    @property
    def phases(self) -> list[TurnPhase]:
        """Phase of each robot."""
        return [course.phase for course in self._courses]

    def act(self, observation: Floats, batch: TraverseBatch) -> Floats:
        """Canonical actions in [-1, 1], (n, actuators).

        Raises:
            PipenavError: a pipe is a route of several corners, or leaves the plane.
        """
        if len(self._courses) != batch.n:
            self._courses = [Course() for _ in range(batch.n)]
        q, points, distances = batch.q, batch.points, batch.distances
        actions = np.zeros((batch.n, len(self.robot.driven_actuators)))
        for i, given in enumerate(batch.pipes):
            if given is None:
                continue
            pipe = given.require_corner()
            if batch.steps[i] == 0:
                self._courses[i] = Course()
            bends = q[i, -len(self.robot.joints) :] * pipe.turn_sign
            state = RobotState(bends, frames.robot_to_canonical(points[i], pipe.turn_sign), distances[i])
            actions[i] = self._action(self._courses[i], pipe, observation[i], state)
        return actions

    def _corner(self, pipe: PipeCorner) -> CornerPlan:
        left = pipe.model_copy(update={"turn": "left"})
        if left not in self._plans:
            self._plans[left] = plan(self.robot, left)
        return self._plans[left]

    def _action(self, course: Course, pipe: PipeCorner, observation: Floats, state: RobotState) -> Floats:
        """Action of one robot, (actuators,), after it has begun its next phase where it is ready to.

        Args:
            course: memory of the robot.
            pipe: the pipe that the robot is in.
            observation: scaled observation, (size,).
            state: pose of the robot.
        """
        corner = self._corner(pipe)
        if self._phase_done(course, corner, pipe, state):
            self._begin_next_phase(course, corner, state)
        course.since += 1
        away, press = self._set_points(course, corner, state) - state.bends, np.zeros(len(state.bends))
        press[PRESSING[course.phase]] = PRESS
        step = np.clip((away - press) / self.task.alpha, -1.0, 1.0)
        speed = SPEED * max(0.0, 1.0 - float(np.abs(away[press == 0]).max()) / LAG)
        if course.phase in CLAMPING:
            speed = 0.0
        if course.phase is TurnPhase.FRONT_TO_TARGET and self._arm is not None:
            action = self._arm.act(observation, state.points, self._arm.target(pipe), course.start)
            speed, step[HINGES] = action.wheels, action.joints
        if course.phase in (TurnPhase.FRONT_TO_TARGET, TurnPhase.FRONT_ON):
            course.keep(state.rear_clamp, _pose(corner, state.bends))
        return np.concatenate([step, speed * _forward_signs(pipe, state)])

    def _phase_done(self, course: Course, corner: CornerPlan, pipe: PipeCorner, state: RobotState) -> bool:
        phase = course.phase
        if phase in CLAMPING:
            away = np.abs(self._set_points(course, corner, state) - state.bends)
            return float(away.max()) <= SETTLED or course.since >= DWELL
        if phase is TurnPhase.FRONT_TO_TARGET:
            return self._arm is None or self._arm.reached(state.points[-1], self._arm.target(pipe))
        if phase is TurnPhase.FRONT_ON:
            half_way = float(corner.line.distance[-1])
            # One end of the middle link may slip past the corner before the other.
            return state.rear_clamp >= half_way or state.front_clamp >= -half_way
        return phase is TurnPhase.REAR_THROUGH and state.rearmost_wheel >= corner.edge

    def _begin_next_phase(self, course: Course, corner: CornerPlan, state: RobotState) -> None:
        course.begin(TurnPhase(course.phase + 1))
        if course.phase is TurnPhase.FRONT_TO_TARGET:
            course.start = float(state.points[FRONT_MOUNT, 0])
            if self._arm is None:
                course.begin(TurnPhase.FRONT_ON)
        elif course.phase is TurnPhase.FRONT_ON:
            course.ahead = corner.onto_line(state.rear_clamp, _pose(corner, state.bends), state.tip)

    def _set_points(self, course: Course, corner: CornerPlan, state: RobotState) -> Floats:
        """Joint angles in a left turn that belong to the robot's phase, without those that press, (6,) [rad]."""
        steep, phase = corner.steep, course.phase
        clamped = np.array([steep, -2 * steep, steep])
        if phase is TurnPhase.CLAMP_FRONT:
            middle = float(corner.line.bends[-1, 0])
            return np.concatenate([clamped, clamped[::-1]]) + middle * np.array([0, 0, 1, 1, 0, 0])
        if phase is TurnPhase.CLAMP_REAR_AGAIN:
            return np.concatenate([clamped, clamped[::-1]])
        if phase is TurnPhase.REAR_THROUGH:
            # The front's poses from the last to the first, the joints counted from the other end.
            pose = course.front_motion.at(-state.front_clamp - LOOK_AHEAD)
            return np.concatenate([pose[:0:-1], [steep + pose[0]], clamped[1::-1]])
        if phase is TurnPhase.FRONT_ON or self._arm is None:
            pose = (course.ahead or corner.line).at(state.rear_clamp + LOOK_AHEAD)
        else:  # as the arm starts: straight along the axis, where its mount is
            pose = np.array([corner.slant, -corner.slant, 0.0, 0.0])
        return np.concatenate([clamped[:2], [steep + pose[0]], pose[1:]])


def _forward_signs(pipe: PipeCorner, state: RobotState) -> Floats:
    """Signs of the actions that roll the wheels forwards on the wall that each is nearest to, (wheels,).

    An action assumes that a wheel stands on the outside of its bend. A wheel that is led past the inner edge does not.
    """
    wheels = state.wheels
    second_leg = np.array([math.cos(math.pi - pipe.angle), math.sin(math.pi - pipe.angle)])
    in_second = wheels[:, 0] + wheels @ second_leg > 0
    offset = np.where(in_second, wheels @ np.array([-second_leg[1], second_leg[0]]), wheels[:, 1])
    return np.where((offset > 0) == (state.bends < 0), 1.0, -1.0)


def _pose(corner: CornerPlan, bends: Floats) -> Floats:
    """Bends as in `Poses`, (4,), of a robot whose rear half clamps."""
    return np.array([bends[2] - corner.steep, *bends[HINGES]])


def _check_robot(robot: RobotSpec) -> None:
    lengths = robot.lengths
    halves = len(robot.joints) == len(robot.wheels) == 6 and bool(robot.hinges.all())
    if not (robot.free and halves and np.allclose(lengths, lengths[::-1])):
        raise PipenavError(
            "baseline:sequence drives two mirrored halves of three bending joints with a wheel at each; robot "
            f"{robot.name!r} is built otherwise: choose --robot pirate."
        )
