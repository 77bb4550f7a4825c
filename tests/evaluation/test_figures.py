"""Pictures of an evaluation."""

from __future__ import annotations

import pytest
from helpers.evaluations import GRID, MIXED, RUNS, shown

from pipenav.evaluation.figures import map_figure, percent, success_figure


@pytest.mark.parametrize(
    ("share", "decimals", "text"),
    [(1.0, 1, "100"), (0.0, 1, "0"), (0.9999, 1, "99.9"), (0.0001, 1, "0.1"), (0.996, 0, "99"), (0.5, 0, "50")],
)
def test_only_perfect_shares_read_perfect(share: float, decimals: int, text: str) -> None:
    assert percent(share, decimals) == text


def test_pictures_pool_turns_or_separate_them() -> None:
    success, cells = success_figure(GRID), map_figure(GRID)
    lines = [line for line in success.axes[0].lines if not line.get_label().startswith("_")]
    assert [line.get_label() for line in lines] == ["120 mm", "90 mm"]
    assert list(lines[1].get_ydata()) == pytest.approx([70.0] * 15)
    panels = [axes for axes in cells.axes if axes.texts and axes.images]
    assert [axes.get_ylabel().split()[0] for axes in panels] == ["left", "right"]
    assert sum(text.get_text() == "70" for text in panels[0].texts) == 15


def test_routes_stand_apart_from_corners_by_their_number() -> None:
    assert [text.get_text() for text in success_figure(RUNS).axes[0].get_xticklabels()] == ["1", "2", "3"]
    assert [text.get_text() for text in success_figure(MIXED).axes[0].get_xticklabels()] == ["60"]
    panels = [axes for axes in map_figure(MIXED).axes if axes.texts and axes.images]
    assert [axes.get_ylabel().split()[0] for axes in panels] == ["left", "routes"]
    assert sorted(text.get_text() for text in panels[1].texts) == ["25", "50", "75"]
    assert "R65-L70-R100-R55-L110" in shown(RUNS)
    assert RUNS.diameters[1].reach_success == pytest.approx(3 / 8)
    assert RUNS.diameters[1].thesis_percent is None
