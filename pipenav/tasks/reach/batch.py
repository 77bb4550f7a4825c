"""The reach task on n robots of one backend at once: the core that every adapter wraps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Truth
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.batch import Sized, StepResult
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach import action as actions
from pipenav.tasks.reach import episode, observation, reward
from pipenav.tasks.reach.config import TaskConfig
from pipenav.tasks.reach.episode import Episodes

EpisodeSource = Callable[[Ints], Episodes]
"""Given the robots that start anew, their next episodes."""


class ReachBatch(Sized):
    """n episodes of the corner task, stepped together. Who calls `step` also says, by `reset`, who starts anew.

    Raises:
        PipenavError: a robot that hangs on no mount.
    """

    def __init__(self, robot: RobotSpec, config: TaskConfig, backend: Simulator, n: int, source: EpisodeSource) -> None:
        episode.check_robot(robot)
        self.robot, self.config, self.n = robot, config, n
        self._backend, self._source = backend, source
        self._scale = observation.scale_of(robot, config)
        joints = len(robot.joints)
        self.pipes: list[PipeCorner | None] = [None] * n
        self.steps, self._ages = np.zeros(n, int), np.zeros(n, int)
        self._turn_sign, self._goal, self._edge = np.ones(n), np.zeros((n, 2)), np.zeros((n, 2))
        self._way = np.zeros(n)
        self._action, self._own_q = np.zeros((n, joints)), np.zeros((n, joints))
        self._observation = np.zeros((n, len(self._scale)))
        self._now = self._before = observation.Snapshot(
            np.zeros((n, joints)),
            np.zeros((n, joints)),
            np.zeros((n, robot.laser.beams)),
            np.zeros((n, 2)),
            np.zeros(n),
        )

    @property
    def target(self) -> Floats:
        """Targets in the canonical frame, (n, 2) [m]."""
        return self._goal.copy()

    @property
    def edge(self) -> Floats:
        """Where the inner wall starts to bend, in the canonical frame, (n, 2) [m]."""
        return self._edge.copy()

    @property
    def q(self) -> Floats:
        """Joint positions in the robot's own frame, (n, joints)."""
        return self._own_q.copy()

    @property
    def snapshot(self) -> observation.Snapshot:
        """This step's readings in the canonical frame."""
        return self._now

    def reset(self, indices: Ints | None = None) -> Floats:
        """Start new episodes for some robots (sorted, unique), or all; observations of all robots, (n, size)."""
        indices = np.arange(self.n) if indices is None else np.asarray(indices, np.intp)
        episodes = self._source(indices)
        reading = self._backend.reset(indices, episodes.pipes, episodes.q, episodes.base)
        for i, pipe in zip(indices, episodes.pipes, strict=True):
            self.pipes[i] = pipe
        self.steps[indices] = self._ages[indices]
        self._ages[indices] = 0
        self._turn_sign[indices], self._goal[indices], self._edge[indices] = (
            episodes.turn_sign,
            episodes.target,
            episodes.edge,
        )
        self._action[indices], self._own_q[indices] = 0.0, reading.q
        now = observation.canonical(self.robot, reading, episodes.turn_sign)
        self._now.put(indices, now)
        self._before.put(indices, now)
        self._way[indices] = episode.distance_to_target(now.tip, episodes.target, episodes.edge)
        observed = observation.observe(self.config, now, now, self._action[indices], episodes.target)
        self._observation = self._observation.copy()
        self._observation[indices] = observed / self._scale
        return self._observation

    def stagger(self, rng: np.random.Generator) -> None:
        """Make the next episodes start at random ages, so that their time-outs do not all fall into one step."""
        self._ages = rng.integers(0, self.config.max_steps // 2, self.n)

    def step(self, action: Floats) -> StepResult:
        """One control step of every robot.

        Args:
            action: canonical actions in [-1, 1], (n, joints).
        """
        command = actions.to_command(self.robot, self.config, action, self._own_q, self._turn_sign)
        self._backend.step(command)
        self.steps += 1
        self._before, self._action = self._now, np.clip(action, -1.0, 1.0)
        reading = self._backend.read()
        self._own_q, self._now = reading.q, observation.canonical(self.robot, reading, self._turn_sign)
        truth = self._backend.truth()
        facts, outcome = self._judge(truth)
        result = reward.total(self.config.reward, facts)
        observed = observation.observe(self.config, self._now, self._before, self._action, self._goal)
        self._observation = observed / self._scale
        cut_off = outcome == Outcome.TIMEOUT.value
        return StepResult(self._observation, result, outcome, self._now.ranges.min(axis=1), truth, cut_off)

    def close(self) -> None:
        self._backend.close()

    def _judge(self, truth: Truth) -> tuple[reward.StepFacts, NDArray[np.int8]]:
        way = episode.distance_to_target(self._now.tip, self._goal, self._edge)
        progress, self._way = self._way - way, way
        error = np.hypot(*(self._now.tip - self._goal).T)
        failed_at_limit = episode.at_limit(self.robot, self.config, self._own_q)
        sank = truth.penetration > self.config.max_penetration
        failed = failed_at_limit | sank
        reached = (error <= self.config.reach_tolerance) & ~failed
        outcome = np.full(self.n, Outcome.RUNNING.value, np.int8)
        outcome[self.steps >= self.config.max_steps] = Outcome.TIMEOUT.value
        outcome[reached] = Outcome.REACHED.value
        outcome[failed_at_limit] = Outcome.LIMIT.value
        outcome[sank] = Outcome.PENETRATION.value
        facts = reward.StepFacts(
            error=error,
            ranges=self._now.ranges,
            joint_change=np.abs(self._now.q - self._before.q).sum(axis=1),
            progress=progress,
            contact_force=truth.contact_force,
            penetration=truth.penetration,
            reached=reached,
            failed=failed,
        )
        return facts, outcome
