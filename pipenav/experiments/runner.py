"""Runs the trainings and evaluations of an experiment, and stops them so that the same command goes on from there."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence

from pipenav.experiments.jobs import Task
from pipenav.jobs import Event, Job, Place, ShouldStop, run_jobs

Report = Callable[[str, float, float], None]
"""Called with what just became whole (or nothing new), the share of the work that is done, and seconds since the start.
"""


def run_tasks(tasks: Sequence[Task], place: Place, report: Report, should_stop: ShouldStop) -> bool:
    """Run tasks at a place; returns False when it was asked to stop before all were done.

    Raises:
        PipenavError: a job raised it, or jobs were lost every time that they were tried.
    """
    started = time.monotonic()
    owners: dict[str, Task] = {}

    def jobs() -> Iterator[Job]:
        for task in tasks:
            for job in task.jobs(place):
                owners[job.key] = task
                yield job

    def hear(event: Event) -> None:
        task = owners[event.job.key]
        task.hear(event)
        share = sum(one.done for one in tasks) / sum(one.total for one in tasks)
        report(task.name if task.whole else "", share, time.monotonic() - started)

    try:
        return run_jobs(place, jobs(), hear, should_stop)
    finally:
        for task in tasks:
            task.close()
