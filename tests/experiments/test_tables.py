"""The experiments' tables, and the findings that rest on them."""

from __future__ import annotations

import pytest

from pipenav.experiments.definition import experiment_names, load_experiment
from pipenav.experiments.figures import success_figure
from pipenav.experiments.findings import paragraph
from pipenav.experiments.plan import ExperimentPlan
from pipenav.experiments.tables import results


@pytest.mark.parametrize("name", experiment_names())
def test_every_row_can_be_told_apart_and_stands_in_the_legend(name: str, thesis_plan: ExperimentPlan) -> None:
    titles = [row.title for row in load_experiment(name).rows]
    assert len(set(titles)) == len(titles)
    (legend,) = success_figure(results(thesis_plan, name), name).legends
    assert {text.get_text() for text in legend.get_texts()} == set(titles)


@pytest.mark.parametrize("name", experiment_names())
def test_the_thesiss_own_figures_bear_out_its_findings(name: str, thesis_plan: ExperimentPlan) -> None:
    said = paragraph(name, results(thesis_plan, name))
    # (b): by its own table the agent without history does better over all diameters than history with C3 = 1.5.
    held = "That did not hold here" if name == "b" else "That held here"
    assert held in said


def test_tables_hold_the_figures_of_every_phase(thesis_plan: ExperimentPlan) -> None:
    given, located = results(thesis_plan, "f")
    assert {line.stage for line in given.lines} == {"reach", "rear", "whole"}
    for line in (*given.lines, *located.lines):
        for diameter, percent in line.thesis.items():
            assert line.ours[diameter].mean == pytest.approx(percent, abs=3.0)  # whole episodes of few fronts
    assert results(thesis_plan, "d")[0].line("rear").ours[90.0].mean == pytest.approx(2.0, abs=1.0)
