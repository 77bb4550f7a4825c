"""The robots of a training, in the plane or in space."""

from __future__ import annotations

from typing import Any

from pipenav.backends.simulators import open_simulator, open_space
from pipenav.disturbances.disturbed_backend import disturbed
from pipenav.learning.config import TrainConfig
from pipenav.robots.robot import load_robot
from pipenav.tasks.batch import TrainingBatch
from pipenav.tasks.registry import task_of
from pipenav.tasks.rolling.batch import check_in_space
from pipenav.tasks.task import EpisodeSource


def open_training_batch(config: TrainConfig, n: int, source: EpisodeSource[Any]) -> TrainingBatch:
    """Robots of a training, on its simulator and under its disturbance.

    They are in space where any of the training's pipes leaves the plane, those of its pipes that do not included.

    Args:
        config: configuration of the training.
        n: number of robots.
        source: gives their episodes.

    Raises:
        PipenavError: the robot, the task, the pipes and the simulator do not fit each other.
    """
    robot, task = load_robot(config.robot), task_of(config.task)
    pipes = task.parse_training_pipes(config.pipes)
    if any(pipe.in_space for pipe in pipes):
        check_in_space(robot, config.backend, "randomise" if config.randomise.acts else None)
        backend = open_space(config.backend, robot, n, config.options)
        return task.batch_in_space(robot, backend, n, source)
    segments = max(len(pipe.segments) for pipe in pipes)
    simulator = open_simulator(config.backend, robot, n, config.options, segments)
    return task.batch(robot, disturbed(simulator, robot, n, config.randomise, config.seed), n, source)
