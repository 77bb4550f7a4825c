"""Processes of this machine as a place: a slot is a process of its own, which ends with the driver."""

from __future__ import annotations

import contextlib
import pickle
import signal
import time
from collections import deque
from multiprocessing.connection import wait
from typing import Any

from pipenav.errors import PipenavError, shown
from pipenav.jobs.job import Done, Ending, Failed, Job, Lost, Stopped
from pipenav.jobs.place import HearProgress, Place, ShouldStop, Slots
from pipenav.jobs.worker import STOP, Finish, Order, Raised, Saved
from pipenav.processes.children import Worker, WorkerEnded, start_worker
from pipenav.processes.cores import usable_cores

MOST_PROCESSES = 1024
"""Most processes that a person can ask for: more than any machine has cores."""

LEAVING_S = 1.0
"""Time in which processes end when their pipes close [s]; what has not ended then is killed."""


class ProcessesPlace(Place):
    """Processes of this machine, as many as were asked for; they share the cores that this process may use.

    Args:
        given: number of processes.

    Raises:
        PipenavError: that is no number of processes.
    """

    def __init__(self, given: str) -> None:
        if not given.isascii() or not given.isdigit() or not 1 <= int(given) <= MOST_PROCESSES:
            raise PipenavError(f"{shown(given)} is no number of processes: choose 1 to {MOST_PROCESSES}.")
        self.processes = int(given)
        self.name = "1 process" if self.processes == 1 else f"{self.processes} processes"

    def open(self, hear: HearProgress, should_stop: ShouldStop) -> Slots:  # noqa: ARG002  # the driver asks it
        return _ProcessSlots(self.processes, hear)


class _ProcessSlots(Slots):
    """Processes, each started when a first job is given to it, and again after it was lost."""

    def __init__(self, processes: int, hear: HearProgress) -> None:
        self._processes, self._hear = processes, hear
        self._cores = max(1, usable_cores() // processes)
        self._idle: deque[Worker] = deque()
        self._busy: dict[Worker, Job] = {}
        self._asked: set[Worker] = set()

    @property
    def free(self) -> int:
        return self._processes - len(self._busy)

    @property
    def busy(self) -> tuple[Job, ...]:
        return tuple(self._busy.values())

    def give(self, job: Job) -> None:
        order = pickle.dumps(Order(job.function, job.data, min(job.cores, self._cores)))
        while True:
            worker = self._idle.popleft() if self._idle else start_worker("pipenav.jobs.worker")
            try:
                worker.send(order)
            except WorkerEnded:  # it was killed while it had nothing to do
                worker.close(0.0)
                continue
            self._busy[worker] = job
            return

    def wait(self, patience: float) -> list[Ending]:
        ends = {worker.end: worker for worker in self._busy}
        endings = []
        for end in wait(list(ends), patience):
            worker = ends[end]  # type: ignore[index]  # wait returns the very objects that it was given
            if ending := self._heard(worker):
                endings.append(ending)
        return endings

    def _heard(self, worker: Worker) -> Ending | None:
        """The end of a process's job; nothing where it was progress."""
        job, asked = self._busy[worker], worker in self._asked
        try:
            message: Any = worker.receive()
        except (WorkerEnded, pickle.UnpicklingError, EOFError):
            self._leave(worker)
            worker.close(LEAVING_S)
            return Stopped(job) if asked else Lost(job, _how_it_ended(worker.process.returncode))
        if not isinstance(message, Finish | Raised | Saved):
            self._hear(job, message)
            return None
        self._leave(worker)
        self._idle.append(worker)
        if isinstance(message, Finish):
            return Done(job, message.content)
        return Failed(job, message.error) if isinstance(message, Raised) else Stopped(job, message.content)

    def _leave(self, worker: Worker) -> None:
        del self._busy[worker]
        self._asked.discard(worker)

    def stop(self, job: Job) -> None:
        for worker in [worker for worker, its_job in self._busy.items() if its_job is job]:
            self._asked.add(worker)
            with contextlib.suppress(WorkerEnded):
                worker.send(STOP)

    def close(self) -> None:
        workers = [*self._idle, *self._busy]
        self._idle.clear()
        self._busy.clear()
        for worker in workers:
            worker.end.close()
        until = time.monotonic() + LEAVING_S
        for worker in workers:
            worker.close(max(0.0, until - time.monotonic()))


def _how_it_ended(code: int) -> str:
    """Words for the end of a process, from its exit code, which is negative for a signal."""
    if code >= 0:
        return f"its process ended with exit code {code}"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return f"its process was ended by {name}"
