"""Controllers: those that act on observations alone, and privileged ones that also know where robots and pipes are."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.batch import TaskBatch
from pipenav.tasks.registry import TaskConfig

BatchT = TypeVar("BatchT", bound=TaskBatch)


class Controller(Protocol):
    """A controller that acts on observations alone, as a policy does.

    Attributes:
        robot: robot that it acts for.
        task: settings of the task, with the control mode and the observation that it needs.
    """

    @property
    def robot(self) -> RobotSpec: ...

    @property
    def task(self) -> TaskConfig: ...

    def act(self, observation: Floats) -> Floats:
        """Canonical actions in [-1, 1], (n, action_size), for scaled observations, (n, size)."""
        ...


class PrivilegedController(ABC, Generic[BatchT]):
    """A scripted controller that also sees the batch, which knows robots and pipes: to compare policies with.

    Attributes:
        robot: robot that it acts for.
        task: settings of the task.
        batch_type: type of batch that it can control.
        refusal: message for a batch of another type, which says what to choose instead.
    """

    robot: RobotSpec
    task: TaskConfig
    batch_type: type[BatchT]
    refusal: ClassVar[str]

    @abstractmethod
    def act(self, observation: Floats, batch: BatchT) -> Floats:
        """Canonical actions in [-1, 1], (n, action_size), for the scaled observations of a batch, (n, size)."""

    def require(self, batch: TaskBatch) -> BatchT:
        """The batch, checked to be of the type that the controller can control.

        Raises:
            PipenavError: the batch is of another type.
        """
        if isinstance(batch, self.batch_type):
            return batch
        raise PipenavError(self.refusal)


AnyController = Controller | PrivilegedController[Any]
"""A controller of any kind."""


def actions_of(controller: AnyController, observation: Floats, batch: TaskBatch) -> Floats:
    """Canonical actions of a controller in [-1, 1], (n, action_size).

    Args:
        controller: the controller.
        observation: scaled observations that the batch gave, (n, size).
        batch: the batch; only privileged controllers see it.

    Raises:
        PipenavError: a privileged controller cannot control this type of batch.
    """
    if isinstance(controller, PrivilegedController):
        return controller.act(observation, controller.require(batch))
    return controller.act(observation)
