"""A stage that records what its robots did, for the stages after it and for audits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.evaluation.episode_runner import EpisodeQueue
from pipenav.evaluation.stage import Stage, StageStep
from pipenav.tasks.outcome import Outcome

HearMotion = Callable[[int, bool, Floats], None]
"""Called once for each episode as it ends: its number in the queue, whether it succeeded, and its joint positions from
its start to its end, (rows, joints), which are overwritten afterwards."""


class RecordedStage(Stage):
    """A stage whose motions are told, and whose found targets are kept, by episode.

    Args:
        stage: the stage.
        queue: the source of its episodes.
        start: gives an episode by its number.
        rows: most rows of a motion.
        hear: hears every motion; None to record none, only targets.

    Attributes:
        targets: targets that were found, (2,) in the canonical frame.
    """

    def __init__(
        self,
        stage: Stage,
        queue: EpisodeQueue[Any],
        start: Callable[[int], Any],
        rows: int,
        hear: HearMotion | None,
    ) -> None:
        self.robot, self.n = stage.robot, stage.n
        self._stage, self._queue, self._start, self._hear = stage, queue, start, hear
        self._rows = np.zeros((stage.n, rows if hear else 0, stage.robot.coordinates))
        self._heard: set[int] = set()
        self.targets: dict[int, Floats] = {}

    @property
    def steps(self) -> Ints:
        return self._stage.steps

    def start(self, indices: Ints) -> None:
        self._stage.start(indices)
        if self._hear is None:
            return
        for index in indices:
            self._rows[index, 0] = self._start(max(int(self._queue.running[index]), 0)).q[0]

    def step(self) -> StageStep:
        step = self._stage.step()
        if self._hear is not None:
            self._record(step, self._hear)
        for index in np.flatnonzero(step.outcome != Outcome.RUNNING):
            job = int(self._queue.running[index])
            if (target := self._stage.target_of(int(index))) is not None:
                self.targets.setdefault(job, target.copy())
        return step

    def _record(self, step: StageStep, hear: HearMotion) -> None:
        """Record a step, and tell the motions that end with it."""
        # A robot without work is stepped on beyond its time; nobody reads its rows.
        count = np.minimum(self._stage.steps, self._rows.shape[1] - 1)
        self._rows[np.arange(self.n), count] = step.q
        for index in np.flatnonzero(step.outcome != Outcome.RUNNING):
            job = int(self._queue.running[index])
            if job not in self._heard:
                self._heard.add(job)
                hear(job, bool(step.outcome[index] == Outcome.REACHED), self._rows[index, : count[index] + 1])

    def close(self) -> None:
        self._stage.close()
