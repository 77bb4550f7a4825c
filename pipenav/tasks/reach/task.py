"""The reach task as `pipenav.tasks.task.Task` asks for it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import Simulator
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import parse_corners
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.layout import ObservationField
from pipenav.tasks.outcome import PassageStage
from pipenav.tasks.reach import action, episode, observation
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.task import EpisodeSource, Task


class ReachTask(Task[ReachConfig, ReachEpisodes]):
    """An arm on a mount brings its tip to a target around a corner."""

    stage = PassageStage.REACH

    def parse_training_pipes(self, given: Sequence[str]) -> list[PipeCorner]:
        return parse_corners(given)

    def parse_pipes(self, given: Sequence[str]) -> list[PipeCorner]:
        return parse_corners(given)

    def check_robot(self, robot: RobotSpec) -> None:
        episode.check_robot(robot)

    def layout(self, robot: RobotSpec) -> list[ObservationField]:
        return observation.layout(robot, self.config)

    def action_scale(self, robot: RobotSpec) -> Floats:
        return action.full_action(robot, self.config)

    def most_steps(self, robot: RobotSpec, pipes: Sequence[Pipe]) -> int:  # noqa: ARG002  # the same in every pipe
        return self.config.max_steps

    def sample(self, robot: RobotSpec, pipes: Sequence[Pipe], rng: np.random.Generator) -> ReachEpisodes:
        return episode.sample(robot, self.config, [pipe.require_corner() for pipe in pipes], rng)

    def batch(self, robot: RobotSpec, simulator: Simulator, n: int, source: EpisodeSource[ReachEpisodes]) -> ReachBatch:
        return ReachBatch(robot, self.config, simulator, n, source)
