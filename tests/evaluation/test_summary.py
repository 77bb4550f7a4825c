"""Words for evaluations."""

from __future__ import annotations

import pytest
from helpers.evaluations import GRID, RUNS

from pipenav.evaluation.results import Evaluation
from pipenav.evaluation.summary import circumstances, percent, route_corners


@pytest.mark.parametrize(
    ("share", "decimals", "text"),
    [(1.0, 1, "100"), (0.0, 1, "0"), (0.9999, 1, "99.9"), (0.0001, 1, "0.1"), (0.996, 0, "99"), (0.5, 0, "50")],
)
def test_only_perfect_shares_read_perfect(share: float, decimals: int, text: str) -> None:
    assert percent(share, decimals) == text


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "backend mujoco (default settings), disturbances none, seed 0"),
        (
            {"disturb": "real-world", "seed": 7, "options": {"timestep": 0.005}},
            "backend mujoco (timestep 0.005), disturbances real-world, seed 7",
        ),
        ({"pipes": ("a", "b", "c", "d")}, "episodes, a and 3 more, basic robot"),
    ],
)
def test_circumstances_name_all_that_was_set(given: dict[str, object], said: str) -> None:
    config = GRID.config.model_copy(update=given)
    assert said in circumstances(Evaluation.of(GRID.pipes, config=config, robot="basic"))


def test_long_routes_are_named_by_their_first_corners() -> None:
    assert [route_corners(record) for record in RUNS.pipes] == [
        "R65-L70-R100-R55-L110",
        "R120-R120-R120-R120-R120-...",
        "L90",
    ]
