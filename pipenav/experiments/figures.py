"""The pictures of an experiment: training curves, and success over the corner angle, as in the thesis's chapter 5."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.style import INK, MARKERS, heading, plain
from pipenav.errors import FileProblem
from pipenav.evaluation.results import Evaluation, PipeRecord
from pipenav.experiments.runner import ExperimentPlan, resolved_agent
from pipenav.experiments.tables import PHASES, Phase, Result
from pipenav.learning.figures import progress_columns
from pipenav.learning.training_folder import TrainingFolder

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


ITERATION = 800
"""Control steps of one of the thesis's training iterations (4.4.1)."""

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Okabe and Ito's palette, which the colour-blind can tell apart."""

PHASE_WORDS: dict[Phase, str] = {"locate": "target located", "reach": "front", "rear": "rear of the successful fronts"}


def training_figure(plan: ExperimentPlan, results: Sequence[Result], title: str) -> Figure | None:
    """Success and clearance over the thesis's iterations, mean over seeds with their range; None without trainings."""
    from matplotlib.figure import Figure

    agents = {result.row.title: resolved_agent(plan, result.row) for result in results}
    curves = {label: _curves(plan, agent) for label, agent in agents.items() if agent is not None}
    if not curves:
        return None
    figure = Figure((11.0, 5.4), facecolor="white", layout="constrained")
    left, right = figure.subplots(1, 2)
    for (label, (x, success, clearance)), colour in zip(curves.items(), COLOURS, strict=False):
        _band(left, x, 100 * success, colour, label)
        _band(right, x, 1000 * clearance, colour, label)
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


def _curves(plan: ExperimentPlan, agent: str) -> tuple[Floats, Floats, Floats]:
    """Iterations (k,), success and clearance [m], both (seeds, k); NaN where an iteration saw no episode end."""
    columns = [_columns(plan, agent, seed) for seed in plan.seeds]
    count = max(int(max(c["steps"], default=0.0)) // ITERATION for c in columns)
    x = np.arange(1.0, count + 1)
    curves = np.full((2, len(columns), count), np.nan)
    for seed, column in enumerate(columns):
        place = np.ceil(np.array(column["steps"]) / ITERATION).astype(int) - 1
        for row, name in enumerate(("success", "clearance_m")):
            values = np.array(column[name])
            for i in np.unique(place[place < count]):
                here = values[place == i]
                if np.isfinite(here).any():
                    curves[row, seed, i] = np.nanmean(here)
    return x, curves[0], curves[1]


def _columns(plan: ExperimentPlan, agent: str, seed: int) -> dict[str, list[float]]:
    file = TrainingFolder(plan.run_folder(agent, seed)).progress
    try:
        return progress_columns(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileProblem(file, "read", error) from error


def success_figure(results: Sequence[Result], title: str) -> Figure:
    """Success over the corner angle, one panel for each diameter and phase, one line for each row of the table."""
    from matplotlib.figure import Figure

    phases = [phase for phase in PHASE_WORDS if any(phase in PHASES[result.row.stage] for result in results)]
    diameters = [record.diameter_mm for record in results[0].found[0].diameters]
    figure = Figure((3.3 * len(diameters), 3.1 * len(phases) + 1.2), facecolor="white", layout="constrained")
    panels = figure.subplots(len(phases), len(diameters), sharex=True, sharey=True, squeeze=False)
    for phase, row in zip(phases, panels, strict=True):
        for diameter, axes in zip(diameters, row, strict=True):
            _draw_panel(axes, results, phase, diameter)
            axes.set_title(f"{diameter:g} mm", loc="center", fontsize=11, color=INK)
        row[0].set_ylabel(f"{PHASE_WORDS[phase]}\nsuccess [%]")
    for axes in panels[-1]:
        axes.set_xlabel("interior corner angle [deg]")
    # No single phase has every row.
    drawn = {line.get_label(): line for axes in panels[:, 0] for line in axes.get_lines()}
    figure.legend(handles=list(drawn.values()), loc="outside lower center", ncols=2, frameon=False, labelcolor=INK)
    seeds = max(len(result.found) for result in results)
    note = f"mean of {seeds} seeds, bands: their range" if seeds > 1 else "one seed"
    figure.suptitle(f"{title}\n{note}", x=0.01, ha="left", color=INK)
    return figure


def _draw_panel(axes: Axes, results: Sequence[Result], phase: Phase, diameter: float) -> None:
    plain(axes)
    axes.set_ylim(-3, 104)
    for i, result in enumerate(results):
        if phase not in PHASES[result.row.stage]:
            continue
        shares = [_by_angle(evaluation, phase, diameter) for evaluation in result.found]
        angles = sorted({angle for one in shares for angle in one})
        values = np.array([[one.get(angle, np.nan) for angle in angles] for one in shares]).reshape(len(shares), -1)
        _band(axes, np.array(angles), 100 * values, COLOURS[i % len(COLOURS)], result.row.title, MARKERS[i])


def _by_angle(evaluation: Evaluation, phase: Phase, diameter: float) -> dict[float, float]:
    """Share of successes by angle [deg], of the attempts of a phase; angles without any are left out."""
    counts: dict[float, tuple[int, int]] = {}
    for record in evaluation.pipes:
        successes, attempts = _counts(record, phase)
        if record.diameter_mm == diameter and record.angle_deg is not None and attempts:
            before = counts.get(record.angle_deg, (0, 0))
            counts[record.angle_deg] = before[0] + successes, before[1] + attempts
    return {angle: successes / attempts for angle, (successes, attempts) in counts.items()}


def _counts(record: PipeRecord, phase: Phase) -> tuple[int, int]:
    if phase == "locate":
        return record.located or 0, record.episodes
    if phase == "reach":
        return record.reach_successes or 0, record.reach_attempts or 0
    return record.rear_successes or 0, record.rear_attempts or 0


def _band(axes: Axes, x: Floats, values: Floats, colour: str, label: str, marker: str = "") -> None:
    """The mean over the rows of values (seeds, k) with their range; columns without a value are left out."""
    seen = np.isfinite(values).any(axis=0)
    if not seen.any():
        return
    x, values = x[seen], values[:, seen]
    axes.fill_between(x, np.nanmin(values, axis=0), np.nanmax(values, axis=0), color=colour, alpha=0.13, linewidth=0)
    axes.plot(x, np.nanmean(values, axis=0), color=colour, label=label, lw=1.6, marker=marker, markersize=4)
