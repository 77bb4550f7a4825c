"""The corner task on n robots of one backend at once: the core that every environment adapter wraps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

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
        observation: scaled, (n, size).
        reward: (n,).
        outcome: a `Outcome` for each, (n,); other than RUNNING ends the episode.
        clearance: smallest laser reading, (n,) [m].
        truth: what the simulator knows.
        cut_off: whether the episode ended for want of time alone, so that it might have gone on, (n,).
    """

    observation: Floats
    reward: Floats
    outcome: NDArray[np.int8]
    clearance: Floats
    truth: Truth | SpaceTruth
    cut_off: Flags


class Sized:
    """How long observations and actions of one robot are: the same question to the batch of every task."""

    robot: RobotSpec
    _scale: Floats

    @property
    def observation_size(self) -> int:
        return len(self._scale)

    @property
    def action_size(self) -> int:
        return len(self.robot.drives)


class TaskBatch(Protocol):
    """n episodes of a task, stepped together: what adapters and stages need of it."""

    robot: RobotSpec
    n: int
    steps: Ints

    @property
    def pipes(self) -> Sequence[Pipe | None]:
        """The pipe of each robot."""
        ...

    @property
    def observation_size(self) -> int: ...

    @property
    def action_size(self) -> int: ...

    @property
    def q(self) -> Floats:
        """Configurations in the robot's own frame, (n, coordinates)."""
        ...

    def reset(self, indices: Ints | None = None) -> Floats:
        """Start new episodes for some robots (sorted, unique), or all; observations of all robots, (n, size)."""
        ...

    def stagger(self, rng: np.random.Generator) -> None:
        """Make the next episodes start at random ages, so that their time-outs do not all fall into one step."""
        ...

    def step(self, action: Floats) -> StepResult:
        """One control step of every robot under canonical actions in [-1, 1], (n, action_size)."""
        ...

    def close(self) -> None:
        """Release the backend."""
        ...
