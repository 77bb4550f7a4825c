"""Program of the processes of a `ProcessesPlace`: one job after another, as the driver sends them.

Messages to the driver: the end of a job, as `Finish`, `Raised` or `Saved`, or anything else as its progress. Messages
from the driver are bytes: `STOP`, or a pickled `Order`, so that one that cannot be read here is the job's failure and
not the process's. The pipe's end ends the process at once: there is nobody left to work for.
"""

from __future__ import annotations

import os
import pickle
import queue
import threading
import time
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

from pipenav.jobs.job import Done, Failed, Job, JobFunction, Lost, ending_of, portable
from pipenav.processes.children import worker_end

REPORT_S = 0.2
"""Time between two reports of a job's progress [s]."""

STOP = b"stop"


class Order(NamedTuple):
    """A job as a process gets it: function, data, and cores that it may use."""

    function: JobFunction
    data: Any
    cores: int


class Finish(NamedTuple):
    """The message that a job is done, with what its function returned."""

    content: bytes


class Raised(NamedTuple):
    """The message that a job raised."""

    error: Exception


class Saved(NamedTuple):
    """The message that a job was stopped and has saved, with what it sends."""

    content: bytes


class Throttle:
    """A question that is answered by yes now and then."""

    def __init__(self, period: float = REPORT_S) -> None:
        self._period, self._last = period, 0.0

    def __call__(self) -> bool:
        """Whether a period has gone by since the last yes."""
        now = time.monotonic()
        if now - self._last < self._period:
            return False
        self._last = now
        return True


class _Driver:
    """The driver, as its worker sees it: its messages are read by a thread, so that they are heard during a job."""

    def __init__(self, end: Connection[Any, Any]) -> None:
        self._end = end
        self._stop = threading.Event()
        self._working = self._heeded = False
        self._orders: queue.Queue[bytes] = queue.Queue()
        self._due = Throttle()
        self.cores = 1
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        while True:
            try:
                message: bytes = self._end.recv()
            except (EOFError, OSError):
                os._exit(1)
            if message != STOP:
                self._heeded, self._working = False, True
                self._stop.clear()
                self._orders.put(message)
            elif self._working:
                self._stop.set()
                if not self._heeded:  # the job has not come to where it saves
                    os._exit(1)

    def next(self) -> Order:
        """The next job; waits for it."""
        order: Order = pickle.loads(self._orders.get())
        self.cores = order.cores
        return order

    def report(self, progress: Any) -> None:
        """Send how far the job is, now and then."""
        if self._due():
            self._end.send(progress)

    def should_stop(self) -> bool:
        """Whether the driver has asked to stop; a job that asks will save."""
        self._heeded = True
        return self._stop.is_set()

    def send(self, ending: Finish | Raised | Saved) -> None:
        """Send the end of the job."""
        self._working = False
        self._end.send(ending)


def main(arguments: Sequence[str]) -> None:
    driver = _Driver(worker_end(arguments))
    while True:
        driver.send(_answer(driver))


def _answer(driver: _Driver) -> Finish | Raised | Saved:
    """Do the next job; its end as a message."""
    try:
        order = driver.next()
    except Exception as error:  # its function or its data is not to be found here
        return Raised(portable(error))
    ending = ending_of(Job("", "", order.function, order.data), driver)
    assert not isinstance(ending, Lost)  # a job that is done here cannot be
    if isinstance(ending, Failed):
        return Raised(portable(ending.error))
    return Finish(ending.content) if isinstance(ending, Done) else Saved(ending.content)
