"""A part of a passage on n robots at once, as an evaluation runs it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Floats, Ints
from pipenav.backends.messages import Truth
from pipenav.backends.spatial import SpaceTruth
from pipenav.policies.controller import AnyController, actions_of
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.batch import TaskBatch
from pipenav.tasks.outcome import Outcome


class StageStep(NamedTuple):
    """Results of a control step of n robots.

    Attributes:
        outcome: an `Outcome` for each robot, (n,); any but RUNNING ends the episode, REACHED is the stage's success.
        min_range: smallest laser reading, (n,) [m].
        truth: everything that the simulator knows.
        q: configurations after the step in the robot's own frame, (n, coordinates), from which a next stage starts.
    """

    outcome: NDArray[np.int8]
    min_range: Floats
    truth: Truth | SpaceTruth
    q: Floats


class Stage(ABC):
    """n episodes of one part of a passage, stepped together.

    A stage draws its episodes from the source that it was made with. Robots begin anew when `start` is called for them;
    a robot whose episode has ended may be stepped on until then.

    Attributes:
        robot: the robot.
        n: number of robots.
    """

    robot: RobotSpec
    n: int

    @property
    @abstractmethod
    def steps(self) -> Ints:
        """Control steps of each robot's episode so far, (n,)."""

    @abstractmethod
    def start(self, indices: Ints) -> None:
        """Begin new episodes with some robots (sorted, unique); the others are untouched."""

    @abstractmethod
    def step(self) -> StageStep:
        """Run one control period of every robot."""

    def target_of(self, index: int) -> Floats | None:  # noqa: ARG002  # of stages that locate one
        """Target that a robot's episode found, (2,) in the canonical frame; None where the stage locates none."""
        return None

    @abstractmethod
    def close(self) -> None:
        """Release the simulator."""


class TaskStage(Stage):
    """A task under a controller: the front half reaches a target, or the whole robot traverses the pipe."""

    def __init__(self, batch: TaskBatch, controller: AnyController) -> None:
        self.robot, self.n = batch.robot, batch.n
        self._batch, self._controller = batch, controller
        self._observation = np.zeros((batch.n, batch.observation_size))

    @property
    def steps(self) -> Ints:
        return self._batch.steps

    def start(self, indices: Ints) -> None:
        self._observation = self._batch.reset(indices)

    def step(self) -> StageStep:
        result = self._batch.step(actions_of(self._controller, self._observation, self._batch))
        self._observation = result.observation
        return StageStep(result.outcome, result.min_range, result.truth, self._batch.q)

    def close(self) -> None:
        self._batch.close()


class GentleStage(Stage):
    """A stage in which an episode fails as soon as the wall presses on a link harder than a limit.

    Args:
        stage: the stage.
        max_force: largest contact force on any one link [N].
    """

    def __init__(self, stage: Stage, max_force: float) -> None:
        self.robot, self.n = stage.robot, stage.n
        self._stage, self._max_force = stage, max_force

    @property
    def steps(self) -> Ints:
        return self._stage.steps

    def start(self, indices: Ints) -> None:
        self._stage.start(indices)

    def step(self) -> StageStep:
        step = self._stage.step()
        too_hard = (step.truth.contact_force > self._max_force) & (step.outcome != Outcome.PENETRATION)
        return step._replace(outcome=np.where(too_hard, Outcome.FORCE, step.outcome).astype(np.int8))

    def target_of(self, index: int) -> Floats | None:
        return self._stage.target_of(index)

    def close(self) -> None:
        self._stage.close()


def gentle(stage: Stage, max_force: float | None) -> Stage:
    """The stage with a limit on the contact force [N]; itself where there is none."""
    return stage if max_force is None else GentleStage(stage, max_force)
