"""success.png: panels of diameters, rows of routes."""

from __future__ import annotations

import pytest
from helpers.evaluations import GRID, MIXED, RUNS, TEES, evaluation, record
from matplotlib.backends.backend_agg import FigureCanvasAgg

from pipenav.evaluation.success_figure import MOST_ROUTES, success_figure


def test_a_panel_for_each_diameter_says_what_failed_in_it() -> None:
    panels = success_figure(GRID).axes
    assert [axes.get_title("left") for axes in panels] == ["120 mm", "90 mm"]
    assert [axes.get_title("right") for axes in panels] == ["100 %, 0 of 300 failed", "70.0 %, 90 of 300 failed"]
    assert list(panels[1].lines[0].get_ydata()) == pytest.approx([70.0] * 15)


def test_a_good_policy_is_shown_from_90_percent_and_its_failures_are_seen() -> None:
    many = {"episodes": 500, "reach_attempts": 500}
    pipes = [
        record(90, 60).model_copy(update={**many, "reach_successes": 496, "failures": {"limit": 4}}),
        record(90, 90).model_copy(update={**many, "reach_successes": 500, "failures": {}}),
    ]
    figure = success_figure(evaluation(pipes))
    FigureCanvasAgg(figure).draw()
    axes = figure.axes[0]
    assert 85 < axes.get_ylim()[0] < 90
    (_, low), (_, high) = axes.transData.transform([(60, 99.2), (90, 100)])
    assert high - low > 0.2 * axes.bbox.height


def test_a_poor_policy_is_shown_from_0() -> None:
    assert success_figure(evaluation([record(90, 60, successes=1)])).axes[0].get_ylim()[0] <= 0


def test_routes_have_a_row_each_with_number_and_corners() -> None:
    rows = [text.get_text().split() for axes in success_figure(RUNS).axes for text in axes.get_yticklabels()]
    assert rows == [["R120-R120-R120-R120-R120-...", "2"], ["R65-L70-R100-R55-L110", "1"], ["L90", "3"]]
    assert [text.get_text() for text in success_figure(MIXED).axes[0].get_xticklabels()] == ["60"]


def test_of_many_routes_the_worst_are_shown() -> None:
    one = RUNS.pipes[0].model_copy(update={"failures": {}, "reach_successes": 4})
    figure = success_figure(evaluation([*[one] * MOST_ROUTES, RUNS.pipes[0]]))
    rows = [text.get_text().split()[-1] for axes in figure.axes for text in axes.get_yticklabels()]
    assert len(rows) == MOST_ROUTES
    assert str(MOST_ROUTES + 1) in rows


def test_ways_through_tees_have_marks_of_their_own() -> None:
    figure = success_figure(TEES)
    FigureCanvasAgg(figure).draw()
    words = [text.get_text() for text in figure.legends[0].texts]
    assert words == ["corner", "tee, straight on past the branch", "tee, into the branch", "tee, out of the branch"]
    lines = [line for line in figure.axes[0].lines if len(line.get_xdata()) == 2 and line.get_alpha()]
    assert sorted(list(line.get_ydata()) for line in lines) == [[10.0, 10.0], [30.0, 30.0], [50.0, 50.0]]
    legend, axis = figure.legends[0].get_window_extent(), figure._supxlabel.get_window_extent()
    assert legend.y1 <= axis.y0 + 2 and axis.y1 <= figure.axes[0].get_tightbbox().y0
    places = [x for line in figure.axes[0].lines for x in line.get_xdata() if 85 < x < 95]
    assert len({round(x, 3) for x in places}) == 4  # four kinds at 90 deg
