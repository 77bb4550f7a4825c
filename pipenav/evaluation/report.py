"""An evaluation as files and as tables for the terminal. docs/formats/evaluation-folder.md describes the files."""

from __future__ import annotations

import csv
import errno
import io
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.drawing.style import png
from pipenav.errors import FileProblem
from pipenav.evaluation.coarse import coarse
from pipenav.evaluation.folder import RECORD
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.map_figure import map_figure
from pipenav.evaluation.passability_record import PipePassability
from pipenav.evaluation.passability_report import passability_tables, passability_words
from pipenav.evaluation.pipe_results import DiameterRecord, PipeRecord, by_diameter
from pipenav.evaluation.report_tables import MISSING, corner_cells, empty_table, interval_text, percent_text
from pipenav.evaluation.results import Evaluation
from pipenav.evaluation.success_figure import success_figure
from pipenav.evaluation.summary import circumstances, headline
from pipenav.storage.atomic_files import atomic_write_all, prepare_folder
from pipenav.storage.atomic_folder import write_folder
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

FILES = {
    "eval.json": "everything, for programs",
    "eval.csv": "one row per pipe",
    "success.png": "success over the corner angle, a panel per diameter; of every route, a row each",
    "map.png": "success by diameter and angle, or by diameter and route",
}
"""Files of every evaluation folder, each with one line that says what it is."""

MORE_FILES = {
    "report.html": "a page with a map to click, pictures of episodes and all failures, for a browser",
    "failures.json": "every failed episode: how, when, where and in which pose it ended",
}
"""Files that `pipenav eval` adds, which runs some episodes again for them."""

WORST_PIPES = 8
"""Most pipes in the list of the worst ones."""

CONTACT_NOTE = (
    "Mean steps and time: of successful episodes. Least range: smallest reading of\n"
    "the laser at the tip, which can be large while another part of the robot\n"
    "touches. Overlap: how deep a part sinks into the simulated wall."
)
"""Text below the table of motion and contact."""

NOT_AS_A_WHOLE = (errno.EBUSY, errno.EXDEV, errno.EACCES, errno.EPERM, errno.EROFS)
"""Errors of a folder that cannot be replaced itself: the root of a file system, or in a folder that is read-only."""


def write_evaluation(folder: Path, evaluation: Evaluation, more: Mapping[str, bytes] | None = None) -> None:
    """Write the evaluation folder; an older one is replaced as a whole, and other files in it are kept.

    A folder that held no evaluation yet, only other files, gets the files one by one.

    Args:
        folder: the folder.
        evaluation: the evaluation.
        more: contents of those of `MORE_FILES` that there are, by name.

    Raises:
        FileProblem: the folder or a file cannot be written.
    """
    contents = {
        "eval.json": evaluation.to_json().encode("utf-8"),
        "eval.csv": pipes_csv(evaluation.pipes).encode("utf-8"),
        "success.png": png(success_figure(evaluation)),
        "map.png": png(map_figure(evaluation)),
    }
    prepare_folder(folder)
    files = {name: contents[name] for name in FILES} | dict(more or {})
    if not (folder / RECORD).is_file() or not _replaced(folder, files):
        atomic_write_all({folder / name: content for name, content in files.items()})


def _replaced(folder: Path, files: dict[str, bytes]) -> bool:
    """Whether an older evaluation folder could be replaced as a whole."""

    def write(draft: Path) -> None:
        for name, content in files.items():
            (draft / name).write_bytes(content)

    try:
        write_folder(folder.resolve(), "evaluation folder", RECORD, [*FILES, *MORE_FILES], write)
    except FileProblem as problem:
        if isinstance(problem.__cause__, OSError) and problem.__cause__.errno in NOT_AS_A_WHOLE:
            return False
        raise
    return True


