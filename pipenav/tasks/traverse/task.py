"""The traverse task as `pipenav.tasks.task.Task` asks for it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import Simulator
from pipenav.backends.spatial import SpaceBackend
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route_sets import parse_pipes
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.layout import ObservationField
from pipenav.tasks.outcome import PassageStage
from pipenav.tasks.rolling.batch import RollingBatch
from pipenav.tasks.rolling.recovering import RecoveringBatch
from pipenav.tasks.task import EpisodeSource, Task
from pipenav.tasks.traverse import episode, observation
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import TraverseEpisodes
from pipenav.tasks.traverse.pace import most_slowness


class TraverseTask(Task[TraverseConfig, TraverseEpisodes]):
    """A whole robot on wheels goes through a corner or a route."""

    stage = PassageStage.TRAVERSE

    def parse_training_pipes(self, given: Sequence[str]) -> list[Pipe]:
        return parse_pipes(given)

    def parse_pipes(self, given: Sequence[str]) -> list[Pipe]:
        return parse_pipes(given)

    def check_robot(self, robot: RobotSpec) -> None:
        episode.check_robot(robot)

    def layout(self, robot: RobotSpec) -> list[ObservationField]:
        return observation.layout(robot, self.config)

    def action_scale(self, robot: RobotSpec) -> Floats:
        return observation.action_scale(robot, self.config)

    def most_steps(self, robot: RobotSpec, pipes: Sequence[Pipe]) -> int:
        corners = max(len(pipe.interior_angles) for pipe in pipes)
        return math.ceil(self.config.max_steps * most_slowness(robot, self.config) * corners)

    def sample(self, robot: RobotSpec, pipes: Sequence[Pipe], rng: np.random.Generator) -> TraverseEpisodes:
        return episode.sample(robot, self.config, pipes, rng)

    def batch(
        self, robot: RobotSpec, simulator: Simulator, n: int, source: EpisodeSource[TraverseEpisodes]
    ) -> TraverseBatch:
        kind = RecoveringBatch if self.config.recovery else TraverseBatch
        return kind(robot, self.config, simulator, n, source)

    def batch_in_space(
        self, robot: RobotSpec, backend: SpaceBackend, n: int, source: EpisodeSource[TraverseEpisodes]
    ) -> RollingBatch:
        return RollingBatch(robot, self.config, backend, n, source)
