"""Pictures of a search: its trials in order, and how much each setting matters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pipenav.drawing.style import INK, MAIN, MUTED, SECOND, THIRD, heading, plain
from pipenav.tuning.objective import Objective, Outcome
from pipenav.tuning.study import TrialRecord

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

AXIS_LABELS = {
    "steps": "control steps before the first success",
    "seconds": "seconds of training before the first success",
    "success": "failures of the best policy [%]",
}


ROOM_FOR_MARKS = 1.12
"""Height of the picture in that of its curve: marks of trials without a number stand above it."""


def history_figure(records: Sequence[TrialRecord], objective: Objective, preset: Outcome | None) -> Figure:
    """The objective of each trial in the order of their beginning, and the best so far."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    figure = Figure((9.0, 5.0), facecolor="white", layout="constrained")
    axes = figure.subplots()
    trials = [record for record in records if record.outcome is not None and not record.preset]
    done = [r for r in trials if r.state == "done" and r.outcome and objective.reached(r.outcome)]
    numbers = [record.number for record in done]
    values = [_shown(objective, record) for record in done]
    if done:
        best = [min(values[: i + 1]) for i in range(len(values))]
        axes.plot(numbers, best, color=MAIN, lw=1.8, drawstyle="steps-post", label="best so far")
        axes.plot(numbers, values, "o", color=MAIN, ms=6, label="a trial")
    if preset is not None and objective.reached(preset):
        axes.axhline(_scaled(objective, preset), color=SECOND, lw=1.5, ls="--", label="the preset")
    axes.set_ylim(0, max(axes.get_ylim()[1], 1e-9) * ROOM_FOR_MARKS)
    _marks(axes, [r.number for r in trials if r.state == "done" and r not in done], "x", SECOND, "never a success")
    _marks(axes, [r.number for r in trials if r.state == "pruned"], "v", MUTED, "ended early: others were better")
    axes.set(xlabel="trial", ylabel=AXIS_LABELS[objective.name])
    axes.yaxis.set_major_formatter("{x:,.0f}" if objective.name == "steps" else "{x:g}")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    plain(axes)
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc="outside lower center", ncols=5, fontsize=9, frameon=False, labelcolor=INK)
    own = "" if preset is None else f"; the preset: {objective.words(objective.value(preset))}"
    heading(axes, "Search for better settings", f"{objective.title}, {len(trials)} trials{own}")
    return figure


def _marks(axes: Axes, numbers: Sequence[int], marker: str, colour: str, label: str) -> None:
    """Marks at the upper edge for trials without a number of their own."""
    if numbers:
        heights = [0.97] * len(numbers)
        axes.plot(numbers, heights, marker, color=colour, ms=6, label=label, transform=axes.get_xaxis_transform())


def _shown(objective: Objective, record: TrialRecord) -> float:
    assert record.outcome is not None
    return _scaled(objective, record.outcome)


def _scaled(objective: Objective, outcome: Outcome) -> float:
    """The objective in the axis's unit."""
    return objective.value(outcome) * (100.0 if objective.name == "success" else 1.0)


def importance_figure(importance: Mapping[str, float], objective: Objective) -> Figure:
    """Bars of how much each setting matters, the largest at the top."""
    from matplotlib.figure import Figure

    figure = Figure((9.0, 1.8 + 0.35 * max(len(importance), 1)), facecolor="white", layout="constrained")
    axes = figure.subplots()
    names = list(importance)[::-1]
    axes.barh(names, [100.0 * importance[name] for name in names], color=THIRD, height=0.6)
    axes.set(xlabel="importance [%]", xlim=(0, None))
    plain(axes)
    note = "share in how the best trials differ from the others (PED-ANOVA)"
    heading(axes, f"Importance for {objective.title}", note if importance else "too few trials are done to tell")
    return figure
