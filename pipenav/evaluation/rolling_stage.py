"""The traverse task in space as a stage of an evaluation."""

from __future__ import annotations

from pipenav.backends.simulators import SimulatorSettings, open_space
from pipenav.evaluation.episode_runner import EpisodeQueue, joined
from pipenav.evaluation.stage import TaskStage
from pipenav.policies.controller import AnyController
from pipenav.tasks.registry import TaskConfig, task_of
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import TraverseEpisodes


def rolling_stage(
    controller: AnyController, task: TaskConfig, settings: SimulatorSettings, queue: EpisodeQueue[TraverseEpisodes]
) -> TaskStage:
    """A task in space under a controller, with as many robots as the queue, which is its source."""
    robot, n = controller.robot, len(queue.running)
    assert isinstance(task, TraverseConfig)  # no other task takes such routes
    backend = open_space(settings.backend, robot, n, settings.options)
    batch = task_of(task).batch_in_space(robot, backend, n, lambda indices: joined(queue.take(indices)))
    return TaskStage(batch, controller)
