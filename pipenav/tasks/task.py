"""A task of a robot: the one interface of every kind of task."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, Generic, Protocol, Self, TypeVar

import numpy as np

from pipenav.arrays import Floats, Ints, Table
from pipenav.backends.backend import Simulator
from pipenav.backends.spatial import SpaceBackend
from pipenav.errors import PipenavError
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.batch import TrainingBatch
from pipenav.tasks.layout import ObservationField
from pipenav.tasks.outcome import PassageStage


class Episodes(Protocol):
    """k episodes about to start: the pipes, the start poses, and all else that the task draws."""

    @property
    def pipes(self) -> tuple[Pipe, ...]:
        """Pipe of each episode, k of them."""
        ...

    @property
    def q(self) -> Floats:
        """Start configurations in the robot's own frame, (k, coordinates)."""
        ...

    @property
    def base(self) -> Floats:
        """Origin of each robot's frame on the first leg's axis, x in the pipe's frame, (k,) [m]."""
        ...

    def part(self, rows: slice) -> Self:
        """Episodes of some rows."""
        ...


ConfigT = TypeVar("ConfigT", bound=Table)
EpisodesT = TypeVar("EpisodesT", bound=Episodes)
EpisodeSource = Callable[[Ints], EpisodesT]
"""Function that gives the next episodes of the robots that start anew, from their indices, (k,)."""


class Task(ABC, Generic[ConfigT, EpisodesT]):
    """A kind of task with its settings.

    Attributes:
        stage: part of a passage that the task is.
        config: settings of the task.
    """

    stage: ClassVar[PassageStage]

    def __init__(self, config: ConfigT) -> None:
        self.config = config

    @abstractmethod
    def parse_training_pipes(self, given: Sequence[str]) -> Sequence[Pipe]:
        """Pipes to train in, from the texts by which a person names them.

        Raises:
            PipenavError: something unknown or impossible, or a pipe that the task cannot be trained in.
        """

    @abstractmethod
    def parse_pipes(self, given: Sequence[str]) -> Sequence[Pipe]:
        """Pipes to evaluate in, from the texts by which a person names them.

        Raises:
            PipenavError: something unknown or impossible.
        """

    @abstractmethod
    def check_robot(self, robot: RobotSpec) -> None:
        """Refuse a robot that cannot do the task.

        Raises:
            PipenavError: the robot cannot do it.
        """

    @abstractmethod
    def layout(self, robot: RobotSpec) -> list[ObservationField]:
        """Parts of the observation, in order."""

    @abstractmethod
    def action_scale(self, robot: RobotSpec) -> Floats:
        """Physical size of an action of 1, (action_size,)."""

    @abstractmethod
    def most_steps(self, robot: RobotSpec, pipes: Sequence[Pipe]) -> int:
        """Most control steps of an episode in any of these pipes, at least one."""

    @abstractmethod
    def sample(self, robot: RobotSpec, pipes: Sequence[Pipe], rng: np.random.Generator) -> EpisodesT:
        """Random episodes, one in each of the given pipes."""

    @abstractmethod
    def batch(self, robot: RobotSpec, simulator: Simulator, n: int, source: EpisodeSource[EpisodesT]) -> TrainingBatch:
        """A batch of n episodes on a simulator; the source says how each episode starts."""

    def batch_in_space(
        self,
        robot: RobotSpec,  # noqa: ARG002  # the signature of the interface
        backend: SpaceBackend,  # noqa: ARG002
        n: int,  # noqa: ARG002
        source: EpisodeSource[EpisodesT],  # noqa: ARG002
    ) -> TrainingBatch:
        """A batch of n episodes on robots in space, for pipes of which some leave the plane.

        Raises:
            PipenavError: the task is done in a plane alone.
        """
        raise PipenavError(f"the stage {self.stage} is done in a plane alone: choose pipes without rolls.")

    def observation_scale(self, robot: RobotSpec) -> Floats:
        """Number that each value of the observation is divided by, (size,)."""
        return np.concatenate([field.scale for field in self.layout(robot)])


AnyTask = Task[Any, Any]
"""A task of any kind."""
