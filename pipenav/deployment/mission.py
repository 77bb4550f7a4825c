"""A run on one arm as the thesis's figure 5.22 draws it: locate a target, reach it by the policy, back out again.

Pure decisions from readings to commands: they know no clock and no machine, so that a replay makes them again.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.messages import Command, Reading
from pipenav.locating.locator import LocateConfig
from pipenav.locating.map_locator import MapLocator
from pipenav.motions.follower import Follower
from pipenav.policies.policy import Policy
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach import action as actions
from pipenav.tasks.reach import episode, observation
from pipenav.tasks.reach.observation import Snapshot
from pipenav.tasks.registry import require_reach, task_of

LOCATE_TICKS = 300
"""Ticks in which a target must be found: time to go to the corner and back several times."""

HOME_TOLERANCE = 0.25
"""How close to its start pose every joint must come back, as a share of its fastest motion in a tick."""

PUSH = 0.01
"""How far a caught arm's slide goes forwards from where it is [m]: until then it pulls the shoulder of a link against
the corner's edge, from which the hinges cannot lift it."""


class Decision(NamedTuple):
    """What to do in one tick.

    Attributes:
        stage: `locate`, `reach`, `back`, or where the run is over its outcome.
        command: set-points; None where the run is over.
        observation, action: what the policy saw and did, (size,), (joints,); None in other stages.
    """

    stage: str
    command: Command | None
    observation: Floats | None = None
    action: Floats | None = None


class Locate:
    """Approach I: the arm looks for a target by itself.

    Attributes:
        target: in the robot's own frame, (2,) [m]; None before one is found.
    """

    def __init__(self, robot: RobotSpec, config: LocateConfig, turn_sign: float) -> None:
        self._locator, self._turn_sign = MapLocator(robot, config, 1), np.array([turn_sign])
        self._ticks = 0
        self.target: Floats | None = None

    def decide(self, reading: Reading) -> Decision | str:
        """A command, or the outcome: `located` or `not-located`."""
        if not self._ticks:
            self._locator.start(np.array([0]), reading, self._turn_sign)
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
        self._robot, self._task = policy.header.robot, require_reach(policy.header.task, "a run on an arm")
        self._before: Snapshot | None = None
        self._action = np.zeros((1, len(self._robot.joints)))
        self._steps = 0

    def decide(self, reading: Reading) -> Decision | str:
        """A command, or the outcome: `reached`, `limit` or `timeout`."""
        now = observation.canonical(self._robot, reading, self._turn_sign)
        tip = kinematics.forward(self._robot, now.q).tip
        if np.linalg.norm(tip - self._target) <= self._task.reach_tolerance:
            return "reached"
        if episode.at_limit(self._robot, self._task, reading.q)[0]:
            return "limit"
        if self._steps >= self._task.max_steps:
            return "timeout"
        before = now if self._before is None else self._before
        raw = observation.observe(self._task, now, before, self._action, self._target)
        seen = raw / task_of(self._task).observation_scale(self._robot)
        self._action = self._policy.act(seen).astype(float)
        self._before, self._steps = now, self._steps + 1
        command = actions.to_command(self._robot, self._task, self._action, reading.q, self._turn_sign)
        return Decision("reach", command, seen[0], self._action[0])


class Back:
    """The recorded path backwards (thesis 3.5: the same joint positions, reversed in time), see `Follower`; where it is
    caught, the slide pushes a little before it pulls again."""

    def __init__(self, robot: RobotSpec, path: list[Floats], period: float) -> None:
        self._follower = Follower(robot, 1, period)
        self._follower.start(np.arange(1), [np.array(path[::-1])])
        self._home = HOME_TOLERANCE * robot.speed_limits * period
        self._steps = 0

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


class Mission:
    """The stages one after another.

    Attributes:
        target: in the robot's own frame, (2,) [m]; None before one is known.
        outcome: empty while running; `passed` where the arm reached the target and came back.
    """

    def __init__(
        self,
        policy: Policy,
        turn_sign: float,
        period: float,
        target: Floats | None,
        locate: LocateConfig,
        retreat: bool,
    ) -> None:
        """
        Args:
            policy: what reaches the target.
            turn_sign: +1 for a left turn, -1 for a right one.
            period: of a tick [s].
            target: target in the robot's own frame, (2,) [m]; None to look for one.
            locate: how to look for it.
            retreat: whether to back out as well when the target was not found or not reached.
        """
        self._policy, self._turn_sign, self._period = policy, turn_sign, period
        self._robot, self._retreat = policy.header.robot, retreat
        self._path: list[Floats] = []
        self.target, self.outcome, self._failure = target, "", ""
        self._stage: Locate | Reach | Back | None = Locate(self._robot, locate, turn_sign)
        if target is not None:
            self._stage = Reach(policy, turn_sign, target)

    def decide(self, reading: Reading) -> Decision:
        """What to do after this reading."""
        if not isinstance(self._stage, Back):
            self._path.append(reading.q[0].copy())
        while self._stage is not None:
            made = self._stage.decide(reading)
            if isinstance(made, Decision):
                return made
            self._finish(made)
        return Decision(self.outcome, None)

    def back_out(self, why: str) -> bool:
        """Leave what is being done and back out; False where that is not wanted or already under way."""
        if not self._retreat or isinstance(self._stage, Back) or not self._path:
            return False
        self._failure = why
        self._stage = Back(self._robot, self._path, self._period)
        return True

    def _finish(self, ended: str) -> None:
        """Go on to the next stage, or end."""
        if isinstance(self._stage, Back):
            self._stage = None
            self.outcome = ended if ended != "home" else self._failure or "passed"
        elif isinstance(self._stage, Locate) and self._stage.target is not None:
            self.target = self._stage.target
            self._path = self._path[-1:]  # it is back where it started: what it did to look need not be undone
            self._stage = Reach(self._policy, self._turn_sign, self.target)
        elif ended == "reached":
            self._stage = Back(self._robot, self._path, self._period)
        elif not self.back_out(ended):
            self._stage, self.outcome = None, ended


def mission_of(policy: Policy, settings: dict[str, Any]) -> Mission:
    """The run that a header's `run` describes."""
    target = None if settings["goal_m"] is None else np.array(settings["goal_m"], float)
    locate = LocateConfig.model_validate(settings["locate"])
    return Mission(policy, settings["side"], settings["period_s"], target, locate, settings["retreat"])
