"""Trial of a training before its folder is made: its robots are put into its pipes once."""

from __future__ import annotations

from contextlib import closing

import numpy as np

from pipenav.backends.simulators import open_simulator
from pipenav.disturbances.disturbed_backend import disturbed
from pipenav.learning.config import TrainConfig
from pipenav.policies.header import header_for
from pipenav.robots.robot import load_robot
from pipenav.tasks.registry import task_of


def rehearse(config: TrainConfig) -> None:
    """Open one robot in the first pipe, and draw a start in each pipe.

    Raises:
        PipenavError: the robot, the task, the pipes and the simulator do not fit each other.
    """
    robot, task = load_robot(config.robot), task_of(config.task)
    header_for(robot, config.task, config.pipes, {})
    pipes = [pipe for name in config.pipes for pipe in task.parse_training_pipes([name])]
    starting = task_of(config.randomise.starts(config.task))
    episodes = starting.sample(robot, pipes, np.random.default_rng(config.seed))
    segments = max(len(pipe.segments) for pipe in pipes)
    with closing(open_simulator(config.backend, robot, 1, config.options, segments)) as simulator:
        first = episodes.part(slice(1))
        backend = disturbed(simulator, robot, 1, config.randomise, config.seed)
        backend.reset(np.array([0]), first.pipes, first.q, first.base)
