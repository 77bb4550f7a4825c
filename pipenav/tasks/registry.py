"""All tasks, found by the class of their settings, which files tell apart by the key `kind`."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Tag

from pipenav.errors import PipenavError
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.task import ReachTask
from pipenav.tasks.task import AnyTask
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.task import TraverseTask


def _tag(given: Any) -> str:
    kind = given.get("kind", "reach") if isinstance(given, dict) else getattr(given, "kind", "reach")
    return f"<{kind}>"


TaskConfig = Annotated[
    Annotated[ReachConfig, Tag("<reach>")] | Annotated[TraverseConfig, Tag("<traverse>")], Discriminator(_tag)
]
"""Settings of any task, told apart by the key `kind`; without that key they are the reach task's."""


def task_of(config: ReachConfig | TraverseConfig) -> AnyTask:
    """The task with these settings."""
    return ReachTask(config) if isinstance(config, ReachConfig) else TraverseTask(config)


def default_config(robot: RobotSpec) -> ReachConfig | TraverseConfig:
    """Default task settings of a robot: an arm on a mount reaches, a whole robot traverses."""
    return TraverseConfig(kind="traverse") if robot.free else ReachConfig()


def require_reach(config: ReachConfig | TraverseConfig, who: str) -> ReachConfig:
    """The settings, checked to be the reach task's.

    Args:
        config: settings of some task.
        who: the user of the settings, as the first words of the message.

    Raises:
        PipenavError: the settings are another task's.
    """
    if isinstance(config, ReachConfig):
        return config
    raise PipenavError(
        f"{who} is for a policy that reaches a target around a corner, not for the task {config.kind!r}."
    )
