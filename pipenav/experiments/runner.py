"""Runs jobs in several processes, and stops them so that the same command goes on from there."""

from __future__ import annotations

import contextlib
import pickle
import time
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import wait

from pipenav.errors import PipenavError
from pipenav.experiments.jobs import Job, ShouldStop
from pipenav.experiments.worker import STOP, JobDone
from pipenav.processes.children import Worker, WorkerEnded, start_worker

POLL_S = 0.2
"""Time between two looks at the processes [s]."""

PATIENCE_S = 3.5
"""Time that the processes get to save when they are asked to stop [s]; what has not ended then is killed, and loses at
most what a training does between two savings."""

Report = Callable[[str, float, float], None]
"""Called with what just happened (or nothing new), the share of the work that is done, and seconds since the start."""


def run_jobs(jobs: Sequence[Job], processes: int, report: Report, should_stop: ShouldStop) -> bool:
    """Run jobs in some processes; returns False when it was asked to stop before all were done.

    Raises:
        PipenavError: a job raised it, or its process has ended.
    """
    if not jobs:
        return True
    with _Crew(jobs, min(processes, len(jobs))) as crew:
        started = time.monotonic()
        while crew.busy:
            if should_stop():
                crew.stop()
                return False
            message = crew.hear(POLL_S)
            report(message, crew.share, time.monotonic() - started)
    return True


class _Crew:
    """Processes at work on jobs.

    Attributes:
        busy: number of the job that each process works at.
    """

    def __init__(self, jobs: Sequence[Job], processes: int) -> None:
        self._jobs = jobs
        self._done = [0] * len(jobs)
        self._left = iter(range(len(jobs)))
        self._workers: list[Worker] = []
        self.busy: dict[Worker, int] = {}
        for _ in range(processes):
            self._workers.append(start_worker("pipenav.experiments.worker"))
            self._give(self._workers[-1])

    def __enter__(self) -> _Crew:
        return self

    def __exit__(self, *_error: object) -> None:
        for worker in self._workers:
            worker.close()

    @property
    def share(self) -> float:
        """Share of the work that is done."""
        return sum(self._done) / sum(job.total for job in self._jobs)

    def hear(self, patience: float) -> str:
        """Take what the processes say in the time given, and hand out further jobs.

        Returns:
            Name of a job that has been done, or nothing.

        Raises:
            Exception: a job raised it.
            PipenavError: a process has ended.
        """
        for worker in self._speaking(patience):
            number = self.busy[worker]
            message = self._message(worker)
            if isinstance(message, Exception):
                self.stop()
                raise message
            if not isinstance(message, JobDone):
                self._done[number] = message
                continue
            self._done[number] = self._jobs[number].total
            del self.busy[worker]
            self._give(worker)
            return self._jobs[number].name
        return ""

    def stop(self) -> None:
        """Ask the processes to save and stop, and wait for them, but not for ever."""
        until = time.monotonic() + PATIENCE_S
        for worker in list(self.busy):
            with contextlib.suppress(WorkerEnded):
                worker.send(STOP)
        while self.busy and time.monotonic() < until:
            for worker in self._speaking(max(0.0, until - time.monotonic())):
                try:
                    message = worker.receive()
                except WorkerEnded:
                    message = JobDone()
                if isinstance(message, JobDone | Exception):
                    del self.busy[worker]
        for worker in self.busy:
            worker.process.kill()

    def _give(self, worker: Worker) -> None:
        """Give a process the next job, if there is one left."""
        number = next(self._left, None)
        if number is not None:
            self.busy[worker] = number
            worker.send(self._jobs[number].work)

    def _speaking(self, patience: float) -> Iterator[Worker]:
        """Processes at work that have said something, or have ended."""
        ends = {worker.end: worker for worker in self.busy}
        for end in wait(list(ends), patience):
            yield ends[end]  # type: ignore[index]  # wait returns the very objects that it was given

    def _message(self, worker: Worker) -> JobDone | Exception | int:
        try:
            message: JobDone | Exception | int = worker.receive()
        except (WorkerEnded, pickle.UnpicklingError) as error:
            code = worker.process.wait()
            name = self._jobs[self.busy[worker]].name
            raise PipenavError(
                f"the process of {name!r} ended unexpectedly (exit code {code}): check the memory that is left, then "
                "give the same command again, with a smaller --jobs."
            ) from error
        return message
