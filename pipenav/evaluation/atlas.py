"""Files of an evaluation besides its record: failed episodes one by one, and the page with their pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.failures import FILE, Failure, Failures, failed_episodes, with_poses
from pipenav.evaluation.html_report import Pictured, evaluation_page
from pipenav.evaluation.replay import Replayed, Replayer
from pipenav.evaluation.results import Evaluation
from pipenav.jobs import Store

PAGE = "report.html"

MOST_FAILURES = 400
"""Most failed episodes that are run again for their poses and pictures; the others are classed by their end alone."""

SHARE = 0.2
"""Most episodes that are run again, as a share of all: the time that the pictures cost."""

LEAST = 200
"""Episodes that are run again however few there are."""

MOST_PIPES = 400
"""Most pipes of which one episode is run again for a picture."""


ReportProgress = Callable[[int, int], None]
"""Called with the episodes that were run again and their number in all."""


def atlas_files(
    checked: CheckedEvaluation,
    evaluation: Evaluation,
    store: Store,
    folder: Path,
    report_progress: ReportProgress = lambda _done, _total: None,
) -> dict[str, bytes]:
    """Contents of the page and of the list of failed episodes, by the names of the files.

    Args:
        checked: the evaluation, before it was run.
        evaluation: its results.
        store: its parts, all of them.
        folder: its folder, for the command that the page shows.
        report_progress: see `ReportProgress`.
    """
    failures = failed_episodes(checked, store)
    replayer, plan = Replayer(checked), checked.parts.episodes
    numbers = _chosen(failures, evaluation) if replayer.quick else []
    replayed: dict[int, Replayed] = {}
    for one in replayer.run(numbers):
        replayed[one.number] = one
        report_progress(len(replayed), len(numbers))
    failures = with_poses(failures, replayed.values(), plan.robot)
    again = f"pipenav view --eval {folder} --episode N"
    page = evaluation_page(evaluation, Pictured(plan.robot, plan.pipes, failures, replayed, again))
    record = Failures(schema=1, failures=tuple(failures))
    return {FILE: record.to_json().encode("utf-8"), PAGE: page.encode("utf-8")}


def _chosen(failures: Sequence[Failure], evaluation: Evaluation) -> list[int]:
    """Numbers of the episodes to run again: failed ones, taken from all pipes in turn, and one of every other pipe."""
    most = min(MOST_FAILURES, max(LEAST, int(SHARE * evaluation.episodes)))
    turns: dict[int, int] = {}
    ranked = []
    for failure in failures:
        turns[failure.pipe] = turns.get(failure.pipe, -1) + 1
        ranked.append((turns[failure.pipe], failure.number))
    chosen = [number for _, number in sorted(ranked)[:most]]
    each, seen = evaluation.episodes_per_pipe, {number // evaluation.episodes_per_pipe for number in chosen}
    others = [pipe for pipe in range(len(evaluation.pipes)) if pipe not in seen]
    return chosen + [pipe * each for pipe in others[:MOST_PIPES]]
