"""The steps of the thesis's turning sequence (1.2), each begun by one key, for a whole robot.

(a) unclamp the front, (b) move the front through the corner, (c) clamp the front and unclamp the rear, (d) move the
rear through, (e) clamp the rear. A step goes on until it is done; a person decides when the next one begins. The front
half is never clamped before it has moved on far enough: step (c) moves it on first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.messages import Reading
from pipenav.driving.whereabouts import Whereabouts
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.sequence import check_halves
from pipenav.policies.baselines.sequence_phases import Course, RobotState, TurnPhase
from pipenav.policies.baselines.sequence_plan import plan
from pipenav.policies.baselines.sequence_turn import SequenceTurn
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import forward_directions

STEPS = {
    "a": "unclamp the front",
    "b": "front through the corner",
    "c": "clamp the front, unclamp the rear",
    "d": "rear through the corner",
    "e": "clamp the rear, drive on",
}
"""The steps in their order."""

PHASES = {
    "a": TurnPhase.CLAMP_REAR,
    "b": TurnPhase.FRONT_ON,
    "c": TurnPhase.CLAMP_FRONT,
    "d": TurnPhase.REAR_THROUGH,
    "e": TurnPhase.CLAMP_REAR_AGAIN,
}
"""Phase of the sequence that each step is."""


class StepGoal(NamedTuple):
    """Goal of a step for a control step.

    Attributes:
        set_points: set-points of the joints in the robot's own frame, (6,) [rad].
        wheels: speeds of the wheels, (6,) [rad/s].
        done: whether the step is done.
    """

    set_points: Floats
    wheels: Floats
    done: bool


class StepDriver:
    """Carries out the steps on one robot, by its own sensors and the pipe's drawing.

    Args:
        robot: two mirrored halves of three bending joints with a wheel at each.
        pipe: the corner, as it is drawn.
        tip_gap: distance of the tip before the inner wall's bend at the start, about [m].
        reading: readings at the start, rows of one.

    Attributes:
        step: the step that is under way; empty before the first one.
        refusal: why the last step that was asked for did not begin; empty where it did.

    Raises:
        PipenavError: the robot is built otherwise.
    """

    def __init__(self, robot: RobotSpec, pipe: PipeCorner, tip_gap: float, reading: Reading) -> None:
        check_halves(robot)
        self._robot, self._sign = robot, pipe.turn_sign
        left = pipe.model_copy(update={"turn": "left"})
        self._turn = SequenceTurn(left, plan(robot, left), None)
        self._course = Course()
        self._where = Whereabouts(robot, left, tip_gap, self._canonical(reading).q[0])
        self._state: RobotState | None = None
        self.step, self.refusal = "", ""
        self._moves_on_first = False
        self._limits = np.array([robot.actuators[wheel.actuator].speed_limit for wheel in robot.wheels])

    def see(self, reading: Reading) -> None:
        """Take in the readings after a control period, whoever drove in it; rows of one."""
        self._state = self._where.update(self._canonical(reading))

    def begin(self, step: str) -> None:
        """Begin a step, if it is the next one or the one before; `refusal` says why not."""
        assert self._state is not None, "the robot is seen before it is driven"
        order = "".join(STEPS)
        self.refusal = ""
        if step == self.step:
            return
        at, asked = (order.index(self.step) if self.step else -1), order.index(step)
        if asked > at + 1:
            self.refusal = f"({step}) comes after ({order[at + 1]})"
            return
        if asked < at:
            self.refusal = f"({step}) is behind: after ({self.step}) comes ({order[min(at + 1, len(order) - 1)]})"
            return
        if step == "d" and not self.done:
            self.refusal = "the front has not clamped yet: (d) comes when (c) is done"
            return
        self.step = step
        self._moves_on_first = step == "c" and not self.done
        if not self._moves_on_first:
            self._enter(PHASES[step], self._state)

    def _enter(self, phase: TurnPhase, state: RobotState) -> None:
        self._turn.begin(self._course, phase, state)
        if phase is TurnPhase.REAR_THROUGH:
            self._where.clamp_front(state)

    @property
    def tip(self) -> float:
        """Distance of the tip along the pipe from the corner, after `see` [m]."""
        assert self._state is not None, "the robot is seen before it is driven"
        return self._state.tip

    @property
    def rear(self) -> float:
        """Distance of the rear end along the pipe from the corner, after `see` [m]."""
        assert self._state is not None, "the robot is seen before it is driven"
        return float(self._state.distances[0])

    @property
    def done(self) -> bool:
        """Whether the step that is under way is done."""
        return self._state is not None and bool(self.step) and self._turn.done(self._course, self._state)

    def goal(self) -> StepGoal:
        """The step's goal for this control step, after `see`."""
        assert self._state is not None, "the robot is seen before it is driven"
        state, course = self._state, self._course
        if self._moves_on_first and self.done:
            self._moves_on_first = False
            self._enter(TurnPhase.CLAMP_FRONT, state)
        course.since += 1
        goal = self._turn.goal(course, state)
        speed = self._turn.speed(course, state)
        self._turn.keep(course, state)
        stands = self.done and not self._moves_on_first and self.step in "bd"
        share = 0.0 if stands else speed
        forwards = forward_directions(state.bends[None])[0] * self._turn.forward_signs(state)
        wheels = share * self._limits * forwards * self._sign
        return StepGoal(goal * self._sign, wheels, self.done and not self._moves_on_first)

    def _canonical(self, reading: Reading) -> Reading:
        """Readings as in a left turn."""
        if self._sign > 0:
            return reading
        speeds = reading.wheel_speeds
        return reading._replace(
            q=-reading.q, ranges=reading.ranges[:, ::-1], wheel_speeds=None if speeds is None else -speeds
        )
