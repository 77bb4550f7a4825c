"""The traverse task in space: n robots, each in a run of its own, that roll before corners whose plane is not theirs."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from pipenav.batch import StepResult
from pipenav.pipe_run import PipeRun
from pipenav.robot import BASE, RobotSpec
from pipenav.space import SpaceBackend, SpaceReading
from pipenav.state import Reading
from pipenav.task.episode import Verdict
from pipenav.traverse import observation
from pipenav.traverse.config import TraverseConfig
from pipenav.traverse.judge import Judge, reward
from pipenav.traverse.start import TraverseEpisodes
from pipenav.spatial.pilot import Mode, Pilot
from pipenav.spatial.clamp import check_robot

Array = NDArray[np.float64]

LIMIT_FACTOR = 2
"""How many times as long as in the plane an episode may take: straights are longer, and rolling takes 10 to 20 s."""


class SpaceBatch:
    """n episodes in space, stepped together. Who calls `step` also says, by `reset`, who starts anew."""

    def __init__(
        self,
        robot: RobotSpec,
        config: TraverseConfig,
        backend: SpaceBackend,
        n: int,
        source: Callable[[NDArray[np.intp]], TraverseEpisodes],
    ) -> None:
        check_robot(robot)
        self.robot, self.config, self.n = robot, config, n
        self._backend, self._source = backend, source
        self._scale = np.concatenate([part.scale for part in observation.layout(robot, config)])
        self.pipes: list[PipeRun] = []
        self._pilots: list[Pilot] = []
        self.steps = np.zeros(n, int)
        self._judge = Judge(robot, config, n)
        self._action = np.zeros((n, len(robot.drives)))
        self._end = np.zeros(n)

    @property
    def observation_size(self) -> int:
        return len(self._scale)

    @property
    def action_size(self) -> int:
        return len(self.robot.drives)

    @property
    def q(self) -> Array:
        """Joint positions after zeros where the plane has the base's pose, (n, coordinates)."""
        joints = self._backend.read().body.q
        return np.concatenate([np.zeros((self.n, len(BASE))), joints], axis=1)

    def reset(self, robots: NDArray[np.intp] | None = None) -> Array:
        robots = np.arange(self.n) if robots is None else np.asarray(robots, np.intp)
        episodes = self._source(robots)
        planes = np.array([run.corners[0].roll for run in episodes.pipes])
        self._backend.reset(robots, episodes.pipes, episodes.q, episodes.base, planes)
        if not self.pipes:
            self.pipes = list(episodes.pipes)
            self._pilots = [None] * self.n
        for i, run in zip(robots, episodes.pipes, strict=True):
            self.pipes[i] = run
        reading = self._backend.read()
        for i in robots:
            q = reading.body.q[i]
            self._pilots[i] = Pilot(self.robot, self.pipes[i], q + self.config.start_press * np.sign(q))
            self._end[i] = self.pipes[i].places[-2] + self.pipes[i].radius * self.pipes[i].legs.reach[-1]
        self.steps[robots], self._action[robots] = 0, 0.0
        self._judge.start(robots, self._along()[robots])
        return self._observe(reading)

    def step(self, action: Array) -> StepResult:
        reading = self._backend.read()
        side = np.array([pilot.side for pilot in self._pilots])
        held = np.array([pilot.set_points for pilot in self._pilots])
        command = observation.to_command(self.robot, self.config, action, reading.body.q, held, side).values.copy()
        roll = np.zeros(self.n)
        self._action = np.clip(action, -1.0, 1.0)
        for i, pilot in enumerate(self._pilots):
            command[i], roll[i] = pilot.command(row(reading, i), command[i])
            if pilot.mode is not Mode.CORNER:
                self._action[i] = 0.0
        self._backend.step(command, roll)
        self.steps += 1
        reading, truth = self._backend.read(), self._backend.truth()
        for i, pilot in enumerate(self._pilots):
            pilot.sense(row(reading, i))
        limit = self.config.max_steps * LIMIT_FACTOR * np.array([len(run.corners) for run in self.pipes])
        facts, verdict = self._judge.step(self.steps, limit, self._along(), self._end, reading.body, truth)
        self._judge.excuse(np.array([pilot.mode is Mode.ROLL for pilot in self._pilots]))
        observed = self._observe(reading)
        cut_off = (verdict != Verdict.RUNNING) & ~facts.passed & ~facts.failed
        return StepResult(
            observed, reward(self.config.reward, facts), verdict, reading.body.ranges.min(axis=1), truth, cut_off
        )

    def _observe(self, reading: SpaceReading) -> Array:
        side = np.array([pilot.side for pilot in self._pilots])
        alone = np.zeros((self.n, 2))  # a corner is taken by itself, wherever the next one leads
        return observation.observe(self.robot, reading.body, self._action, side, alone) / self._scale

    def _along(self) -> Array:
        points = self._backend.truth().points
        return np.array([run.along(place) for run, place in zip(self.pipes, points, strict=True)])

    def close(self) -> None:
        self._backend.close()


def row(reading: SpaceReading, i: int) -> SpaceReading:
    """That of one robot, its arrays without the first axis."""
    body = Reading(*(None if part is None else part[i] for part in reading.body))
    return SpaceReading(body, reading.roll[i], reading.down[i])
