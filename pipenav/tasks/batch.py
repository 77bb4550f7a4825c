"""n episodes of a task, stepped together: the interface that environments and evaluation use."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.messages import Truth
from pipenav.backends.spatial import SpaceTruth
from pipenav.errors import PipenavError
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec


class StepResult(NamedTuple):
    """Result of one control step of n robots.

    Attributes:
        observation: scaled observations, (n, size).
        reward: rewards, (n,).
        outcome: an `Outcome` for each robot, (n,); any other than `RUNNING` ends the episode.
        min_range: smallest laser reading, (n,) [m].
        truth: quantities that only the simulator knows.
        cut_off: whether the time limit alone ended the episode, which could otherwise have gone on, (n,).
    """

    observation: Floats
    reward: Floats
    outcome: NDArray[np.int8]
    min_range: Floats
    truth: Truth | SpaceTruth
    cut_off: Flags


Facts = TypeVar("Facts")


class Assessment(NamedTuple, Generic[Facts]):
    """Assessment of one control step.

    Attributes:
        facts: quantities that the task's reward depends on.
        outcome: an `Outcome` for each robot, (n,).
    """

    facts: Facts
    outcome: NDArray[np.int8]


class TaskBatch(ABC):
    """n episodes of a task, stepped together.

    Episodes that ended do not start anew by themselves: the caller of `step` resets their robots.

    Attributes:
        robot: the robot.
        n: number of robots.
        steps: control steps of each robot's episode so far, (n,).
    """

    robot: RobotSpec
    n: int
    steps: Ints
    _scale: Floats

    @property
    def observation_size(self) -> int:
        """Number of values in one robot's observation."""
        return len(self._scale)

    @property
    def action_size(self) -> int:
        """Number of values in one robot's action."""
        return len(self.robot.driven_actuators)

    @property
    @abstractmethod
    def pipes(self) -> Sequence[Pipe | None]:
        """Pipe of each robot; None before its first reset."""

    @property
    @abstractmethod
    def q(self) -> Floats:
        """Configurations in the robot's own frame, (n, coordinates); a base pose that leaves the plane is NaN."""

    @abstractmethod
    def reset(self, indices: Ints | None = None) -> Floats:
        """Start new episodes for some robots.

        Args:
            indices: which robots, sorted and unique; all by default.

        Returns:
            Observations of all robots, (n, size).
        """

    @abstractmethod
    def step(self, action: Floats) -> StepResult:
        """Advance every robot by one control step.

        Args:
            action: canonical actions in [-1, 1], (n, action_size).
        """

    @abstractmethod
    def close(self) -> None:
        """Release the simulator."""


class TrainingBatch(TaskBatch):
    """A batch that a policy can be trained on."""

    @property
    def driven(self) -> Flags:
        """Whether each robot's action counted in the last step, (n,); all do where nobody else drives."""
        return np.ones(self.n, bool)

    @abstractmethod
    def begin(self, action: Floats) -> Callable[[], None]:
        """Begin a control step: what is returned moves the robots, and may be called in another thread.

        Until it has returned nothing else of this batch may be called; then comes `end`.

        Args:
            action: canonical actions in [-1, 1], (n, action_size).
        """

    def carried_out(self, rows: Ints, told: Floats) -> Floats:  # noqa: ARG002  # the signature of the interface
        """Take in that some robots were told something else than their actions, between the call of what `begin` gave
        and `end`: observations that hold the last action hold what was really done.

        Args:
            rows: which robots, sorted and unique, (k,).
            told: set-points of joints, then speeds of wheels, in the robots' own frames, (k, actuators).

        Returns:
            Canonical actions in [-1, 1] that come nearest to it, (k, action_size).

        Raises:
            PipenavError: the task has no such actions.
        """
        raise PipenavError("robots of this task are told nothing but their actions.")

    @abstractmethod
    def end(self) -> StepResult:
        """End the control step that `begin` began, once the robots have moved."""

    def step(self, action: Floats) -> StepResult:
        self.begin(action)()
        return self.end()

    @abstractmethod
    def stagger(self, rng: np.random.Generator) -> None:
        """Let the next episodes start at random ages, so that their time-outs do not all fall into one step."""
