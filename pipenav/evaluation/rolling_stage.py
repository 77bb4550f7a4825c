"""The traverse task in space as a stage of an evaluation."""

from __future__ import annotations

from pipenav.backends.simulators import SimulatorSettings, load_spatial, open_space
from pipenav.errors import PipenavError
from pipenav.evaluation.episode_runner import EpisodeQueue, joined
from pipenav.evaluation.stage import TaskStage
from pipenav.policies.controller import AnyController
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling.batch import RollingBatch
from pipenav.tasks.rolling.clamp import check_robot
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import TraverseEpisodes


def check_in_space(robot: RobotSpec, backend: str, disturb: str | None = None) -> None:
    """Refuse what cannot be done in routes that leave the plane.

    Raises:
        PipenavError: a robot that cannot roll, a backend of the plane alone, or a disturbance.
    """
    check_robot(robot)
    load_spatial(backend)
    if disturb is not None:
        raise PipenavError("--disturb disturbs robots in a plane: choose routes without rolls, or leave it out.")


def rolling_stage(
    controller: AnyController, settings: SimulatorSettings, queue: EpisodeQueue[TraverseEpisodes]
) -> TaskStage:
    """The controller's task in space, with as many robots as the queue, which is its source."""
    robot, task, n = controller.robot, controller.task, len(queue.running)
    assert isinstance(task, TraverseConfig)  # no other task takes such routes
    simulator = open_space(settings.backend, robot, n, settings.options)
    return TaskStage(RollingBatch(robot, task, simulator, n, lambda indices: joined(queue.take(indices))), controller)
