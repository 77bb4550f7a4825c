"""The door between those who drive and the robot: whoever drives, and whenever they change, set-points never jump."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.messages import Reading
from pipenav.driving.ask import NOTHING, PERSON, POLICY, Ask, Operator, Seen
from pipenav.driving.primitives import AS_STEPS, DIRECTIONS, FRONT_FIRST, NO_ROLL, ROLL, Clamped
from pipenav.driving.route_steps import CornerRow, RouteSteps
from pipenav.driving.slew import Slew, SlewLimits
from pipenav.driving.steps import STEPS
from pipenav.driving.tip import TipDriver
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.clamp import forward_directions

TURNING_LEASH, SLIDING_LEASH = 0.25, 0.025
"""Largest distance of a person's set-point from its joint [rad, m]: enough for its full effort, little to spring back
from."""

STEPS_ONLY = "steps are for a whole robot in a pipe of corners alone"
"""Why a step that was asked for did not begin."""


class Scene(NamedTuple):
    """Knowledge at the start of an episode: the pipe as it is drawn, and about where the robot lies.

    Attributes:
        pipe: the pipe as a single corner; None where it is none.
        tip_gap: distance of the tip before the inner wall's bend, about [m].
        target: target of the tip in the robot's own frame, (2,) [m]; None where there is none.
        row: the pipe's corners one after another, if it is no more than that; None where it is something else.
    """

    pipe: PipeCorner | None
    tip_gap: float
    target: Floats | None
    row: CornerRow | None = None


class Door:
    """The door of a robot.

    Args:
        robot: the robot.
        operator: who drives it; None for the policy alone.
        has_policy: whether a policy drives while the operator does not.

    Attributes:
        robot: the robot.
        who: who drove the last control step, `person` or `policy`.
        asked: what was asked for in it.
        takeovers: how often the person took over from the policy in this episode.
        said: what the screen says about it.
    """

    def __init__(self, robot: RobotSpec, operator: Operator | None, has_policy: bool) -> None:
        self.robot, self._operator, self._has_policy = robot, operator, has_policy
        self._joints = len(robot.joints)
        self._slew = Slew(SlewLimits.of(robot), self._joints)
        self._leash = np.where(robot.hinges, TURNING_LEASH, SLIDING_LEASH)
        self._names = [joint.name for joint in robot.joints]
        self._roll_name = "" if robot.roll is None else robot.roll.joint.name
        self._wheels = SlewLimits.of(robot).upper[self._joints :]
        self._steps: RouteSteps | None = None
        self._clamped: Clamped | None = None
        self._tip: TipDriver | None = None
        self._steering = False
        self._under_way = ""  # the step or primitive that goes on by itself
        self._tick = 0
        self._scene = Scene(None, 0.0, None)
        self.who, self.asked, self.takeovers, self.said = PERSON, NOTHING, 0, ""

    @property
    def command(self) -> Floats:
        """The last command, (actuators,)."""
        return self._slew.last.copy()

    @property
    def told(self) -> Floats:
        """Everything that the robot was told last, (k,)."""
        return self.command

    @property
    def limits(self) -> Floats:
        """Largest change of everything that it is told, in a control step, (k,)."""
        return SlewLimits.of(self.robot).step

    @property
    def scenery(self) -> str:
        """Words for how the robot lies; empty where all of it lies in one plane."""
        return ""

    @property
    def in_space(self) -> dict[str, Any]:
        """Part of a control step's record that there is in space alone."""
        return {}

    @property
    def step_done(self) -> bool:
        """Whether the step that is under way is done, or the roll."""
        return self._steps is not None and self._under_way in STEPS and self._steps.done

    @property
    def step(self) -> str:
        """The step or primitive that is under way; empty where none is."""
        return self._under_way

    def start(self, reading: Reading, scene: Scene) -> None:
        """Begin an episode; readings are rows of one."""
        self._slew.start(reading.q[0])
        self._scene = scene
        self._steps = self._tip = self._clamped = None
        if self.robot.free and scene.row is not None:
            self._steps = RouteSteps(self.robot, scene.row, scene.tip_gap, reading, self._turn_sign)
            self._clamped = Clamped(self.robot, self._steps.pipe.radius)
        if not self.robot.free:
            self._tip = TipDriver(self.robot, reading.q[0])
        self._steering, self._under_way = False, ""
        self._tick = 0
        self.who = POLICY if self._has_policy else PERSON
        self.asked, self.takeovers, self.said = NOTHING, 0, ""

    def next(self, reading: Reading, policy: Callable[[], Floats] | None) -> Floats:
        """The command of the next control step, (actuators,).

        Args:
            reading: readings of the robot's sensors, rows of one.
            policy: gives what the policy commands, (actuators,), if it is to drive; None without one.

        Raises:
            OperatorLost: the person's device is gone.
        """
        self._see(reading)
        asked = NOTHING if self._operator is None else self._operator.ask(self._seen(reading))
        self.asked = asked
        self._tick += 1
        if policy is not None and not asked.active:
            if self.who == PERSON:
                self._slew.hand_over()
            self.who, self._steering, self._under_way = POLICY, False, ""
            return self._slew.policy(policy())
        if self.who == POLICY:
            self.takeovers += 1
        self.who = PERSON
        return self._by_hand(asked, reading)

    def _turn_sign(self, corner: int) -> float:
        """+1 where a corner turns to the robot's left, -1 where it turns to its right."""
        assert self._scene.row is not None
        return self._scene.row.corners[corner].turn_sign

    def _see(self, reading: Reading) -> None:
        """Take in the readings after a control period, whoever drove in it."""
        if self._steps is not None:
            self._steps.see(reading)

    def _seen(self, reading: Reading) -> Seen:
        scene = self._scene
        return Seen(self._tick, reading, self.step, self.step_done, scene.target, scene.pipe, scene.tip_gap, self.who)

    def _by_hand(self, asked: Ask, reading: Reading) -> Floats:
        """The person's command for a control step, (actuators,)."""
        if asked.step:
            self.said = ""
            self._begin(asked.step, reading)
        by_joint = bool(asked.joints or asked.positions or asked.wheels)
        if asked.quiet or by_joint or asked.tip is not None:
            self._under_way = ""
        if asked.tip is not None and self._tip is not None:
            return self._steered(asked.tip, reading)
        self._steering = False
        goals = self._goal(reading)
        if goals is None:
            return self._joint_by_joint(asked, reading)
        goals[: self._joints] = self._leashed(goals[: self._joints], reading)
        return self._slew.person(goals)

    def _goal(self, reading: Reading) -> Floats | None:
        """Goal of the step or primitive under way, (actuators,); None where none is."""
        if self._under_way in STEPS and self._steps is not None:
            goal = self._steps.goal()
            return np.concatenate([goal.set_points, goal.wheels])
        if self._under_way and self._clamped is not None:
            return self._clamped.goal(reading)
        return None

    def _begin(self, name: str, reading: Reading) -> None:
        """Begin a step or a primitive, or say why not."""
        if self._steps is None or self._clamped is None:
            self.said = STEPS_ONLY
        elif name == ROLL:
            self._begin_roll(reading)
        elif name in DIRECTIONS:
            if self._steps.step == "b" and not self._steps.done:
                self.said = FRONT_FIRST
                return
            self._clamped.begin(name, reading, self._slew.last[: self._joints])
            self._under_way = name
        else:
            self._steps.begin(AS_STEPS.get(name, name))
            self.said = self._steps.refusal
            if not self.said:
                self._under_way = self._steps.step

    def _begin_roll(self, reading: Reading) -> None:  # noqa: ARG002  # a door in space looks at it
        """Begin to roll, or say why not."""
        self.said = NO_ROLL

    def _joint_by_joint(self, asked: Ask, reading: Reading) -> Floats:
        goal, speed = self._slew.last.copy(), np.ones(self._joints)
        if self._roll_name in asked.joints:
            self._turn_roll_joint(asked.joints[self._roll_name])
        turned = {name: share for name, share in asked.joints.items() if name != self._roll_name}
        for name, share in turned.items():
            i = self._names.index(name)
            goal[i] = np.inf if share > 0 else -np.inf
            speed[i] = min(abs(share), 1.0)
        for name, position in asked.positions.items():
            goal[self._names.index(name)] = position
        moved = [*turned, *asked.positions]
        leashed = self._leashed(goal[: self._joints], reading)
        for name in moved:
            i = self._names.index(name)
            goal[i] = leashed[i]
        if len(self._wheels):
            forwards = forward_directions(reading.q)[0]
            goal[self._joints :] = np.clip(asked.wheels, -1.0, 1.0) * self._wheels * forwards
        return self._slew.person(goal, speed)

    def _turn_roll_joint(self, share: float) -> None:  # noqa: ARG002  # a door in space does
        """Turn the roll joint at a share of its fastest speed, or say why not."""
        self.said = NO_ROLL

    def _steered(self, tip: tuple[float, float], reading: Reading) -> Floats:
        assert self._tip is not None
        before = self._slew.last[: self._joints]
        if not self._steering:
            self._tip.restart(before)
            self._steering = True
        lag = float((np.abs(before - reading.q[0]) / self._leash).max())
        share = max(0.0, 1.0 - lag) if tip[0] >= 0 else 1.0
        heading = float(kinematics.forward(self.robot, reading.q).headings[0, -1])
        goal = self._tip.move(tip[0] * share, tip[1] * share, heading)
        return self._slew.person(np.concatenate([goal, self._slew.last[self._joints :]]))

    def _leashed(self, goal: Floats, reading: Reading) -> Floats:
        return np.clip(goal, reading.q[0] - self._leash, reading.q[0] + self._leash)
