"""The progress of an evaluation, summed over its parts."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

from pipenav.evaluation.parts import PartRows
from pipenav.evaluation.passage import ReportProgress


class _StageCount(NamedTuple):
    """Episodes that came to a stage in a part, those that are through with it, and those of them that succeeded."""

    came: int
    done: int
    successes: int


class EvaluationProgress:
    """Sums the progress of parts that run at the same time, and reports it stage by stage.

    Args:
        report: called with sums over all parts; the episodes that will come to a stage are those that have not failed
            before it as far as is known.
        total: number of all episodes.
    """

    def __init__(self, report: ReportProgress, total: int) -> None:
        self._report, self._total = report, total
        self._running: dict[str, dict[str, _StageCount]] = {}
        self._sizes: dict[str, int] = {}
        self._finished: dict[str, Counter[str]] = {}

    def runs(self, key: str, size: int, progress: tuple[str, int, int, int]) -> None:
        """Take what a part reports that runs: its key, number of episodes, and (stage, came, done, successes)."""
        stage, *counts = progress
        self._sizes[key] = size
        self._running.setdefault(key, {})[stage] = _StageCount(*counts)
        self._tell(stage)

    def lost(self, key: str) -> None:
        """Forget a part that has to be run again."""
        self._running.pop(key, None)

    def done(self, key: str, size: int, rows: PartRows) -> None:
        """Take the results of a part."""
        self.lost(key)
        for stage, part in rows.items():
            count = self._finished.setdefault(str(stage), Counter())
            count.update(gone=size - len(part.jobs), done=len(part.jobs), successes=int(part.passed.sum()))
            self._tell(str(stage))

    def _tell(self, stage: str) -> None:
        running = {key: stages[stage] for key, stages in self._running.items() if stage in stages}
        finished = self._finished.get(stage, Counter())
        gone = finished["gone"] + sum(self._sizes[key] - count.came for key, count in running.items())
        done = finished["done"] + sum(count.done for count in running.values())
        successes = finished["successes"] + sum(count.successes for count in running.values())
        if done:
            self._report(stage, self._total - gone, done, successes)
