"""The success figures of the thesis, to compare evaluations with; thesis.csv beside this file holds its tables."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

ANGLES_DEG = tuple(float(angle) for angle in range(55, 126, 5))
"""The interior angles over which every figure of the thesis is a mean (4.2.3)."""


class ThesisRow(NamedTuple):
    """An agent in a table of the thesis.

    Attributes:
        table: number of the table, e.g. `5.1`.
        control: `torque` or `position`.
        robot: `basic` or `high-fidelity`.
        stage: `reach` or `rear`; figures of `rear` are shares of the episodes in which `reach` succeeded.
        agent: state, reward weights and target, in words.
        percent: success [percent] by diameter [mm].
    """

    table: str
    control: str
    robot: str
    stage: str
    agent: str
    percent: dict[float, float]


@lru_cache(maxsize=1)
def thesis_rows() -> tuple[ThesisRow, ...]:
    """Every row of tables 5.1 to 5.6."""
    text = Path(__file__).with_suffix(".csv").read_text(encoding="utf-8")
    return tuple(_row(row) for row in csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def thesis_best(control: str, robot: str = "basic", stage: str = "reach") -> dict[float, float]:
    """The thesis's best success [percent] of all its agents, by diameter [mm]; empty where it has none."""
    best: dict[float, float] = {}
    for row in thesis_rows():
        if (row.control, row.robot, row.stage) == (control, robot, stage):
            best |= {d: max(percent, best.get(d, 0.0)) for d, percent in row.percent.items()}
    return best


def is_thesis_set(angles_deg: Iterable[float | None]) -> bool:
    """Whether these are the thesis's angles, so that a mean over them can be compared with its figures."""
    return set(angles_deg) == set(ANGLES_DEG)


def _row(row: dict[str, str]) -> ThesisRow:
    percent = {float(key[1:]): float(value) for key, value in row.items() if key.startswith("d")}
    return ThesisRow(row["table"], row["control"], row["fidelity"], row["stage"], row["agent"], percent)
