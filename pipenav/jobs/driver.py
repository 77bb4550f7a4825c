"""Drives jobs at a place: keeps its slots busy, tries lost jobs again, and stops so that nothing finished is lost."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from typing import Any

from pipenav.errors import PipenavError
from pipenav.jobs.job import Done, Ending, Event, Failed, Job, Kept, Lost, Progressed
from pipenav.jobs.place import Place, ShouldStop, Slots
from pipenav.jobs.store import Store

POLL_S = 0.2
"""Longest time between two questions whether to stop [s]."""

PATIENCE_S = 3.5
"""Time that jobs get to save when they are asked to stop [s]; what has not ended then is ended as it is."""

ATTEMPTS = 3
"""Times that a job is tried whose process or machine ends under it."""

MOST_NAMED = 5
"""Most lost jobs that a message names."""

Hear = Callable[[Event], bool | None]
"""Called with everything that happens to a job; True for a job's progress asks this job to save and stop."""


def hear_nothing(_event: Event) -> None:
    """A `Hear` for nobody."""


def never() -> bool:
    """A `ShouldStop` that is never asked to."""
    return False


class JobsLost(PipenavError):
    """Jobs whose processes or machines ended under them each time that they were tried."""

    def __init__(self, lost: list[Lost]) -> None:
        named = "; ".join(f"{end.job.name} ({end.how})" for end in lost[:MOST_NAMED])
        more = f"; and {len(lost) - MOST_NAMED} more" if len(lost) > MOST_NAMED else ""
        super().__init__(
            f"{'a job was' if len(lost) == 1 else f'{len(lost)} jobs were'} lost {ATTEMPTS} times: {named}{more}; the "
            "others are done: check the memory that is left, then give the same command again to do the rest."
        )


def run_jobs(
    place: Place,
    jobs: Iterable[Job],
    hear: Hear = hear_nothing,
    should_stop: ShouldStop = never,
    store: Store | None = None,
) -> bool:
    """Run jobs at a place; they are asked for one by one, as slots become free.

    Args:
        place: where they run.
        jobs: the jobs, which may be endless or be made while earlier ones run.
        hear: called with every event.
        should_stop: whether to stop; the jobs that run may save first.
        store: keeps what the jobs return, and has what earlier drivers kept.

    Returns:
        False where it was asked to stop before all jobs were done.

    Raises:
        Exception: a job raised it; the others were asked to save and stop.
        JobsLost: some jobs were lost every time; all others are done.
        PipenavError: the place cannot be reached.
    """
    left = _left(jobs, hear, store)
    first = next(left, None)
    if first is None:
        return True

    def hear_progress(job: Job, progress: Any) -> None:
        if hear(Progressed(job, progress)):
            slots.stop(job)

    with place.open(hear_progress, should_stop) as slots:
        return _Run(slots, chain([first], left), hear, store).until_done(should_stop)


def _left(jobs: Iterable[Job], hear: Hear, store: Store | None) -> Iterator[Job]:
    """The jobs whose results are not kept."""
    for job in jobs:
        if store is not None and store.has(job.key):
            hear(Kept(job))
        else:
            yield job


class _Run:
    """Jobs on their way through the slots of a place."""

    def __init__(self, slots: Slots, left: Iterator[Job], hear: Hear, store: Store | None) -> None:
        self._slots, self._left, self._hear, self._store = slots, left, hear, store
        self._again: list[Job] = []
        self._tried: Counter[str] = Counter()
        self._lost: list[Lost] = []

    def until_done(self, should_stop: ShouldStop) -> bool:
        """Keep every slot busy until no job is left; returns False where it was asked to stop before."""
        while True:
            if should_stop():
                self._stop()
                return False
            self._fill()
            if not self._slots.busy:
                break
            for ending in self._slots.wait(POLL_S):
                self._take(ending)
        if self._lost:
            raise JobsLost(self._lost)
        return True

    def _fill(self) -> None:
        while self._slots.free > 0:
            job = self._again.pop(0) if self._again else next(self._left, None)
            if job is None:
                return
            self._tried[job.key] += 1
            self._slots.give(job)

    def _take(self, ending: Ending) -> None:
        """Keep what a job returned, try a lost one again, and raise what one raised."""
        job = ending.job
        if isinstance(ending, Done) and self._store is not None:
            self._store.write(job.key, ending.content)
        self._hear(ending)
        if isinstance(ending, Failed):
            self._stop()
            raise ending.error
        if not isinstance(ending, Lost):
            del self._tried[job.key]
        elif self._tried[job.key] < ATTEMPTS:
            self._again.append(job)
        else:
            self._lost.append(ending)

    def _stop(self) -> None:
        """Ask the jobs that run to save and stop, and wait for them, but not for ever."""
        until = time.monotonic() + PATIENCE_S
        for job in self._slots.busy:
            self._slots.stop(job)
        while self._slots.busy and (patience := until - time.monotonic()) > 0:
            for ending in self._slots.wait(patience):
                if isinstance(ending, Done) and self._store is not None:
                    self._store.write(ending.job.key, ending.content)
                self._hear(ending)
