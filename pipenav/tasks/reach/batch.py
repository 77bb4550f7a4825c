"""The reach task on n robots of one backend at once: the core that every adapter wraps."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Truth
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.batch import Assessment, StepResult, TrainingBatch
from pipenav.tasks.outcome import Outcome, strongest_outcome
from pipenav.tasks.reach import action as actions
from pipenav.tasks.reach import episode, observation, reward
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.task import EpisodeSource


class ReachBatch(TrainingBatch):
    """n episodes of the reach task.

    Raises:
        PipenavError: the robot hangs on no mount.
    """

    def __init__(
        self, robot: RobotSpec, config: ReachConfig, simulator: Simulator, n: int, source: EpisodeSource[ReachEpisodes]
    ) -> None:
        episode.check_robot(robot)
        self.robot, self.config, self.n = robot, config, n
        self._simulator, self._source = simulator, source
        self._scale = np.concatenate([field.scale for field in observation.layout(robot, config)])
        joints = len(robot.joints)
        self._pipes: list[PipeCorner | None] = [None] * n
        self.steps, self._ages = np.zeros(n, int), np.zeros(n, int)
        self._turn_sign, self._target, self._edge = np.ones(n), np.zeros((n, 2)), np.zeros((n, 2))
        self._distance = np.zeros(n)
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
    def pipes(self) -> list[PipeCorner | None]:
        return self._pipes

    @property
    def target(self) -> Floats:
        """Targets in the canonical frame, (n, 2) [m]."""
        return self._target.copy()

    @property
    def edge(self) -> Floats:
        """Point where the inner wall starts to bend, in the canonical frame, (n, 2) [m]."""
        return self._edge.copy()

    @property
    def q(self) -> Floats:
        """Joint positions in the robot's own frame, (n, joints)."""
        return self._own_q.copy()

    @property
    def snapshot(self) -> observation.Snapshot:
        """Readings of this step in the canonical frame."""
        return self._now

    def reset(self, indices: Ints | None = None) -> Floats:
        indices = np.arange(self.n) if indices is None else np.asarray(indices, np.intp)
        episodes = self._source(indices)
        reading = self._simulator.reset(indices, episodes.pipes, episodes.q, episodes.base)
        for i, pipe in zip(indices, episodes.pipes, strict=True):
            self._pipes[i] = pipe
        self.steps[indices] = self._ages[indices]
        self._ages[indices] = 0
        self._turn_sign[indices], self._target[indices], self._edge[indices] = (
            episodes.turn_sign,
            episodes.target,
            episodes.edge,
        )
        self._action[indices], self._own_q[indices] = 0.0, reading.q
        now = observation.canonical(self.robot, reading, episodes.turn_sign)
        self._now.put(indices, now)
        self._before.put(indices, now)
        self._distance[indices] = episode.distance_to_target(now.tip, episodes.target, episodes.edge)
        observed = observation.observe(self.config, now, now, self._action[indices], episodes.target)
        self._observation = self._observation.copy()
        self._observation[indices] = observed / self._scale
        return self._observation

    def stagger(self, rng: np.random.Generator) -> None:
        self._ages = rng.integers(0, self.config.max_steps // 2, self.n)

    def begin(self, action: Floats) -> Callable[[], None]:
        self._before, self._action = self._now, np.clip(action, -1.0, 1.0)
        command = actions.to_command(self.robot, self.config, self._action, self._own_q, self._turn_sign)
        return partial(self._simulator.step, command)

    def carried_out(self, rows: Ints, told: Floats) -> Floats:
        acted = actions.of_set_points(self.robot, self.config, told, self._own_q[rows], self._turn_sign[rows])
        self._action[rows] = acted
        return acted

    def end(self) -> StepResult:
        self.steps += 1
        reading = self._simulator.read()
        self._own_q, self._now = reading.q, observation.canonical(self.robot, reading, self._turn_sign)
        truth = self._simulator.truth()
        facts, outcome = self._assess(truth)
        result = reward.total(self.config.reward, facts)
        observed = observation.observe(self.config, self._now, self._before, self._action, self._target)
        self._observation = observed / self._scale
        cut_off = outcome == Outcome.TIMEOUT.value
        return StepResult(self._observation, result, outcome, self._now.ranges.min(axis=1), truth, cut_off)

    def close(self) -> None:
        self._simulator.close()

    def _assess(self, truth: Truth) -> Assessment[reward.StepFacts]:
        distance = episode.distance_to_target(self._now.tip, self._target, self._edge)
        progress, self._distance = self._distance - distance, distance
        error = np.hypot(*(self._now.tip - self._target).T)
        failed_at_limit = episode.at_limit(self.robot, self.config, self._own_q)
        sank = truth.penetration > self.config.max_penetration
        holds = {
            Outcome.TIMEOUT: self.steps >= self.config.max_steps,
            Outcome.REACHED: error <= self.config.reach_tolerance,
            Outcome.LIMIT: failed_at_limit,
            Outcome.PENETRATION: sank,
        }
        outcome = strongest_outcome(self.n, holds)
        facts = reward.StepFacts(
            error=error,
            ranges=self._now.ranges,
            joint_change=np.abs(self._now.q - self._before.q).sum(axis=1),
            progress=progress,
            contact_force=truth.contact_force,
            penetration=truth.penetration,
            reached=outcome == Outcome.REACHED.value,
            failed=failed_at_limit | sank,
        )
        return Assessment(facts, outcome)
