"""The traverse task in the plane with robots that recover from jams by themselves, see `recovery`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Command
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.batch import StepResult
from pipenav.tasks.rolling.clamp import check_robot
from pipenav.tasks.rolling.recovery import Recovery
from pipenav.tasks.task import EpisodeSource
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import TraverseEpisodes


class RecoveringBatch(TraverseBatch):
    """n episodes of the traverse task; while a robot recovers, the patience with it does not run out.

    Raises:
        PipenavError: as `TraverseBatch`, or the robot cannot clamp.
    """

    def __init__(
        self,
        robot: RobotSpec,
        config: TraverseConfig,
        simulator: Simulator,
        n: int,
        source: EpisodeSource[TraverseEpisodes],
    ) -> None:
        check_robot(robot)
        super().__init__(robot, config, simulator, n, source)
        self._recovery = Recovery(robot, n)
        self._radius = np.zeros(n)
        self._driven = np.ones(n, bool)
        self._told: Floats

    @property
    def driven(self) -> Flags:
        return self._driven

    def reset(self, indices: Ints | None = None) -> Floats:
        observation = super().reset(indices)
        indices = np.arange(self.n) if indices is None else indices
        self._recovery.start(indices)
        for i in indices:
            pipe = self.pipes[i]
            assert pipe is not None
            self._radius[i] = pipe.narrowest / 2
        return observation

    def begin(self, action: Floats) -> Callable[[], None]:
        self._driven = ~self._recovery.busy
        step = super().begin(action)
        if len(rows := np.flatnonzero(self._recovery.busy)):
            self.carried_out(rows, self._told)
        return step

    def end(self) -> StepResult:
        result = super().end()
        self._recovery.sense(self._felt, self._radius, self._set_points)
        self._tracker.reset_patience(self._recovery.busy)
        return result

    def _command(self, action: Floats) -> Command:
        command = super()._command(action)
        if len(rows := np.flatnonzero(self._recovery.busy)):
            self._told = self._recovery.command(rows, self._felt)
            command.values[rows] = self._told
        return command
