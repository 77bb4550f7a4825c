"""n episodes of a task, stepped together: what environments and stages need of every task."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.messages import Truth
from pipenav.backends.spatial import SpaceTruth
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec


class StepResult(NamedTuple):
    """One control step of n robots.

    Attributes:
        observation: scaled observations, (n, size).
        reward: rewards, (n,).
        outcome: an `Outcome` for each robot, (n,); other than RUNNING ends the episode.
        min_range: smallest laser reading, (n,) [m].
        truth: what the simulator knows.
        cut_off: whether the episode ended for want of time alone, so that it might have gone on, (n,).
    """

    observation: Floats
    reward: Floats
    outcome: NDArray[np.int8]
    min_range: Floats
    truth: Truth | SpaceTruth
    cut_off: Flags


class TaskBatch(ABC):
    """n episodes of a task, stepped together. The caller of `step` also says, by `reset`, which robots start anew.

    Attributes:
        robot: the robot.
        n: number of robots.
        steps: control steps of each robot's episode, (n,).
    """

    robot: RobotSpec
    n: int
    steps: Ints
    _scale: Floats

    @property
    def observation_size(self) -> int:
        """Values of one robot's observation."""
        return len(self._scale)

    @property
    def action_size(self) -> int:
        """Values of one robot's action."""
        return len(self.robot.driven_actuators)

    @property
    @abstractmethod
    def pipes(self) -> Sequence[Pipe | None]:
        """The pipe of each robot; None before its first reset."""

    @property
    @abstractmethod
    def q(self) -> Floats:
        """Configurations in the robot's own frame, (n, coordinates); NaN for a base pose that leaves the plane."""

    @abstractmethod
    def reset(self, indices: Ints | None = None) -> Floats:
        """Start new episodes for some robots (sorted, unique), or all; observations of all robots, (n, size)."""

    @abstractmethod
    def step(self, action: Floats) -> StepResult:
        """Advance every robot by one control step under canonical actions in [-1, 1], (n, action_size)."""

    @abstractmethod
    def close(self) -> None:
        """Release the simulator."""


class TrainingBatch(TaskBatch):
    """Episodes that a policy can be trained on."""

    @abstractmethod
    def stagger(self, rng: np.random.Generator) -> None:
        """Make the next episodes start at random ages, so that their time-outs do not all fall into one step."""
