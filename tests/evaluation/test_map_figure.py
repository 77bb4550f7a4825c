"""The map of an evaluation."""

from __future__ import annotations

from helpers.evaluations import GRID, MIXED, RUNS, evaluation, record, shown

from pipenav.evaluation.cells import by_angle, by_fitting
from pipenav.evaluation.map_figure import MOST_COLUMNS, map_figure
from pipenav.evaluation.pipe_results import PipeRecord


def test_turns_are_separate_panels() -> None:
    panels = [axes for axes in map_figure(GRID).axes if axes.texts and axes.images]
    assert [axes.get_ylabel().split()[0] for axes in panels] == ["left", "right"]
    assert sum(text.get_text() == "70" for text in panels[0].texts) == 15


def test_routes_stand_apart_from_corners_with_their_numbers() -> None:
    panels = [axes for axes in map_figure(MIXED).axes if axes.texts and axes.images]
    assert [axes.get_ylabel().split()[0] for axes in panels] == ["left", "routes"]
    assert sorted(text.get_text() for text in panels[1].texts) == ["1", "2", "25", "3", "50", "75"]
    assert "R65-L70-R100-R55-L110" in shown(RUNS)
    assert RUNS.diameters[1].reach_success == 3 / 8
    assert RUNS.diameters[1].thesis_percent is None


def test_a_map_of_routes_has_no_more_columns_than_it_needs() -> None:
    def cells(routes: int) -> tuple[int, ...]:
        record = {"angle_deg": None, "turn": None, "episodes": 1}
        pipes = [PipeRecord(diameter_mm=70 + 10 * (i % 2), route=f"run-d70-R{i}", **record) for i in range(routes)]
        return map_figure(evaluation(pipes)).axes[0].images[0].get_array().shape

    assert cells(8) == (2, 4)
    assert cells(4 * MOST_COLUMNS) == (4, MOST_COLUMNS)


def test_bends_of_different_radii_have_columns_of_their_own() -> None:
    bends = [record(100, 90, "left", 10, bend_radius_mm=radius) for radius in (150.0, 0.0, 100.0)]
    assert list(by_fitting(bends)) == [("", 90, 0.0), ("", 90, 1.0), ("", 90, 1.5)]
    assert by_angle(bends) == {"": {90: (30, 30)}}
    panel = map_figure(evaluation(bends)).axes[0]
    assert [label.get_text() for label in panel.get_xticklabels()] == ["90", "90\n1 D", "90\n1.5 D"]
    assert panel.get_xlabel().endswith("bend radius")
