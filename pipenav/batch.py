"""The corner task on n robots of one backend at once: the core that every environment adapter wraps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav import kinematics
from pipenav.backend import Backend
from pipenav.pipe import Pipe
from pipenav.robot import RobotSpec
from pipenav.state import Truth
from pipenav.task import action as actions
from pipenav.task import episode, observation, reward
from pipenav.task.config import TaskConfig
from pipenav.task.episode import Episodes, Verdict

Array = NDArray[np.float64]
EpisodeSource = Callable[[NDArray[np.intp]], Episodes]
"""Given the robots that start anew, their next episodes."""


class StepResult(NamedTuple):
    """One control step of n robots.

    Attributes:
        observation: scaled, (n, size).
        reward: (n,).
        verdict: a `Verdict` for each, (n,); other than RUNNING ends the episode.
        clearance: smallest laser reading, (n,) [m].
        truth: what the simulator knows.
    """

    observation: Array
    reward: Array
    verdict: NDArray[np.int8]
    clearance: Array
    truth: Truth


class CornerBatch:
    """n episodes of the corner task, stepped together. Who calls `step` also says, by `reset`, who starts anew."""

    def __init__(self, robot: RobotSpec, config: TaskConfig, backend: Backend, n: int, source: EpisodeSource) -> None:
        self.robot, self.config, self.n = robot, config, n
        self._backend, self._source = backend, source
        self._scale = observation.scale_of(robot, config)
        joints = len(robot.joints)
        self.pipes: list[Pipe | None] = [None] * n
        self.steps, self._ages = np.zeros(n, int), np.zeros(n, int)
        self._side, self._goal, self._edge = np.ones(n), np.zeros((n, 2)), np.zeros((n, 2))
        self._way = np.zeros(n)
        self._action = np.zeros((n, joints))
        self._now = self._before = observation.Snapshot(
            np.zeros((n, joints)), np.zeros((n, joints)), np.zeros((n, robot.laser.beams))
        )

    @property
    def observation_size(self) -> int:
        return len(self._scale)

    @property
    def goal(self) -> Array:
        """Targets in the canonical frame, (n, 2) [m]."""
        return self._goal.copy()

    @property
    def edge(self) -> Array:
        """Where the inner wall starts to bend, in the canonical frame, (n, 2) [m]."""
        return self._edge.copy()

    @property
    def snapshot(self) -> observation.Snapshot:
        """This step's readings in the canonical frame."""
        return self._now

    def reset(self, robots: NDArray[np.intp] | None = None) -> Array:
        """Start new episodes for some robots (sorted, unique), or all; observations of all robots, (n, size)."""
        robots = np.arange(self.n) if robots is None else np.asarray(robots, np.intp)
        episodes = self._source(robots)
        self._backend.reset(robots, episodes.pipes, episodes.q, episodes.base)
        for i, pipe in zip(robots, episodes.pipes, strict=True):
            self.pipes[i] = pipe
        self.steps[robots] = self._ages[robots]
        self._ages[robots] = 0
        self._side[robots], self._goal[robots], self._edge[robots] = episodes.side, episodes.goal, episodes.edge
        self._action[robots] = 0.0
        self._look()
        self._before = observation.Snapshot(*(a.copy() for a in self._before))
        for old, new in zip(self._before, self._now, strict=True):
            old[robots] = new[robots]
        self._way[robots] = self._way_left()[robots]
        return self._observe()

    def stagger(self, rng: np.random.Generator) -> None:
        """Make the next episodes start at random ages, so that their time-outs do not all fall into one step."""
        self._ages = rng.integers(0, self.config.max_steps // 2, self.n)

    def step(self, action: Array) -> StepResult:
        """One control step of every robot.

        Args:
            action: canonical actions in [-1, 1], (n, joints).
        """
        command = actions.to_command(self.robot, self.config, action, self._own_q, self._side)
        self._backend.step(command)
        self.steps += 1
        self._before, self._action = self._now, np.clip(action, -1.0, 1.0)
        self._look()
        truth = self._backend.truth()
        if truth is None:
            raise TypeError("the corner task needs a simulator: this backend knows no truth")
        facts, verdict = self._judge(truth)
        result = reward.total(self.config.reward, facts)
        return StepResult(self._observe(), result, verdict, self._now.ranges.min(axis=1), truth)

    def close(self) -> None:
        self._backend.close()

    def _look(self) -> None:
        reading = self._backend.read()
        self._own_q = reading.q
        self._now = observation.canonical(self.robot, reading, self._side)

    def _observe(self) -> Array:
        raw = observation.observe(self.robot, self.config, self._now, self._before, self._action, self._goal)
        return raw / self._scale

    def _way_left(self) -> Array:
        self._tip = kinematics.forward(self.robot, self._now.q).tip
        return episode.way_to_goal(self._tip, self._goal, self._edge)

    def _judge(self, truth: Truth) -> tuple[reward.StepFacts, NDArray[np.int8]]:
        way = self._way_left()
        progress, self._way = self._way - way, way
        error = np.linalg.norm(self._tip - self._goal, axis=1)
        verdict = np.full(self.n, Verdict.RUNNING, np.int8)
        verdict[self.steps >= self.config.max_steps] = Verdict.TIMEOUT
        verdict[error <= self.config.reach_tolerance] = Verdict.REACHED
        verdict[episode.at_limit(self.robot, self.config, self._own_q)] = Verdict.LIMIT
        verdict[truth.penetration > self.config.max_penetration] = Verdict.PENETRATION
        facts = reward.StepFacts(
            error=error,
            ranges=self._now.ranges,
            joint_change=np.abs(self._now.q - self._before.q).sum(axis=1),
            progress=progress,
            contact_force=truth.contact_force,
            penetration=truth.penetration,
            reached=verdict == Verdict.REACHED,
            failed=(verdict == Verdict.LIMIT) | (verdict == Verdict.PENETRATION),
        )
        return facts, verdict


def random_episodes(
    robot: RobotSpec, config: TaskConfig, sets: Sequence[Sequence[Pipe]], rng: np.random.Generator
) -> EpisodeSource:
    """Episodes with random starts and targets in random pipes: first a set is drawn, each alike, then a pipe of it."""

    def source(robots: NDArray[np.intp]) -> Episodes:
        chosen = [sets[int(rng.integers(len(sets)))] for _ in robots]
        return episode.sample(robot, config, [pipes[int(rng.integers(len(pipes)))] for pipes in chosen], rng)

    return source
