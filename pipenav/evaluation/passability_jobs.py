"""Geometry's verdicts on the pipes of an evaluation as jobs, whose results go into the evaluation's store."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from pipenav.evaluation.part_plan import PartPlan
from pipenav.evaluation.passability import Answer, Question, answer
from pipenav.jobs import Done, Event, Job, Kept, Place, Store, run_jobs

ReportPipes = Callable[[int, int], None]
"""Called with the number of all pipes, and of those that are decided."""


def report_no_pipes(_total: int, _done: int) -> None:
    """A `ReportPipes` that reports to nobody."""


def decide(
    parts: PartPlan, failed: Sequence[Sequence[int]], store: Store, place: Place, report: ReportPipes
) -> Iterator[Answer]:
    """Decide about every pipe of an evaluation at a place; a store keeps the verdicts.

    Args:
        parts: the evaluation in parts.
        failed: numbers of the episodes that failed, within each pipe.
        store: store of the evaluation.
        place: where the jobs run.
        report: called after every pipe.

    Returns:
        The answer about each pipe, in order.

    Raises:
        JobsLost: jobs were lost every time that they were tried.
    """
    plan, total, done = parts.episodes, len(failed), 0

    def jobs() -> Iterator[Job]:
        starts = plan.disturbance.starts(plan.task)
        for number, (pipe, numbers) in enumerate(zip(plan.pipes, failed, strict=True)):
            question = Question(plan.robot, starts, pipe, plan.episodes, plan.seed, tuple(numbers))
            yield Job(parts.pipe_key(number), f"pipe {number + 1} of {total} by geometry", answer, question)

    def hear(event: Event) -> None:
        nonlocal done
        if isinstance(event, Done | Kept):
            done += 1
            report(total, done)

    run_jobs(place, jobs(), hear, store=store)
    return (Answer.from_bytes(store.read(parts.pipe_key(number))) for number in range(total))
