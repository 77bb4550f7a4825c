"""A stage that keeps what its robots did, for the stages after it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.evaluation.episode_runner import EpisodeQueue
from pipenav.evaluation.locate_stage import LocateStage
from pipenav.evaluation.stage import Stage, StageStep
from pipenav.tasks.outcome import Outcome


class RecordedStage(Stage):
    """A stage whose motions and found targets are kept, by episode.

    Args:
        stage: the stage.
        queue: the source of its episodes.
        start: gives an episode by its number.
        rows: most rows of a motion; 0 to keep none, only targets.

    Attributes:
        motions: joint positions of each episode from its start to its end, (rows, joints).
        targets: targets that were found, (2,) in the canonical frame.
    """

    def __init__(self, stage: Stage, queue: EpisodeQueue[Any], start: Callable[[int], Any], rows: int) -> None:
        self.robot, self.n = stage.robot, stage.n
        self._stage, self._queue, self._start = stage, queue, start
        self._keeps = rows > 0
        self._rows = np.zeros((stage.n, rows, stage.robot.coordinates))
        self.motions: dict[int, Floats] = {}
        self.targets: dict[int, Floats] = {}

    @property
    def steps(self) -> Ints:
        return self._stage.steps

    def start(self, indices: Ints) -> None:
        self._stage.start(indices)
        if not self._keeps:
            return
        for index in indices:
            self._rows[index, 0] = self._start(max(int(self._queue.running[index]), 0)).q[0]

    def step(self) -> StageStep:
        step = self._stage.step()
        if self._keeps:
            self._keep(step)
        for index in np.flatnonzero(step.outcome != Outcome.RUNNING):
            job = int(self._queue.running[index])
            if isinstance(self._stage, LocateStage):
                self.targets.setdefault(job, self._stage.target[index].copy())
        return step

    def _keep(self, step: StageStep) -> None:
        """Keep a step, and the motions that end with it."""
        # A robot without work is stepped on beyond its time; nobody reads its rows.
        count = np.minimum(self._stage.steps, self._rows.shape[1] - 1)
        self._rows[np.arange(self.n), count] = step.q
        for index in np.flatnonzero(step.outcome != Outcome.RUNNING):
            job = int(self._queue.running[index])
            self.motions.setdefault(job, self._rows[index, : count[index] + 1].copy())

    def close(self) -> None:
        self._stage.close()
