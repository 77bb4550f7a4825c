"""Approach I as a part of a passage: n robots that look for a target, judged by where it lies and what they touched."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Command, Reading
from pipenav.evaluation.stage import Stage, StageStep
from pipenav.locating.locator import LOCATORS, LocateConfig, Variant, require_arm
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.batch import EpisodeSource
from pipenav.tasks.reach.config import TaskConfig
from pipenav.tasks.reach.episode import at_limit


class LocateStage(Stage):
    """The robots look for a target; finding one inside the second leg is the stage's success.

    Args:
        robot: a slide followed by hinges, with the fan that the variant wants (`robot_for`).
        config: settings of the behaviour.
        variant: which behaviour.
        task: when an episode fails: its steps, penetration and limit margin.
        backend: a simulator with n robots.
        n: how many.
        source: of episodes; their targets are not looked at.

    Attributes:
        target: found targets in the canonical frame, where a front passage's `Episodes.set_points` lives, (n, 2) [m]; NaN
            before one is found.
        beam: the beam on or nearest to which it lies, from right to left from 0, (n,); -1 before.
        reading: what the robots' sensors gave last; the next step decides on it.

    Raises:
        PipenavError: a robot of other joints.
    """

    def __init__(
        self,
        robot: RobotSpec,
        config: LocateConfig,
        variant: Variant,
        task: TaskConfig,
        backend: Simulator,
        n: int,
        source: EpisodeSource,
    ) -> None:
        require_arm(robot)
        self.robot, self.n = robot, n
        self._task, self._backend, self._source = task, backend, source
        self._locator = LOCATORS[variant](robot, config, n)
        self._steps = np.zeros(n, int)
        self._pipes: list[PipeCorner | None] = [None] * n
        self._base, self._turn_sign = np.zeros(n), np.ones(n)
        self.target, self.beam = np.full((n, 2), np.nan), np.full(n, -1)
        q, qd = np.zeros((2, n, len(robot.joints)))
        self.reading = Reading(q, qd, np.zeros((n, robot.laser.beams)), np.zeros(n))

    @property
    def steps(self) -> Ints:
        return self._steps

    def start(self, indices: Ints) -> None:
        episodes = self._source(indices)
        reading = self._backend.reset(indices, episodes.pipes, episodes.q, episodes.base)
        for i, pipe in zip(indices, episodes.pipes, strict=True):
            self._pipes[i] = pipe
        self._steps[indices], self._base[indices], self._turn_sign[indices] = 0, episodes.base, episodes.turn_sign
        self.target[indices], self.beam[indices] = np.nan, -1
        self.reading.put(indices, reading)
        self._locator.start(indices, reading, episodes.turn_sign)

    def step(self) -> StageStep:
        decision = self._locator.act(self.reading)
        self.target = decision.target * np.stack([np.ones(self.n), self._turn_sign], axis=1)
        self.beam = decision.beam
        self._backend.step(Command("position", decision.set_points))
        self._steps += 1
        self.reading, truth = self._backend.read(), self._backend.truth()
        outcome = np.full(self.n, Outcome.RUNNING, np.int8)
        outcome[self._steps >= self._task.max_steps] = Outcome.TIMEOUT
        for i in map(int, np.flatnonzero(decision.done)):
            outcome[i] = Outcome.REACHED if self._well_placed(i, decision.target[i]) else Outcome.MISPLACED
        outcome[at_limit(self.robot, self._task, self.reading.q)] = Outcome.LIMIT
        outcome[truth.penetration > self._task.max_penetration] = Outcome.PENETRATION
        return StageStep(outcome, self.reading.ranges.min(axis=1), truth, self.reading.q)

    def close(self) -> None:
        self._backend.close()

    def _well_placed(self, robot: int, target: Floats) -> bool:
        pipe = self._pipes[robot]
        return pipe is not None and inside_second_leg(pipe, target + np.array([self._base[robot], 0.0]))


def inside_second_leg(pipe: PipeCorner, point: Floats) -> bool:
    """Whether a point (2,) of the pipe's frame lies inside the pipe and past the end of the inner wall's bend."""
    along = float(pipe.along_second_leg(point)[0])
    return along > pipe.inner_edge and bool(pipe.contains(point))
