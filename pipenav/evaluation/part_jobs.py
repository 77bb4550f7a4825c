"""The parts of an evaluation as jobs, whose results go into a store part by part."""

from __future__ import annotations

from collections.abc import Iterator

from pipenav.evaluation.part_plan import PartPlan, Shard
from pipenav.evaluation.parts import PartResult, run_part
from pipenav.evaluation.passage import ReportProgress
from pipenav.evaluation.progress import EvaluationProgress
from pipenav.jobs import Done, Event, Job, Lost, Place, Progressed, Store, run_jobs
from pipenav.jobs.here import HerePlace


class PartJobs:
    """Runs the parts of an evaluation that a store lacks.

    Args:
        parts: the evaluation in parts.
        store: keeps each part as it is finished.
        shard: share of the parts to run; None for all.
    """

    def __init__(self, parts: PartPlan, store: Store, shard: Shard | None = None) -> None:
        self._parts, self._store = parts, store
        self._mine = [i for i in range(parts.count) if shard is None or shard.has(i)]
        self._ranges: dict[str, range] = {}

    def run(self, place: Place, report: ReportProgress) -> None:
        """Run them at a place.

        Raises:
            JobsLost: parts were lost every time that they were tried.
            PipenavError: a part raised it.
        """
        run_jobs(place, self.jobs(isinstance(place, HerePlace), report), self.hear)

    def jobs(self, together: bool, report: ReportProgress) -> Iterator[Job]:
        """A job for each part that is missing.

        Args:
            together: make one job of parts in a row, where that changes nothing but the time taken.
            report: called with sums over all parts.
        """
        self._progress = EvaluationProgress(report, self.episodes)
        kept = [True] * self._parts.count
        for index in self._mine:
            content = self._store.read(self._parts.key(index))
            kept[index] = content is not None
            if content is not None:
                self._progress.done("", self._size(range(index, index + 1)), PartResult.from_bytes(content).rows)
        for numbers in self._parts.missing(kept, together):
            first, last = numbers.start + 1, numbers.stop
            name = f"part {first}" if first == last else f"parts {first} to {last}"
            key = self._parts.key(numbers.start)
            self._ranges[key] = numbers
            of = f"{name} of {self._parts.count} of the evaluation"
            yield Job(key, of, run_part, self._parts.part(numbers.start, numbers.stop))

    def _size(self, numbers: range) -> int:
        """Number of episodes of some parts in a row."""
        return self._parts.bounds[numbers.stop] - self._parts.bounds[numbers.start]

    @property
    def episodes(self) -> int:
        """Number of episodes of all these parts."""
        bounds = self._parts.bounds
        return sum(bounds[index + 1] - bounds[index] for index in self._mine)

    def hear(self, event: Event) -> None:
        """Hear of one of the jobs, and keep the results of one that is done."""
        key = event.job.key
        if isinstance(event, Progressed):
            self._progress.runs(key, self._size(self._ranges[key]), event.progress)
        elif isinstance(event, Lost):
            self._progress.lost(key)
        elif isinstance(event, Done):
            self._keep(key, event.content)

    def _keep(self, key: str, content: bytes) -> None:
        """Put the results of a job into the store, each part by itself."""
        numbers = self._ranges.pop(key)
        bounds, result = self._parts.bounds, PartResult.from_bytes(content)
        for index in numbers:
            alone = content if len(numbers) == 1 else result.between(bounds[index], bounds[index + 1]).to_bytes()
            self._store.write(self._parts.key(index), alone)
        self._progress.done(key, self._size(numbers), result.rows)
