"""The tasks that a policy can be trained for: what each is made of, in one place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import Discriminator, Tag

from pipenav.any_pipe import AnyPipe
from pipenav.batch import CornerBatch, StepResult
from pipenav.errors import PipenavError
from pipenav.pipe_run_set import parse_any
from pipenav.pipe_set import parse_pipes
from pipenav.robot import RobotSpec
from pipenav.task import action, episode
from pipenav.task import observation as corner_observation
from pipenav.task.config import TaskConfig
from pipenav.task.observation import Part
from pipenav.traverse import observation as traverse_observation
from pipenav.traverse import start
from pipenav.traverse.batch import TraverseBatch
from pipenav.traverse.config import TraverseConfig

Array = NDArray[np.float64]


def _tag(given: Any) -> str:
    kind = given.get("kind", "reach") if isinstance(given, dict) else getattr(given, "kind", "reach")
    return f"<{kind}>"


AnyTask = Annotated[
    Annotated[TaskConfig, Tag("<reach>")] | Annotated[TraverseConfig, Tag("<traverse>")], Discriminator(_tag)
]
"""A task's settings, told apart by the key `kind`; without it they are those of the corner task."""


class TaskBatch(Protocol):
    """n episodes of a task, stepped together: what adapters and stages need of it."""

    robot: RobotSpec
    n: int
    steps: NDArray[np.intp]

    @property
    def pipes(self) -> Sequence[AnyPipe | None]:
        """The pipe of each robot."""
        ...

    @property
    def observation_size(self) -> int: ...

    @property
    def action_size(self) -> int: ...

    @property
    def q(self) -> Array:
        """Configurations in the robot's own frame, (n, coordinates)."""
        ...

    def reset(self, robots: NDArray[np.intp] | None = None) -> Array:
        """Start new episodes for some robots (sorted, unique), or all; observations of all robots, (n, size)."""
        ...

    def stagger(self, rng: np.random.Generator) -> None:
        """Make the next episodes start at random ages, so that their time-outs do not all fall into one step."""
        ...

    def step(self, action: Array) -> StepResult:
        """One control step of every robot under canonical actions in [-1, 1], (n, action_size)."""
        ...

    def close(self) -> None:
        """Release the backend."""
        ...


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
    parse: Callable[[Sequence[str]], Sequence[AnyPipe]]
    parse_tried: Callable[[Sequence[str]], Sequence[AnyPipe]]
    check_robot: Callable[[RobotSpec], None]
    layout: Callable[..., list[Part]]
    action_scale: Callable[..., Array]
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
        CornerBatch,
    ),
    TraverseConfig: Kind(
        "traverse",
        start.parse_planar,
        parse_any,
        start.check_robot,
        traverse_observation.layout,
        traverse_observation.action_scale,
        start.sample,
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


def scale_of(robot: RobotSpec, task: TaskConfig | TraverseConfig) -> Array:
    """What each value of the observation is divided by, (size,)."""
    return np.concatenate([part.scale for part in kind_of(task).layout(robot, task)])
