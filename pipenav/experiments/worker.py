"""Program of the processes that do an experiment's jobs: one job after another, as the parent sends them.

Messages to the parent: `JobDone`, or the error that ended the job, or how much of it is done. Messages from the parent:
a job's work, or `STOP`. The pipe's end ends the process at once: there is nobody left to work for.
"""

from __future__ import annotations

import os
import queue
import threading
import time
import traceback
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from typing import Any

from pipenav.errors import PipenavError
from pipenav.processes.children import worker_end

REPORT_S = 0.2
"""Time between two reports of how much is done [s]."""

STOP = "stop"


class JobDone:
    """The message that a job has ended without an error."""


class _Orders:
    """Messages of the parent, read by a thread of its own, so that they are heard during a job."""

    def __init__(self, end: Connection[Any, Any]) -> None:
        self._end = end
        self._stop = threading.Event()
        self._heeded = False
        self._jobs: queue.Queue[Callable[..., None]] = queue.Queue()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        while True:
            try:
                message = self._end.recv()
            except (EOFError, OSError):
                os._exit(1)
            if message != STOP:
                self._jobs.put(message)
                continue
            self._stop.set()
            if not self._heeded:  # the job has not come to where it saves
                os._exit(1)

    def should_stop(self) -> bool:
        """Whether the parent has asked to stop; a job that asks will save."""
        self._heeded = True
        return self._stop.is_set()

    def next(self) -> Callable[..., None]:
        """The next job's work; waits for it."""
        self._heeded = False
        return self._jobs.get()


def main(arguments: Sequence[str]) -> None:
    end = worker_end(arguments)
    orders = _Orders(end)
    while True:
        work = orders.next()
        try:
            work(_reporting(end), orders.should_stop)
        except Exception as error:  # the parent raises it: here nobody would see it
            end.send(error if isinstance(error, PipenavError) else RuntimeError(traceback.format_exc()))
        except KeyboardInterrupt:  # a job that was stopped with nothing to save
            end.send(JobDone())
        else:
            end.send(JobDone())


def _reporting(end: Connection[Any, Any]) -> Callable[[int], None]:
    """A function that reports how much of a job is done, now and then."""
    last = [0.0]

    def report(amount: int) -> None:
        if time.monotonic() - last[0] > REPORT_S:
            last[0] = time.monotonic()
            end.send(int(amount))

    return report
