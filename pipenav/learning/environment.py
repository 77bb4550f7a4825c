"""The robots of a training, in the plane or in space."""

from __future__ import annotations

from typing import Any

from pipenav.backends.simulators import load_simulator, open_simulator, open_space
from pipenav.disturbances.disturbed_backend import disturbed
from pipenav.learning.config import TrainConfig
from pipenav.robots.robot import load_robot
from pipenav.tasks.batch import TrainingBatch
from pipenav.tasks.registry import task_of
from pipenav.tasks.rolling.batch import check_in_space
from pipenav.tasks.task import EpisodeSource

MOST_SHARES = 2
"""Shares of a training's robots that take turns: one moves while the other is attended to."""


def open_training_batches(config: TrainConfig, n: int, source: EpisodeSource[Any]) -> list[TrainingBatch]:
    """Robots of a training in as many batches as can take turns, see `open_training_batch`."""
    shares = min(MOST_SHARES, n) if load_simulator(config.backend).steps_in_threads else 1
    sizes = [(n + i) // shares for i in range(shares)]
    return [open_training_batch(config, size, source) for size in sizes]


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
