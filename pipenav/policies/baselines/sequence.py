"""`baseline:sequence`: the turning sequence of the thesis's figure 1.2, composed of its parts for a whole robot.

One half of the robot clamps and drives while the other one, unclamped, goes through the corner. A half clamps with its
three wheels, by turns on the outer and the inner wall, and the bending joint between them presses. The front half is
moved by a policy of the arm until its tip has reached a target beyond the corner, then along a line until both halves
can clamp (`baseline:sequence-line` follows the line from the start). The rear half passes as the front half did,
mirrored and reversed in time (approach II, 3.5): in a robot that is the same seen from either end, that is the front's
motion with the joints counted from the other end.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.sequence_arm import HINGES, FrontArm
from pipenav.policies.baselines.sequence_plan import PRESS, CornerPlan, Poses, plan
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
"""How far ahead of the clamp the moving half's set-points are [m]: it lags behind them by about as much."""

SETTLED = 0.15
"""How near to its set-point every joint is when a clamp counts as closed [rad]."""

DWELL = 30
"""Control steps after which a clamp that has not closed has to do: a wheel may stand on a wall before its bend ends."""

APART = 0.001
"""Way between poses that are kept of the front half's motion [m]."""

REAR, FRONT = 1, 4
"""The joint in the middle of either half, which presses."""


class TurnPhase(IntEnum):
    """What a robot is doing; the letters are those of the thesis (1.2)."""

    CLAMP_REAR = 0
    """The rear half clamps, the front half stretches: (a)."""
    FRONT_TO_TARGET = 1
    """The rear half drives, the arm's policy brings the tip to a target beyond the corner: (b)."""
    FRONT_ON = 2
    """The rear half drives on, the front half follows the line, until the middle link spans the corner: (b)."""
    CLAMP_FRONT = 3
    """The front half clamps too: (c)."""
    REAR_THROUGH = 4
    """The rear half unclamps, the front half drives and draws it through: (c), (d)."""
    CLAMP_REAR_AGAIN = 5
    """All wheels are past the corner: the rear half clamps and all of them drive: (e)."""


PRESSING = {
    TurnPhase.CLAMP_REAR: [REAR],
    TurnPhase.FRONT_TO_TARGET: [REAR],
    TurnPhase.FRONT_ON: [REAR],
    TurnPhase.CLAMP_FRONT: [REAR, FRONT],
    TurnPhase.REAR_THROUGH: [FRONT],
    TurnPhase.CLAMP_REAR_AGAIN: [REAR, FRONT],
}
"""The joints that press."""

CLAMPING = (TurnPhase.CLAMP_REAR, TurnPhase.CLAMP_FRONT)
"""In these the wheels stand."""


class _Course:
    """One robot in one episode: its phase, since when, and what it keeps for later.

    Attributes:
        phase: what it is doing.
        since: control steps of this phase.
        start: where the front half's first joint was when the policy took over [m].
        ahead: the poses of the front half's way on along the line.
        rows: the front half's motion so far: where the rear clamp's foremost wheel was, and `Poses.bends` there.
    """

    def __init__(self) -> None:
        self.phase, self.since, self.start = TurnPhase.CLAMP_REAR, 0, 0.0
        self.ahead: Poses | None = None
        self.rows: list[Floats] = []

    def begin(self, phase: TurnPhase) -> None:
        self.phase, self.since = phase, 0

    def keep(self, along: float, bends: Floats) -> None:
        if not self.rows or along >= self.rows[-1][0] + APART:
            self.rows.append(np.array([along, *bends]))

    @property
    def front_motion(self) -> Poses:
        rows = np.array(self.rows)
        return Poses(rows[:, 0], rows[:, 1:])


