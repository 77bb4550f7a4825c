"""The picture of a training: success and clearance over its control steps."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from pipenav.drawing.style import INK, MAIN, SECOND, THIRD, heading, plain, png
from pipenav.errors import FileProblem
from pipenav.storage.atomic_files import atomic_write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def progress_columns(text: str) -> dict[str, list[float]]:
    """The columns of a progress.csv; NaN where a cell is empty or no number. Broken rows are left out."""
    reader = csv.DictReader(io.StringIO(text))
    rows = [row for row in reader if None not in row.values() and not math.isnan(_number(row.get("steps")))]
    return {name: [_number(row.get(name)) for row in rows] for name in reader.fieldnames or []}


def _number(cell: str | None) -> float:
    try:
        value = float(cell or "nan")
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


def training_figure(columns: dict[str, list[float]], run: str) -> Figure:
    """Success (top) and clearance (bottom) over the control steps of one run.

    Args:
        columns: those of progress.csv, as far as there are any.
        run: the run's name.
    """
    from matplotlib.figure import Figure

    figure = Figure((9.0, 6.0), facecolor="white", layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    _curve(top, columns, "success", MAIN, "training episodes, with exploration noise", 100)
    for name in ("check_success", "eval_success"):
        _curve(top, columns, name, SECOND, "check, without noise", 100, drawstyle="steps-post")
    _curve(bottom, columns, "clearance_m", THIRD, "", 1000)
    top.set(ylim=(-2, 103), ylabel="success [%]")
    bottom.set_ylim(bottom=0)
    bottom.set(ylabel="mean clearance\nat the tip [mm]", xlabel="control steps")
    bottom.xaxis.set_major_formatter("{x:,.0f}")
    for axes in (top, bottom):
        plain(axes)
    if top.get_legend_handles_labels()[0]:
        top.legend(loc="lower right", fontsize=9, frameon=True, framealpha=0.9, edgecolor="none", labelcolor=INK)
    steps, seconds = columns.get("steps", []), columns.get("seconds", [])
    took = f", {seconds[-1]:,.0f} s" if seconds and not math.isnan(seconds[-1]) else ""
    heading(
        top,
        f"Training of {run}" if run else "Training",
        f"{steps[-1]:,.0f} control steps{took}" if steps else "no steps yet",
    )
    return figure


def _curve(
    axes: Axes,
    columns: dict[str, list[float]],
    name: str,
    colour: str,
    label: str,
    scale: float,
    drawstyle: Literal["default", "steps-post"] = "default",
) -> None:
    steps = columns.get("steps", [])
    points = [(x, scale * y) for x, y in zip(steps, columns.get(name, []), strict=False) if not math.isnan(y)]
    if points:
        marker = "o" if len(points) < 3 else ""  # a line needs points; one or two need a mark to be seen
        axes.plot(*zip(*points, strict=True), color=colour, label=label, lw=1.8, marker=marker, drawstyle=drawstyle)


def write_training_plot(path: Path, progress_csv: Path) -> None:
    """Draw success and clearance over the steps of a run.

    Args:
        path: the PNG file.
        progress_csv: the run's progress.csv; empty cells and a broken last line are skipped.

    Raises:
        FileProblem: the one cannot be read or the other not be written.
    """
    try:
        text = progress_csv.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise FileProblem(progress_csv, "read", error) from error
    columns = progress_columns(text)
    figure = training_figure(columns, progress_csv.resolve().parent.name)
    atomic_write(path, png(figure))
