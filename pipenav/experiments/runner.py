"""Runs jobs in several processes, and stops them so that the same command goes on from there."""

from __future__ import annotations

import multiprocessing
import queue
import signal
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from typing import TYPE_CHECKING

from pipenav.experiments.jobs import Job, ReportDone, ShouldStop

if TYPE_CHECKING:
    from threading import Event

POLL_S = 0.2
"""Time between two looks at the processes [s]."""

Report = Callable[[str, float, float], None]
"""Called with what just happened (or nothing new), the share of the work that is done, and seconds since the start."""

DoneQueue = queue.Queue[tuple[int, int]]
"""Messages of the processes: number of a job, and how much of it is done."""


def run_jobs(jobs: Sequence[Job], processes: int, report: Report, should_stop: ShouldStop) -> bool:
    """Run jobs in some processes; returns False when it was asked to stop before all were done.

    Raises:
        PipenavError: a job raised it.
    """
    if not jobs:
        return True
    started = time.monotonic()
    total, done = sum(job.total for job in jobs), [0] * len(jobs)
    context = multiprocessing.get_context("spawn")  # torch and thread pools do not survive a fork
    with context.Manager() as manager:
        inbox, stop = manager.Queue(), manager.Event()
        with ProcessPoolExecutor(processes, mp_context=context, initializer=_leave_signals_to_parent) as pool:
            running: dict[Future[None], int] = {
                pool.submit(_work, job.work, i, inbox, stop): i for i, job in enumerate(jobs)
            }
            while running:
                finished, _ = wait(running, timeout=POLL_S, return_when=FIRST_COMPLETED)
                _drain_inbox(inbox, done)
                if should_stop() and not stop.is_set():
                    stop.set()
                    for future in running:
                        future.cancel()
                message = ""
                for future in finished:
                    i = running.pop(future)
                    if future.cancelled():
                        continue
                    _raise_after_stopping(future, stop)
                    if not stop.is_set():
                        done[i], message = jobs[i].total, jobs[i].name
                report(message, sum(done) / total, time.monotonic() - started)
            return not stop.is_set()


def _raise_after_stopping(future: Future[None], stop: Event) -> None:
    error = future.exception()
    if error is not None and not (isinstance(error, KeyboardInterrupt) and stop.is_set()):
        stop.set()
        raise error


def _drain_inbox(inbox: queue.Queue[tuple[int, int]], done: list[int]) -> None:
    while True:
        try:
            i, amount = inbox.get_nowait()
        except queue.Empty:
            return
        done[i] = amount


def _leave_signals_to_parent() -> None:
    """Ctrl-C goes to every process of the terminal; only the parent decides what it means."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _work(work: Callable[[ReportDone, ShouldStop], None], i: int, inbox: DoneQueue, stop: Event) -> None:
    last = [0.0]

    def report(amount: int) -> None:
        if time.monotonic() - last[0] > POLL_S:
            last[0] = time.monotonic()
            inbox.put((i, amount))

    work(report, stop.is_set)
