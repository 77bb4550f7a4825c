"""The pictures of an experiment: training curves, and success over the corner angle, as in the thesis's chapter 5."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.style import INK, MARKERS, heading, plain
from pipenav.evaluation.results import Evaluation
from pipenav.experiments.plan import ExperimentPlan, resolved_agent
from pipenav.experiments.tables import SHOWN_STAGES, Counts, Result, ShownStage, stage_counts
from pipenav.learning.progress import progress_columns, read_progress
from pipenav.learning.training_folder import TrainingFolder

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


ITERATION = 800
"""Control steps of one of the thesis's training iterations (4.4.1)."""

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Okabe and Ito's palette, which the colour-blind can tell apart."""

STAGE_WORDS: dict[ShownStage, str] = {
    "locate": "target located",
    "reach": "target reached",
    "rear": "rear, where reach succeeded",
}


def training_figure(plan: ExperimentPlan, results: Sequence[Result], title: str) -> Figure | None:
    """Success and least laser reading over the thesis's iterations, mean over seeds with their range.

    None where the experiment has no trainings.
    """
    from matplotlib.figure import Figure

    agents = {result.row.title: resolved_agent(plan, result.row) for result in results}
    curves = {label: training_curves(plan, agent) for label, agent in agents.items() if agent is not None}
    if not curves:
        return None
    figure = Figure((11.0, 5.4), facecolor="white", layout="constrained")
    left, right = figure.subplots(1, 2)
    for (label, curve), colour in zip(curves.items(), COLOURS, strict=False):
        _band(left, curve.iterations, 100 * curve.success, _Style(colour, label))
        _band(right, curve.iterations, 1000 * curve.min_range, _Style(colour, label))
    left.set(ylim=(-2, 103), ylabel="success of training episodes [%]")
    right.set(ylabel="mean of the smallest laser reading [mm]")
    right.set_ylim(bottom=0)
    for axes in (left, right):
        axes.set_xlabel(f"iteration ({ITERATION} control steps)")
        plain(axes)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False, labelcolor=INK)
    seeds = ", ".join(str(seed) for seed in plan.seeds)
    heading(left, f"Training: {title}", f"mean of seeds {seeds}, with exploration noise; bands: their range")
    return figure


class Curves(NamedTuple):
    """The trainings of one agent; NaN where an iteration saw no episode end.

    Attributes:
        iterations: numbers of the iterations, from 1, (k,).
        success: share of the training episodes that succeeded, (seeds, k).
        min_range: mean of the smallest laser reading, (seeds, k) [m].
    """

    iterations: Floats
    success: Floats
    min_range: Floats


def training_curves(plan: ExperimentPlan, agent: str) -> Curves:
    """The trainings of an agent, one row for each seed."""
    columns = [_columns(plan, agent, seed) for seed in plan.seeds]
    count = max(int(max(c["steps"], default=0.0)) // ITERATION for c in columns)
    success, min_range = np.full((2, len(columns), count), np.nan)
    for seed, column in enumerate(columns):
        iteration = np.ceil(np.array(column["steps"]) / ITERATION).astype(int) - 1
        for curve, name in ((success, "success"), (min_range, "min_range_m")):
            values = np.array(column[name])
            for i in np.unique(iteration[iteration < count]):
                here = values[iteration == i]
                if np.isfinite(here).any():
                    curve[seed, i] = np.nanmean(here)
    return Curves(np.arange(1.0, count + 1), success, min_range)


def _columns(plan: ExperimentPlan, agent: str, seed: int) -> dict[str, list[float]]:
    file = TrainingFolder(plan.training_folder(agent, seed)).progress
    return progress_columns(read_progress(file))


def success_figure(results: Sequence[Result], title: str) -> Figure:
    """Success over the corner angle, one panel for each diameter and stage, one line for each row of the table."""
    from matplotlib.figure import Figure

    stages = [stage for stage in STAGE_WORDS if any(stage in SHOWN_STAGES[result.row.stage] for result in results)]
    diameters = [record.diameter_mm for record in results[0].evaluations[0].diameters]
    figure = Figure((3.3 * len(diameters), 3.1 * len(stages) + 1.2), facecolor="white", layout="constrained")
    panels = figure.subplots(len(stages), len(diameters), sharex=True, sharey=True, squeeze=False)
    for stage, row in zip(stages, panels, strict=True):
        for diameter, axes in zip(diameters, row, strict=True):
            _draw_panel(axes, results, stage, diameter)
            axes.set_title(f"{diameter:g} mm", loc="center", fontsize=11, color=INK)
        row[0].set_ylabel(f"{STAGE_WORDS[stage]}\nsuccess [%]")
    for axes in panels[-1]:
        axes.set_xlabel("interior corner angle [deg]")
    # No single stage has every row.
    drawn = {line.get_label(): line for axes in panels[:, 0] for line in axes.get_lines()}
    figure.legend(handles=list(drawn.values()), loc="outside lower center", ncols=2, frameon=False, labelcolor=INK)
    seeds = max(len(result.evaluations) for result in results)
    note = f"mean of {seeds} seeds, bands: their range" if seeds > 1 else "one seed"
    figure.suptitle(f"{title}\n{note}", x=0.01, ha="left", color=INK)
    return figure


def _draw_panel(axes: Axes, results: Sequence[Result], stage: ShownStage, diameter: float) -> None:
    plain(axes)
    axes.set_ylim(-3, 104)
    for i, result in enumerate(results):
        if stage not in SHOWN_STAGES[result.row.stage]:
            continue
        shares = [by_angle(evaluation, stage, diameter) for evaluation in result.evaluations]
        angles = sorted({angle for share in shares for angle in share})
        values = np.array([[share.get(angle, np.nan) for angle in angles] for share in shares])
        style = _Style(COLOURS[i % len(COLOURS)], result.row.title, MARKERS[i])
        _band(axes, np.array(angles), 100 * values.reshape(len(shares), -1), style)


def by_angle(evaluation: Evaluation, stage: ShownStage, diameter: float) -> dict[float, float]:
    """Share of successes by angle [deg], of the attempts of a stage; angles without any are left out."""
    counts: dict[float, Counts] = {}
    for record in evaluation.pipes:
        here = stage_counts(record, stage)
        if record.diameter_mm == diameter and record.angle_deg is not None and here.attempts:
            before = counts.get(record.angle_deg, Counts(0, 0))
            counts[record.angle_deg] = Counts(before.successes + here.successes, before.attempts + here.attempts)
    return {angle: successes / attempts for angle, (successes, attempts) in counts.items()}


class _Style(NamedTuple):
    colour: str
    label: str
    marker: str = ""


def _band(axes: Axes, x: Floats, values: Floats, style: _Style) -> None:
    """The mean over the rows of values (seeds, k) with their range; columns without a value are left out."""
    seen = np.isfinite(values).any(axis=0)
    if not seen.any():
        return
    x, values = x[seen], values[:, seen]
    low, high = np.nanmin(values, axis=0), np.nanmax(values, axis=0)
    axes.fill_between(x, low, high, color=style.colour, alpha=0.13, linewidth=0)
    mean = np.nanmean(values, axis=0)
    axes.plot(x, mean, color=style.colour, label=style.label, lw=1.6, marker=style.marker, markersize=4)
