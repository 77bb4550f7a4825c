"""Trial of a training before its folder is made: its robots are put into its pipes once."""

from __future__ import annotations

from contextlib import closing

import numpy as np

from pipenav.learning.config import TrainConfig
from pipenav.learning.environment import open_training_batch
from pipenav.learning.stages import training_stages
from pipenav.policies.header import header_for
from pipenav.robots.robot import load_robot
from pipenav.tasks.registry import task_of


def rehearse(config: TrainConfig) -> None:
    """Open one robot in the first pipe of each stage, and draw a start in each of its pipes.

    Raises:
        PipenavError: the robot, the task, the pipes and the simulator do not fit each other.
    """
    for stage in training_stages(config):
        _rehearse_stage(stage.config)


def _rehearse_stage(config: TrainConfig) -> None:
    robot, task = load_robot(config.robot), task_of(config.task)
    header_for(robot, config.task, config.pipes, {})
    pipes = [pipe for name in config.pipes for pipe in task.parse_training_pipes([name])]
    starting = task_of(config.randomise.starts(config.task))
    episodes = starting.sample(robot, pipes, np.random.default_rng(config.seed))
    with closing(open_training_batch(config, 1, lambda _: episodes.part(slice(1)))) as batch:
        batch.reset()
