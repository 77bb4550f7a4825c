"""Who decides in an episode: a controller that sees what a robot's sensors give, or one that also knows the truth."""

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
    """Anything that acts on observations alone.

    Attributes:
        robot: the robot that it acts for.
        task: settings of the task, with the control mode and the observation that it wants.
    """

    @property
    def robot(self) -> RobotSpec: ...

    @property
    def task(self) -> TaskConfig: ...

    def act(self, observation: Floats) -> Floats:
        """Canonical actions in [-1, 1], (n, action_size), for scaled observations, (n, size)."""
        ...


class PrivilegedController(ABC, Generic[BatchT]):
    """A scripted controller that also looks at the batch, where robots and pipes are known: to compare policies with.

    Attributes:
        robot: the robot that it acts for.
        task: settings of the task.
        batch_type: the kind of batch that it can look at.
        only: what to choose where it is given another, as the end of a sentence.
    """

    robot: RobotSpec
    task: TaskConfig
    batch_type: type[BatchT]
    only: ClassVar[str]

    @abstractmethod
    def act(self, observation: Floats, batch: BatchT) -> Floats:
        """Canonical actions in [-1, 1], (n, action_size), for scaled observations, (n, size), of a batch."""

    def require(self, batch: TaskBatch) -> BatchT:
        """The batch, where the controller can look at it.

        Raises:
            PipenavError: it is of another kind.
        """
        if isinstance(batch, self.batch_type):
            return batch
        raise PipenavError(self.only)


AnyController = Controller | PrivilegedController[Any]


def actions_of(controller: AnyController, observation: Floats, batch: TaskBatch) -> Floats:
    """A controller's actions in [-1, 1], (n, action_size).

    Args:
        controller: who decides.
        observation: scaled observations, (n, size), as the batch gave them.
        batch: the robots.

    Raises:
        PipenavError: a privileged controller cannot look at this kind of batch.
    """
    if isinstance(controller, PrivilegedController):
        return controller.act(observation, controller.require(batch))
    return controller.act(observation)