def pipes_csv(pipes: Sequence[PipeRecord]) -> str:
    """Text of eval.csv: a row for each pipe with the keys of eval.json, failures as `limit=3 timeout=1`."""
    text = io.StringIO()
    kept = [name for name in PipeRecord.model_fields if name not in ("passability", "trained")]
    columns = [*kept, *PipeRecord.model_computed_fields]
    if any(record.passability is not None for record in pipes):
        columns += [*PipePassability.model_fields, "trained"]
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    for record in pipes:
        failures = " ".join(f"{reason}={count}" for reason, count in record.failures.items())
        row = record.model_dump() | {"failures": failures}
        writer.writerow(row | row.pop("passability", {}))
    return text.getvalue()


def evaluation_table(evaluation: Evaluation) -> RenderableType:
    """A headline, two tables by diameter and the list of the worst pipes, for a terminal of 100 columns."""
    from rich.console import Group
    from rich.padding import Padding
    from rich.text import Text

    title = Text(headline(evaluation), style="bold")
    where = Text(circumstances(evaluation), style="dim")
    shown, rounded = coarse(evaluation)
    if rounded:
        where.append(f"\n{rounded}")
    p99 = evaluation.penetration_p99_m
    if p99 is not None:
        where.append(f"\noverlap with the wall at most {m_to_mm(p99):.2f} mm in 99 % of the episodes")
    if evaluation.force_p99_n is not None:
        where.append(f"\npeak force at most {evaluation.force_p99_n:.0f} N in 99 % of the episodes")
    if evaluation.audit is not None:
        where.append(f"\n{evaluation.audit.words}")
    if evaluation.passability is not None:
        where.append(f"\n{passability_words(evaluation.passability)}")
    note = Text(CONTACT_NOTE, style="dim")
    certified = passability_tables(evaluation)
    parts = (where, _successes(shown), Group(_contacts(shown), note), _worst(evaluation.pipes), *certified)
    return Group(title, *(Padding(part, (0, 0, 1, 0), expand=False) for part in parts))


class _Column(NamedTuple):
    """A column of the table of successes: its heading, and the cell of a row."""

    heading: str
    cell: Callable[[DiameterRecord], str]


def _columns(pipes: Sequence[PipeRecord]) -> list[_Column]:
    """Columns of the stages that were run, and of the thesis's figures beside them."""
    located = any(record.located is not None for record in pipes)
    reached = any(record.reach_attempts is not None for record in pipes)
    rear = any(record.rear_attempts is not None for record in pipes)
    traversed = any(record.traverse_attempts is not None for record in pipes)
    columns = [_Column("episodes\n", lambda row: f"{row.episodes:,}")]
    if located:
        columns.append(_Column("located\n%", lambda row: percent_text(row.located_share)))
    if reached:
        heading = "reach\n%" if located or rear else "success\n%"
        columns += [
            _Column(heading, lambda row: percent_text(row.reach_success)),
            _Column("95 %\ninterval", lambda row: interval_text(row.reach_success_low, row.reach_success_high)),
            _Column("thesis\n%", lambda row: _number(row.thesis_percent, 0)),
        ]
    if rear:
        columns.append(_Column("rear\n%", lambda row: percent_text(row.rear_success)))
    if traversed:
        columns += [
            _Column("success\n%", lambda row: percent_text(row.traverse_success)),
            _Column("95 %\ninterval", lambda row: interval_text(row.traverse_success_low, row.traverse_success_high)),
        ]
    return columns


def _successes(evaluation: Evaluation) -> Table:
    """Success by diameter: the stages that were run, the thesis's figures, why episodes failed."""
    pipes = evaluation.pipes
    columns = _columns(pipes)
    headings = ["diameter\nmm", *(column.heading for column in columns)]
    table = empty_table("Success by diameter", headings, ["failed episodes\n"])

    def cells(row: DiameterRecord) -> list[str]:
        return [column.cell(row) for column in columns]

    for row, records in zip(evaluation.diameters, by_diameter(pipes).values(), strict=True):
        table.add_row(f"{row.diameter_mm:g}", *cells(row), _failures(records))
    if len(evaluation.diameters) > 1:
        table.add_section()
        table.add_row("all", *cells(DiameterRecord.of(pipes)), _failures(pipes))
    return table


