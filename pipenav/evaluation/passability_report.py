"""Geometry's part of the tables for the terminal: success of the possible episodes, gaps, and impossible ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from pipenav.evaluation.passability_record import Passability, PipePassability
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.report_tables import MISSING, corner_cells, empty_table, interval_text, percent_text
from pipenav.evaluation.results import Evaluation

if TYPE_CHECKING:
    from rich.console import RenderableType

MOST_PIPES = 8
"""Most pipes in each of the lists."""

TRAINED = {True: "inside", False: "outside", None: MISSING}
"""Words for whether a pipe lies inside of the policy's training."""


def passability_words(found: Passability) -> str:
    """Success of the possible episodes, and how many were not possible or not decided, in two lines."""
    of_possible = f"{percent_text(found.success_of_possible)} % of the {found.possible:,} possible episodes"
    interval = f" (95 % interval {interval_text(*found.of_possible)})" if found.possible else ""
    wrong = f"\n  {found.contradictions:,} successes contradict a proof" if found.contradictions else ""
    return (
        f"by geometry: {of_possible}{interval}; {found.gaps:,} failed although possible\n"
        f"  impossible {found.impossible:,}, possible only with overlap {found.possible_with_overlap:,}, undecided "
        f"{found.undecided:,}{wrong}"
    )


def passability_tables(evaluation: Evaluation) -> list[RenderableType]:
    """Gaps of the policy, and apart from them the pipes with episodes that were not possible; none where not asked."""
    certified = [(record, record.passability) for record in evaluation.pipes if record.passability is not None]
    kinds: list[tuple[str, Callable[[PipePassability], int]]] = [
        ("Gaps of the policy: episodes that failed although they were possible", lambda found: found.gaps),
        ("Not gaps: episodes that were impossible", lambda found: found.impossible),
        ("Not decided: episodes that failed, possible only with overlap or undecided", _open),
    ]
    return [table for title, count in kinds if (table := _list(title, certified, count))]


def _open(found: PipePassability) -> int:
    return found.possible_with_overlap + found.undecided


def _list(
    title: str, certified: Sequence[tuple[PipeRecord, PipePassability]], count: Callable[[PipePassability], int]
) -> RenderableType | None:
    """The pipes with most episodes of a kind; None where there are none."""
    pipes = sorted(((r, p) for r, p in certified if count(p)), key=lambda pair: -count(pair[1]))
    if not pipes:
        return None
    shown = f" (the first {MOST_PIPES} of {len(pipes)} pipes)" if len(pipes) > MOST_PIPES else ""
    headings = ["diameter\nmm", "angle\ndeg", "turn\n", "episodes\n", "success of\npossible %"]
    table = empty_table(f"{title}{shown}", headings, ["training\n", "geometry\n"])
    for record, found in pipes[:MOST_PIPES]:
        table.add_row(
            f"{record.diameter_mm:g}",
            *corner_cells(record),
            f"{count(found):,} of {record.episodes:,}",
            percent_text(found.successes / found.possible if found.possible else None),
            TRAINED[record.trained],
            found.verdict if found.verdict != "impossible" else f"impossible: {found.reason.partition(':')[0]}",
        )
    return table