class SequenceController(PrivilegedController[TraverseBatch]):
    """The turning sequence, each robot in its own phase.

    Args:
        robot: two mirrored halves of three bending joints with a wheel at each.
        arm: a policy that brings an arm's tip to a target; None to lead the front half along a line all the way.
        task: the whole robot's.

    Raises:
        PipenavError: another robot, or a policy that cannot move its front half.
    """

    batch_type = TraverseBatch
    only = "baseline:sequence turns corners in one plane: choose a single corner, as d=90,angle=90."

    def __init__(self, robot: RobotSpec, arm: Policy | None, task: TraverseConfig | None = None) -> None:
        _check_robot(robot)
        self.robot, self.task = robot, task or TraverseConfig(kind="traverse")
        self._arm = None if arm is None else FrontArm(robot, self.task, arm)
        self._courses: list[_Course] = []
        self._corners: dict[PipeCorner, CornerPlan] = {}

    @property
    def phases(self) -> list[TurnPhase]:
        """What each robot is doing."""
        return [course.phase for course in self._courses]

    def act(self, observation: Floats, batch: TraverseBatch) -> Floats:
        """Canonical actions in [-1, 1], (n, actuators).

        Raises:
            PipenavError: a pipe is a run of several corners, or leaves the plane.
        """
        if len(self._courses) != batch.n:
            self._courses = [_Course() for _ in range(batch.n)]
        points, along = batch.points, batch.distances
        actions = np.zeros((batch.n, len(self.robot.driven_actuators)))
        for i, given in enumerate(batch.pipes):
            if given is None:
                continue
            pipe = given.require_corner()
            if batch.steps[i] == 0:
                self._courses[i] = _Course()
            bends = batch.q[i, -len(self.robot.joints) :] * pipe.turn_sign
            place = frames.robot_to_canonical(points[i], pipe.turn_sign)
            actions[i] = self._drive(self._courses[i], pipe, observation[i], bends, place, along[i])
        return actions

    def _corner(self, pipe: PipeCorner) -> CornerPlan:
        left = pipe.model_copy(update={"turn": "left"})
        if left not in self._corners:
            self._corners[left] = plan(self.robot, left)
        return self._corners[left]

    def _drive(
        self, course: _Course, pipe: PipeCorner, observation: Floats, bends: Floats, points: Floats, along: Floats
    ) -> Floats:
        """One robot's action, (actuators,), after it has gone on to its next phase where it is ready to.

        Args:
            course: the robot's.
            pipe: its pipe.
            observation: scaled, (size,).
            bends: joint angles in a left turn, (joints,) [rad].
            points: rear end, joints and tip in a left turn, (links + 1, 2) [m].
            along: where they are along the pipe, (links + 1,) [m].
        """
        corner = self._corner(pipe)
        self._go_on(course, corner, pipe, bends, points, along)
        course.since += 1
        away, press = self._set_points(course, corner, along) - bends, np.zeros(len(bends))
        press[PRESSING[course.phase]] = PRESS
        step = np.clip((away - press) / self.task.alpha, -1.0, 1.0)
        speed = SPEED * max(0.0, 1.0 - float(np.abs(away[press == 0]).max()) / LAG)
        if course.phase in CLAMPING:
            speed = 0.0
        if course.phase is TurnPhase.FRONT_TO_TARGET and self._arm is not None:
            speed, *step[HINGES] = self._arm.act(observation, points, self._arm.target(pipe), course.start)
        if course.phase in (TurnPhase.FRONT_TO_TARGET, TurnPhase.FRONT_ON):
            course.keep(float(along[3]), _pose(corner, bends))
        return np.concatenate([step, speed * _forwards(pipe, bends, points[1:-1])])

    def _go_on(
        self, course: _Course, corner: CornerPlan, pipe: PipeCorner, bends: Floats, points: Floats, along: Floats
    ) -> None:
        """Begin the next phase where this one is done."""
        phase = course.phase
        if phase in CLAMPING:
            away = np.abs(self._set_points(course, corner, along) - bends)
            done = float(away.max()) <= SETTLED or course.since >= DWELL
        elif phase is TurnPhase.FRONT_TO_TARGET:
            done = self._arm is None or self._arm.reached(points[-1], self._arm.target(pipe))
        elif phase is TurnPhase.FRONT_ON:
            half_way = corner.line.along[-1]  # one end of the middle link may slip past the corner before the other
            done = along[3] >= half_way or along[4] >= -half_way
        else:
            done = phase is TurnPhase.REAR_THROUGH and along[1] >= corner.edge
        if done:
            course.begin(TurnPhase(phase + 1))
            if course.phase is TurnPhase.FRONT_TO_TARGET:
                course.start = float(points[4, 0])
                if self._arm is None:
                    course.begin(TurnPhase.FRONT_ON)
            elif course.phase is TurnPhase.FRONT_ON:
                course.ahead = corner.onto_line(float(along[3]), _pose(corner, bends), float(along[-1]))

    def _set_points(self, course: _Course, corner: CornerPlan, along: Floats) -> Floats:
        """Joint angles that a robot in this phase shall have in a left turn, (6,) [rad]."""
        steep, phase = corner.steep, course.phase
        clamped = np.array([steep, -2 * steep, steep])
        if phase is TurnPhase.CLAMP_FRONT:
            middle = float(corner.line.bends[-1, 0])
            return np.concatenate([clamped, clamped[::-1]]) + middle * np.array([0, 0, 1, 1, 0, 0])
        if phase is TurnPhase.CLAMP_REAR_AGAIN:
            return np.concatenate([clamped, clamped[::-1]])
        if phase is TurnPhase.REAR_THROUGH:
            # The front's poses from the last to the first, the joints counted from the other end.
            middle, *moving = course.front_motion.at(-float(along[4]) - LOOK_AHEAD)
            return np.array([*moving[::-1], steep + middle, *clamped[1::-1]])
        if phase is TurnPhase.FRONT_ON or self._arm is None:
            middle, *moving = (course.ahead or corner.line).at(float(along[3]) + LOOK_AHEAD)
        else:  # as the arm starts: straight along the axis, where its mount is
            middle, *moving = corner.slant, -corner.slant, 0.0, 0.0
        return np.array([*clamped[:2], steep + middle, *moving])


def _forwards(pipe: PipeCorner, bends: Floats, wheels: Floats) -> Floats:
    """Which actions roll the wheels forwards on the wall that each is nearest to, +1 or -1, (wheels,).

    An action takes a wheel for standing on the outside of its bend. One that is led past the inner edge is not.

    Args:
        pipe: the pipe.
        bends: joint angles in a left turn, (joints,) [rad].
        wheels: where they are in a left turn, (wheels, 2) [m].
    """
    along = np.array([math.cos(math.pi - pipe.angle), math.sin(math.pi - pipe.angle)])
    second = wheels[:, 0] + wheels @ along > 0
    offset = np.where(second, wheels @ np.array([-along[1], along[0]]), wheels[:, 1])
    return np.where((offset > 0) == (bends < 0), 1.0, -1.0)


def _pose(corner: CornerPlan, bends: Floats) -> Floats:
    """As `Poses.bends`, (4,), of a robot whose rear half clamps."""
    return np.array([bends[2] - corner.steep, *bends[HINGES]])


def _check_robot(robot: RobotSpec) -> None:
    lengths = robot.lengths
    halves = len(robot.joints) == len(robot.wheels) == 6 and bool(robot.hinges.all())
    if not (robot.free and halves and np.allclose(lengths, lengths[::-1])):
        raise PipenavError(
            "baseline:sequence drives two mirrored halves of three bending joints with a wheel at each; robot "
            f"{robot.name!r} is built otherwise: choose --robot pirate."
        )
