"""The report of experiments as one HTML file, which loads nothing: tables, curves over seeds, pictures."""

from __future__ import annotations

import base64
import math
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.summary import percent
from pipenav.experiments.definition import load_agents
from pipenav.experiments.figures import STAGE_WORDS, by_angle, training_curves
from pipenav.experiments.plan import ExperimentPlan, resolved_agent
from pipenav.experiments.tables import SHOWN_STAGES, Line, Result, ShownStage, pooled_counts
from pipenav.pages.page import filled_page

TEMPLATE = Path(__file__).with_name("report.html")

STAGE_LABELS = {"locate": "locate", "reach": "reach", "rear": "rear", "whole": "whole passage"}

MOST_POINTS = 300
"""Most points of a curve; of more iterations, some in even steps."""


class Section(NamedTuple):
    """An experiment in the report; pictures are PNG files' contents by name."""

    name: str
    title: str
    question: str
    paragraph: str
    results: list[Result]
    pictures: dict[str, bytes]

    @property
    def recipes(self) -> str:
        """The recipe of each agent, in words that `pipenav train` takes, a line each."""
        parts = []
        for agent in dict.fromkeys(result.row.agent for result in self.results):
            if agent in load_agents():
                recipe = load_agents()[agent]
                settings = "".join(f" --set {shlex.quote(f'{key}={value}')}" for key, value in recipe.settings.items())
                parts.append(f"{agent}: pipenav train --preset {recipe.preset}{settings}")
        return "\n".join(parts)


def experiments_page(plan: ExperimentPlan, sections: Sequence[Section], introduction: str) -> str:
    """The page of experiments.

    Args:
        plan: their plan, whose results are complete.
        sections: the experiments.
        introduction: sentences about all of them.
    """
    return filled_page(
        TEMPLATE, {"introduction": introduction, "sections": [_section(plan, section) for section in sections]}
    )


def _section(plan: ExperimentPlan, section: Section) -> dict[str, Any]:
    found = section.results
    diameters = sorted({d for result in found for line in result.lines for d in line.ours}, reverse=True)
    return {
        "name": section.name,
        "title": section.title,
        "question": section.question,
        "paragraph": section.paragraph,
        "diameters": diameters,
        "rows": [_row(result, line, diameters) for result in found for line in result.lines],
        "training": _training(plan, found),
        "angles": _angles(found, diameters),
        "pictures": [
            [name, "data:image/png;base64," + base64.b64encode(content).decode("ascii")]
            for name, content in section.pictures.items()
        ],
        "recipes": section.recipes,
    }


def _row(result: Result, line: Line, diameters: Sequence[float]) -> dict[str, Any]:
    """A line of the table: in each cell our mean over the seeds, the interval of all episodes, the thesis's figure."""
    return {
        "label": line.label,
        "stage": STAGE_LABELS[line.stage],
        "table": line.table if line.thesis else "",
        "cells": [_cell(result, line, d) for d in diameters],
    }


def _cell(result: Result, line: Line, diameter: float) -> dict[str, Any]:
    cell: dict[str, Any] = {"mean": None, "thesis": line.thesis.get(diameter)}
    if diameter in line.ours:
        spread = line.ours[diameter]
        counts = pooled_counts(result.evaluations, line.stage, diameter)
        low, high = wilson(*counts)
        cell |= {
            "mean": round(spread.mean, 3),
            "text": spread.text,
            "interval": f"{percent(low)}–{percent(high)}",
            "episodes": counts.attempts,
        }
    return cell


def _training(plan: ExperimentPlan, found: Sequence[Result]) -> list[dict[str, Any]]:
    """Curves of each agent's trainings over the thesis's iterations; none where the experiment trains nothing."""
    curves = []
    for result in found:
        agent = resolved_agent(plan, result.row)
        if agent is not None:
            given = training_curves(plan, agent)
            if len(given.iterations):
                shown = np.unique(np.linspace(0, len(given.iterations) - 1, MOST_POINTS).round().astype(int))
                curves.append(
                    {
                        "label": result.row.title,
                        "x": given.iterations[shown].tolist(),
                        "success": _band(100 * given.success[:, shown]),
                        "range": _band(1000 * given.min_range[:, shown]),
                    }
                )
    return curves


def _angles(found: Sequence[Result], diameters: Sequence[float]) -> list[dict[str, Any]]:
    """Success over the corner angle, a chart for each stage and diameter with a curve for each row of the table."""
    return [
        {"stage": STAGE_WORDS[stage], "diameter": d, "curves": [_over_angle(result, stage, d) for result in shown]}
        for stage in STAGE_WORDS
        if (shown := [result for result in found if stage in SHOWN_STAGES[result.row.stage]])
        for d in diameters
    ]


def _over_angle(result: Result, stage: ShownStage, diameter: float) -> dict[str, Any]:
    shares = [by_angle(evaluation, stage, diameter) for evaluation in result.evaluations]
    angles = sorted({angle for share in shares for angle in share})
    values = np.array([[share.get(angle, math.nan) for angle in angles] for share in shares])
    return {"label": result.row.title, "x": angles, "y": _band(100 * values.reshape(len(shares), -1))}


def _band(values: Floats) -> dict[str, list[float | None]]:
    """Mean, lowest and highest of the seeds, values (seeds, k); None where none has a value."""
    columns = [column[np.isfinite(column)] for column in values.T]
    return {
        name: [round(float(of(column)), 2) if len(column) else None for column in columns]
        for name, of in (("mean", np.mean), ("low", np.min), ("high", np.max))
    }
