"""Evaluations of very many pipes are drawn with few rows and columns, in which every episode is counted once."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.evaluation.cells import by_fitting
from pipenav.evaluation.coarse import MOST_DIAMETERS, MOST_FITTINGS, coarse
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.map_figure import map_figure
from pipenav.evaluation.pipe_results import PipeRecord, by_diameter
from pipenav.evaluation.report import evaluation_table
from pipenav.evaluation.results import Evaluation
from pipenav.evaluation.success_figure import success_figure


def evaluation_of(shapes: list[tuple[float, float, float]]) -> Evaluation:
    """An evaluation of corners: diameter [mm], angle [deg] and bend radius in diameters of each."""
    records = [
        PipeRecord(
            diameter_mm=diameter,
            angle_deg=angle,
            turn=random.Random(i).choice(["left", "right"]),  # type: ignore[arg-type]
            bend_radius_mm=bend * diameter,
            episodes=3,
            reach_attempts=3,
            reach_successes=i % 4,
        )
        for i, (diameter, angle, bend) in enumerate(shapes)
    ]
    return Evaluation.of(records, config=EvaluationConfig(policy="arm", stage="reach"), robot="basic")


SHAPES = st.tuples(st.floats(40, 300), st.floats(20, 180), st.sampled_from([0.0, 0.5, 1.5]))


@given(st.lists(SHAPES, min_size=1, max_size=300))
def test_few_rows_and_columns_are_left_and_every_episode_is_counted(shapes: list[tuple[float, float, float]]) -> None:
    whole = evaluation_of(shapes)
    few = coarse(whole).evaluation
    lines = {d: by_fitting(records) for d, records in by_diameter(few.pipes).items()}
    assert len(lines) <= MOST_DIAMETERS
    assert len({fitting for line in lines.values() for fitting in line}) <= MOST_FITTINGS
    assert sum(cell.episodes for line in lines.values() for cell in line.values()) == 3 * len(shapes)
    assert sum(row.episodes for row in few.diameters) == 3 * len(shapes)
    assert few.success == whole.success
    for record, rounded in zip(whole.pipes, few.pipes, strict=True):
        assert abs(record.diameter_mm - rounded.diameter_mm) <= 20
        assert abs(record.angle_deg - rounded.angle_deg) <= 10


def test_what_has_few_is_shown_as_it_is() -> None:
    whole = evaluation_of([(d, a, 0.0) for d in range(60, 84) for a in range(60, 120)])
    assert coarse(whole) == (whole, "")


@pytest.mark.slow
def test_a_thousand_angles_are_drawn_in_a_picture_of_usual_size() -> None:
    many = evaluation_of([(80 + i % 7, 50 + 0.1 * i, 0.0) for i in range(1000)])
    for figure in (map_figure(many), success_figure(many)):
        assert max(figure.get_size_inches()) < 60
        assert any(
            "rounded: angles to 2 deg" in text.get_text() for text in figure.findobj(lambda a: hasattr(a, "get_text"))
        )
    assert evaluation_table(many) is not None
