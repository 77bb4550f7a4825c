"""The nearest place: jobs run in this process, one after another, with all of its cores."""

from __future__ import annotations

from typing import Any

from pipenav.jobs.job import Ending, Job, ending_of
from pipenav.jobs.place import HearProgress, Place, ShouldStop, Slots
from pipenav.processes.cores import usable_cores


class HerePlace(Place):
    """This process."""

    def __init__(self, given: str = "") -> None:  # noqa: ARG002  # there is nothing to choose
        self.name = "this process"

    def open(self, hear: HearProgress, should_stop: ShouldStop) -> Slots:
        return _HereSlots(hear, should_stop)


class _HereSlots(Slots):
    """A single slot: a job that was given runs when the driver waits."""

    def __init__(self, hear: HearProgress, should_stop: ShouldStop) -> None:
        self._hear, self._should_stop = hear, should_stop
        self._job: Job | None = None
        self._stopping = False
        self.cores = usable_cores()

    @property
    def free(self) -> int:
        return int(self._job is None)

    @property
    def busy(self) -> tuple[Job, ...]:
        return () if self._job is None else (self._job,)

    def give(self, job: Job) -> None:
        self._job, self._stopping = job, False

    def wait(self, patience: float) -> list[Ending]:  # noqa: ARG002  # the job itself takes the time
        if self._job is None:
            return []
        ending = ending_of(self._job, self)
        self._job = None
        return [ending]

    def stop(self, job: Job) -> None:
        self._stopping = self._stopping or job is self._job

    def close(self) -> None:
        self._job = None

    def report(self, progress: Any) -> None:
        """Hear the progress of the job that runs, see `JobControl`."""
        assert self._job is not None
        self._hear(self._job, progress)

    def should_stop(self) -> bool:
        """Whether the job that runs shall stop, see `JobControl`."""
        return self._stopping or self._should_stop()
