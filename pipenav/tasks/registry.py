"""The tasks that a policy can be trained for: what each is made of, in one place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Discriminator, Tag

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner_sets import parse_pipes
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route_sets import parse_any
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.batch import TaskBatch
from pipenav.tasks.layout import ObservationField
from pipenav.tasks.reach import action, episode
from pipenav.tasks.reach import observation as corner_observation
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import TaskConfig
from pipenav.tasks.traverse import episode as traverse_episode
from pipenav.tasks.traverse import observation as traverse_observation
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.config import TraverseConfig


def _tag(given: Any) -> str:
    kind = given.get("kind", "reach") if isinstance(given, dict) else getattr(given, "kind", "reach")
    return f"<{kind}>"


AnyTask = Annotated[
    Annotated[TaskConfig, Tag("<reach>")] | Annotated[TraverseConfig, Tag("<traverse>")], Discriminator(_tag)
]
"""A task's settings, told apart by the key `kind`; without it they are those of the corner task."""


class Kind(NamedTuple):
    """What a kind of task is made of; the functions take the robot and the task's settings first.

    Attributes:
        stage: name of the part of a passage that it is.
        parse: pipes that it can be trained in, as a person names them.
        parse_tried: pipes that it can be tried in: runs that leave the plane among them, where the robot can roll.
        check_robot: refuses a robot that cannot do it; takes the robot alone.
        layout: parts of the observation.
        action_scale: what a full action is, (drives,).
        sample: episodes in given pipes.
        batch: n episodes on a backend; then takes the backend, n and a source of episodes.
    """

    stage: Literal["front", "traverse"]
    parse: Callable[[Sequence[str]], Sequence[Pipe]]
    parse_tried: Callable[[Sequence[str]], Sequence[Pipe]]
    check_robot: Callable[[RobotSpec], None]
    layout: Callable[..., list[ObservationField]]
    action_scale: Callable[..., Floats]
    sample: Callable[..., Any]
    batch: Callable[..., TaskBatch]


KINDS: dict[type, Kind] = {
    TaskConfig: Kind(
        "front",
        parse_pipes,
        parse_pipes,
        episode.check_robot,
        corner_observation.layout,
        action.full_action,
        episode.sample,
        ReachBatch,
    ),
    TraverseConfig: Kind(
        "traverse",
        traverse_episode.parse_planar,
        parse_any,
        traverse_episode.check_robot,
        traverse_observation.layout,
        traverse_observation.action_scale,
        traverse_episode.sample,
        TraverseBatch,
    ),
}


def kind_of(task: TaskConfig | TraverseConfig) -> Kind:
    """What this task is made of."""
    return KINDS[type(task)]


def default_task(robot: RobotSpec) -> TaskConfig | TraverseConfig:
    """What a robot does where nothing else is said: an arm on a mount reaches, a whole robot traverses."""
    return TraverseConfig(kind="traverse") if robot.free else TaskConfig()


def reaching(task: TaskConfig | TraverseConfig, who: str) -> TaskConfig:
    """The task, where it is the corner task.

    Raises:
        PipenavError: it is another, which `who` cannot use.
    """
    if isinstance(task, TaskConfig):
        return task
    raise PipenavError(f"{who} is for a policy that reaches a target around a corner, not for the task {task.kind!r}.")


def scale_of(robot: RobotSpec, task: TaskConfig | TraverseConfig) -> Floats:
    """What each value of the observation is divided by, (size,)."""
    return np.concatenate([part.scale for part in kind_of(task).layout(robot, task)])