def _contacts(evaluation: Evaluation) -> Table:
    """Steps and contact of the episodes of each diameter, and the pipe in which most of them failed."""
    headings = ["diameter\nmm", "mean\nsteps", "mean\ntime s", "least\nrange mm", "peak\nforce N"]
    headings += ["contact\n% of time", "deepest\noverlap mm"]
    table = empty_table("Motion and contact by diameter", headings, ["worst pipe and\nits success"])
    for diameter, records in by_diameter(evaluation.pipes).items():
        steps = [(r.mean_steps, r.successes) for r in records if r.mean_steps is not None]
        contact = [(r.contact_time_share, r.episodes) for r in records if r.contact_time_share is not None]
        table.add_row(
            f"{diameter:g}",
            *_steps_and_seconds(_weighted_mean(steps)),
            _number(_extreme(min, [r.min_range_m for r in records]), 1, 1000),
            _number(_extreme(max, [r.peak_force_n for r in records]), 1),
            percent_text(_weighted_mean(contact)),
            _number(_extreme(max, [r.max_penetration_m for r in records]), 2, 1000),
            _worst_pipe(records),
        )
    return table


def _worst(pipes: Sequence[PipeRecord]) -> RenderableType:
    """The pipes in which most episodes failed."""
    from rich.text import Text

    failing = sorted((record for record in pipes if record.success < 1), key=lambda record: record.success)
    if not failing:
        return Text("Every episode succeeded in every pipe.", style="green")
    shown = failing[:WORST_PIPES]
    title = f"The {len(shown)} worst of {len(failing)} pipes" if len(failing) > len(shown) else "Pipes"
    headings = ["diameter\nmm", "angle\ndeg", "turn\n", "success\n%", "95 %\ninterval", "mean\ntime s"]
    headings += ["least\nrange mm", "force\nN"]
    table = empty_table(f"{title} with failures", headings, ["failed episodes\n"])
    for record in shown:
        table.add_row(
            f"{record.diameter_mm:g}",
            *corner_cells(record),
            percent_text(record.success),
            interval_text(*wilson(record.successes, record.episodes)),
            _number(record.mean_steps, 1, CONTROL_PERIOD),
            _number(record.min_range_m, 1, 1000),
            _number(record.peak_force_n, 1),
            _failures([record]),
        )
    return table


def _worst_pipe(records: Sequence[PipeRecord]) -> str:
    worst = min(records, key=lambda record: record.success)
    angle, turn = corner_cells(worst)
    where = turn.replace("-", " ") if worst.route else f"{angle}° {turn}"  # spaces, so that the line can break
    return f"{where}: {percent_text(worst.success)} %" if worst.success < 1 else MISSING


def _steps_and_seconds(steps: float | None) -> list[str]:
    """Control steps, and the same in seconds."""
    return [_number(steps, 1), _number(steps, 1, CONTROL_PERIOD)]


def _weighted_mean(values: Sequence[tuple[float, int]]) -> float | None:
    """Mean of values with weights; None without any weight."""
    total = sum(weight for _, weight in values)
    return sum(value * weight for value, weight in values) / total if total else None


def _number(value: float | None, decimals: int, factor: float = 1.0) -> str:
    return MISSING if value is None else f"{value * factor:.{decimals}f}"


def _extreme(pick: Callable[[Iterable[float]], float], values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return pick(known) if known else None


def _failures(records: Sequence[PipeRecord]) -> str:
    """Reasons with their counts, the most frequent first."""
    total: Counter[str] = Counter()
    for record in records:
        total.update(record.failures)
    return ", ".join(f"{reason} {count:,}" for reason, count in total.most_common() if count) or MISSING
