"""The picture of a training: success and least laser reading over its control steps."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipenav.drawing.style import INK, MAIN, MUTED, SECOND, THIRD, heading, plain, png
from pipenav.learning.progress import progress_columns, read_progress
from pipenav.storage.atomic_files import atomic_write

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def training_figure(columns: dict[str, list[float]], name: str) -> Figure:
    """Success (top) and least laser reading (bottom) over the control steps of one training.

    Args:
        columns: columns of progress.csv, as far as there are any.
        name: name of the training.
    """
    from matplotlib.figure import Figure

    figure = Figure((9.0, 6.0), facecolor="white", layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    steps, seconds = columns.get("steps", []), columns.get("seconds", [])
    success, checks, ranges = (columns.get(key, []) for key in ("success", "check_success", "min_range_m"))
    _curve(top, steps, _scaled(success, 100), color=MAIN, label="training episodes, with exploration noise")
    _curve(top, steps, _scaled(checks, 100), color=SECOND, label="check, without noise", drawstyle="steps-post")
    _curve(bottom, steps, _scaled(ranges, 1000), color=THIRD)
    top.set(ylim=(-2, 103), ylabel="success [%]")
    for begin in _stage_begins(steps, columns.get("stage", [])):
        for axes in (top, bottom):
            axes.axvline(begin, color=MUTED, lw=1.0, ls=":", zorder=0)
    bottom.set_ylim(bottom=0)
    bottom.set(ylabel="mean of the least\nlaser reading [mm]", xlabel="control steps")
    bottom.xaxis.set_major_formatter("{x:,.0f}")
    for axes in (top, bottom):
        plain(axes)
    if top.get_legend_handles_labels()[0]:
        top.legend(loc="lower right", fontsize=9, frameon=True, framealpha=0.9, edgecolor="none", labelcolor=INK)
    took = f", {seconds[-1]:,.0f} s" if seconds and not math.isnan(seconds[-1]) else ""
    heading(
        top,
        f"Training of {name}" if name else "Training",
        f"{steps[-1]:,.0f} control steps{took}" if steps else "no steps yet",
    )
    return figure


def _stage_begins(steps: Sequence[float], stages: Sequence[float]) -> list[float]:
    """Control steps at which a stage followed another one; files of older versions have no stages."""
    return [steps[i] for i, (before, now) in enumerate(pairwise(stages)) if now > before]


def _scaled(values: Sequence[float], factor: float) -> list[float]:
    return [factor * value for value in values]


def _curve(axes: Axes, steps: Sequence[float], values: Sequence[float], **style: Any) -> None:
    """Draw a line over the control steps; NaN is left out."""
    points = [(x, y) for x, y in zip(steps, values, strict=False) if not math.isnan(y)]
    if points:
        marker = "o" if len(points) < 3 else ""  # a line needs points; one or two need a mark to be seen
        axes.plot(*zip(*points, strict=True), lw=1.8, marker=marker, **style)


def write_training_plot(path: Path, progress_csv: Path) -> None:
    """Draw success and least laser reading over the steps of a training.

    Args:
        path: the PNG file.
        progress_csv: the training's progress.csv; empty cells and a broken last line are skipped.

    Raises:
        FileProblem: the one cannot be read or the other not be written.
        ConfigError: progress.csv is not the table of a training.
    """
    figure = training_figure(progress_columns(read_progress(progress_csv)), progress_csv.resolve().parent.name)
    atomic_write(path, png(figure))
