"""The tasks that there are: found by the class of their settings, which files tell apart by the key `kind`."""

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
"""A task's settings, told apart by the key `kind`; without it they are those of the reach task."""


def task_of(config: ReachConfig | TraverseConfig) -> AnyTask:
    """The task with these settings."""
    return ReachTask(config) if isinstance(config, ReachConfig) else TraverseTask(config)


def default_config(robot: RobotSpec) -> ReachConfig | TraverseConfig:
    """Settings of what a robot does where nothing else is said: an arm on a mount reaches, a whole robot traverses."""
    return TraverseConfig(kind="traverse") if robot.free else ReachConfig()


def require_reach(config: ReachConfig | TraverseConfig, who: str) -> ReachConfig:
    """The settings, where they are the reach task's.

    Raises:
        PipenavError: they are another task's, which `who` cannot use.
    """
    if isinstance(config, ReachConfig):
        return config
    raise PipenavError(
        f"{who} is for a policy that reaches a target around a corner, not for the task {config.kind!r}."
    )
