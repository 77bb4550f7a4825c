"""The stages of a mission, each a decision from a reading to a command: locate a target, reach it, back out again.

Stages know no clock and no arm, so that a replay makes the same decisions again.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.messages import Command, Reading
from pipenav.locating.locator import Exit, LocateConfig
from pipenav.locating.map_locator import MapLocator
from pipenav.motions.follower import Follower
from pipenav.policies.policy import Policy
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome, strongest_outcome
from pipenav.tasks.reach import action as actions
from pipenav.tasks.reach import episode, observation
from pipenav.tasks.reach.observation import Snapshot
from pipenav.tasks.registry import require_reach, task_of

LOCATE_TICKS = 300
"""Number of ticks in which a target must be found: time to go to the corner and back several times."""

HOME_TOLERANCE = 0.25
"""Largest distance of each joint from its start pose that counts as home, as a share of its fastest motion in a
tick."""

USE = "a mission of the arm"
"""Words by which a message names this use of a policy."""

PUSH = 0.01
"""Distance that the slide of a caught arm goes forwards [m]: a slide that pulls presses the shoulder of a
link against the corner's edge, from which the hinges cannot lift it."""


class Decision(NamedTuple):
    """The decision of one tick.

    Attributes:
        stage: `locate`, `reach` or `back`, by hand `person` or `policy`; the outcome where the mission is over.
        command: set-points; None where the mission is over.
        observation, action: what the policy saw and did, (size,), (joints,); None in other stages.
        asked: what a person asked for; None where nobody drives by hand.
        step: by hand, the stage of the policy's mission that drove; empty where the person did.
    """

    stage: str
    command: Command | None
    observation: Floats | None = None
    action: Floats | None = None
    asked: dict[str, Any] | None = None
    step: str = ""


class Locate:
    """Approach I: the arm looks for a target by itself.

    Attributes:
        target: target in the robot's own frame, (2,) [m]; None before one is found.
    """

    def __init__(self, robot: RobotSpec, config: LocateConfig, exit_: Exit) -> None:
        self._locator, self._exit = MapLocator(robot, config, 1), exit_
        self._ticks = 0
        self.target: Floats | None = None

    def decide(self, reading: Reading) -> Decision | str:
        """A command, or the outcome: `located` or `not-located`."""
        if not self._ticks:
            self._locator.start(np.array([0]), reading, self._exit.told)
        decision = self._locator.act(reading)
        self._ticks += 1
        if decision.done[0]:
            self.target = decision.target[0]
            return "located"
        if self._ticks > LOCATE_TICKS:
            return "not-located"
        return Decision("locate", Command("position", decision.set_points))


class Reach:
    """The policy drives the tip to the target, given in the robot's own frame."""

    def __init__(self, policy: Policy, turn_sign: float, target: Floats) -> None:
        self._policy, self._turn_sign = policy, np.array([turn_sign])
        self._target = frames.robot_to_canonical(target, turn_sign)[None]
        self._robot, self._task = policy.header.robot, require_reach(policy.header.task, USE)
        self._before: Snapshot | None = None
        self._action = np.zeros((1, len(self._robot.joints)))
        self._steps = 0

    def decide(self, reading: Reading) -> Decision | str:
        """A command, or the outcome: `reached`, `limit` or `timeout`."""
        now = observation.canonical(self._robot, reading, self._turn_sign)
        tip = kinematics.forward(self._robot, now.q).tip
        holds = {
            Outcome.TIMEOUT: np.array([self._steps >= self._task.max_steps]),
            Outcome.REACHED: np.linalg.norm(tip - self._target, axis=1) <= self._task.reach_tolerance,
            Outcome.LIMIT: episode.at_limit(self._robot, self._task, reading.q),
        }
        outcome = Outcome(strongest_outcome(1, holds)[0])
        if outcome is not Outcome.RUNNING:
            return outcome.label
        before = now if self._before is None else self._before
        unscaled = observation.observe(self._task, now, before, self._action, self._target)
        seen = unscaled / task_of(self._task).observation_scale(self._robot)
        self._action = self._policy.act(seen).astype(float)
        self._before, self._steps = now, self._steps + 1
        command = actions.to_command(self._robot, self._task, self._action, reading.q, self._turn_sign)
        return Decision("reach", command, seen[0], self._action[0])

    def watch(self, reading: Reading, told: Floats) -> None:
        """Take in a tick in which someone else drove: the readings, and the set-points that were sent, (joints,)."""
        self._before = observation.canonical(self._robot, reading, self._turn_sign)
        self._action = actions.of_set_points(self._robot, self._task, told[None], reading.q, self._turn_sign)


class Back:
    """The recorded path backwards (thesis 3.5: the same joint positions, reversed in time), see `Follower`.

    Where the arm is caught, the slide pushes a little before it pulls again.
    """

    def __init__(self, robot: RobotSpec, path: list[Floats], period: float) -> None:
        self._follower, self._path = Follower(robot, 1, period), path[::-1]
        self._follower.start(np.arange(1), [np.array(self._path)])
        self._home = HOME_TOLERANCE * robot.speed_limits * period
        self._steps = 0

    @property
    def left(self) -> list[Floats]:
        """Part of the path that still lies between the arm and its beginning, in the order in which it was taken."""
        return self._path[int(self._follower.rows[0]) :][::-1]

    def decide(self, reading: Reading) -> Decision | str:
        """A command, or the outcome: `home` or `back-timeout`."""
        follower = self._follower
        if follower.at_last[0] and (follower.away(reading.q) <= self._home).all():
            return "home"
        if self._steps >= follower.patience[0]:
            return "back-timeout"
        self._steps += 1
        set_points = follower.act(reading.q)
        if follower.caught[0]:
            set_points[0, 0] = max(set_points[0, 0], reading.q[0, 0] + PUSH)
        return Decision("back", Command("position", set_points))
