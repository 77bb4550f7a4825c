"""`baseline:sequence`: the turning sequence of the thesis's figure 1.2, composed of its parts for a whole robot.

One half of the robot clamps and drives while the other half, unclamped, goes through the corner. A half clamps with its
three wheels on the outer wall and the inner wall alternately, and the bending joint in its middle presses. The front
half is moved by a policy of the arm until its tip has reached a target beyond the corner, then along a line until both
halves can clamp (`baseline:sequence-line` follows the line from the start). The rear half passes as the front half did,
mirrored and reversed in time (approach II, 3.5): in a robot that is the same seen from either end, that is the front's
motion with the joints counted from the other end.
"""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.sequence_arm import HINGES, FrontArm
from pipenav.policies.baselines.sequence_phases import Course, RobotState, TurnPhase
from pipenav.policies.baselines.sequence_plan import CornerPlan, plan
from pipenav.policies.baselines.sequence_turn import SequenceTurn
from pipenav.policies.controller import PrivilegedController
from pipenav.policies.policy import Policy
from pipenav.robots import frames
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.config import TraverseConfig


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
        check_halves(robot)
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
        turn = SequenceTurn(pipe, self._corner(pipe), self._arm)
        if turn.done(course, state):
            turn.begin(course, TurnPhase(course.phase + 1), state)
        course.since += 1
        step = np.clip((turn.goal(course, state) - state.bends) / self.task.alpha, -1.0, 1.0)
        speed = turn.speed(course, state)
        if course.phase is TurnPhase.FRONT_TO_TARGET and self._arm is not None:
            action = self._arm.act(observation, state.points, self._arm.target(pipe), course.start)
            speed, step[HINGES] = action.wheels, action.joints
        turn.keep(course, state)
        return np.concatenate([step, speed * turn.forward_signs(state)])


def check_halves(robot: RobotSpec) -> None:
    """Refuse a robot that is not made of two mirrored halves of three bending joints with a wheel at each.

    Raises:
        PipenavError: the robot is built otherwise.
    """
    lengths = robot.lengths
    halves = len(robot.joints) == len(robot.wheels) == 6 and bool(robot.hinges.all())
    if not (robot.free and halves and np.allclose(lengths, lengths[::-1])):
        raise PipenavError(
            "baseline:sequence drives two mirrored halves of three bending joints with a wheel at each; robot "
            f"{robot.name!r} is built otherwise: choose --robot pirate."
        )
