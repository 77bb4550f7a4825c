"""The map where geometry has decided: impossible and failed look different at a glance, without colours too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers.evaluations import evaluation, record
from matplotlib.figure import Figure

from pipenav.evaluation.map_figure import map_figure
from pipenav.evaluation.passability import Answer, Chance
from pipenav.evaluation.passability_cells import IMPOSSIBLE, UNDECIDED
from pipenav.evaluation.passability_record import PipePassability


def drawn(successes: int, failed: dict[Chance, int], **facts: Any) -> Figure:
    answer = Answer("passable", "passable", "", failed)
    found = PipePassability.on(answer, successes)
    return map_figure(evaluation([record(90, 60, "left", successes, passability=found, **facts)]))


def hatches(figure: Figure) -> set[str]:
    return {patch.get_hatch() for patch in figure.axes[0].patches if patch.get_hatch()}


def words(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.axes[0].texts]


def legend(figure: Figure) -> list[str]:
    return [text.get_text() for each in figure.legends for text in each.get_texts()]


@pytest.mark.parametrize(
    ("successes", "failed", "hatch", "word", "coloured"),
    [
        (10, {}, set(), "", True),
        (0, {"possible": 10}, set(), "10 gaps", True),
        (9, {"possible": 1}, set(), "1 gap", True),
        (0, {"impossible": 10}, {IMPOSSIBLE}, "impossible", False),
        (0, {"undecided": 10}, {UNDECIDED}, "undecided", False),
        (0, {"with_overlap": 10}, {UNDECIDED}, "only overlap", False),
        (7, {"impossible": 3}, {IMPOSSIBLE}, "3 impossible", True),
        (4, {"possible": 2, "impossible": 4}, {IMPOSSIBLE}, "2 gap, 4 imp", True),
    ],
)
def test_a_cell_says_what_became_of_its_episodes(
    successes: int, failed: dict[Chance, int], hatch: set[str], word: str, coloured: bool
) -> None:
    figure = drawn(successes, failed)
    assert hatches(figure) == hatch
    assert word in words(figure)
    assert str(10 * successes) in words(figure)
    assert any("–" in text and len(text) < 8 for text in words(figure)) or successes in (0, 10)
    shares = figure.axes[0].images[0].get_array()
    assert bool(np.ma.count(shares)) == coloured


def test_the_legend_explains_what_is_there_and_nothing_else() -> None:
    assert legend(drawn(10, {}, trained=True)) == []
    assert legend(drawn(10, {}, trained=False)) == ["outside of the policy's training"]
    assert legend(drawn(8, {"possible": 2})) == ["failed although possible: a gap of the policy"]
    assert len(legend(drawn(0, {"impossible": 4, "undecided": 6}))) == 1


def test_only_a_pipe_outside_of_training_has_a_frame() -> None:
    def frames(figure: Figure) -> int:
        return sum(patch.get_linestyle() == ":" for patch in figure.axes[0].patches)

    assert [frames(drawn(10, {}, trained=trained)) for trained in (True, False, None)] == [0, 1, 0]


def test_a_map_without_verdicts_has_none_of_it() -> None:
    figure = map_figure(evaluation([record(90, 60)]))
    assert not figure.axes[0].patches
    assert not figure.legends
    assert words(figure)[0] == "80"
