"""Evaluations of every kind, made up."""

from __future__ import annotations

import io
from typing import Any

from rich.console import Console

from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.report import evaluation_table
from pipenav.evaluation.results import Evaluation, Extremes
from pipenav.evaluation.thesis import ANGLES_DEG, thesis_best


def record(diameter: float, angle: float, turn: str = "left", successes: int = 8, **facts: Any) -> PipeRecord:
    """A pipe in which the front half was tried ten times."""
    measured = {
        "failures": {"limit": 10 - successes} if successes < 10 else {},
        "mean_steps": 25.0 if successes else None,
        "min_range_m": 0.004,
        "max_penetration_m": 0.0012,
        "peak_force_n": 12.5,
        "contact_time_share": 0.125,
    }
    stages = {"reach_attempts": 10, "reach_successes": successes}
    return PipeRecord(diameter_mm=diameter, angle_deg=angle, turn=turn, episodes=10, **{**stages, **measured, **facts})


def evaluation(pipes: list[PipeRecord]) -> Evaluation:
    """An evaluation of some pipes by a policy that commands torques."""
    return Evaluation.of(
        pipes,
        config=EvaluationConfig(policy="some-policy", pipes=("thesis",), episodes=10, stage="reach"),
        robot="basic",
        thesis=thesis_best("torque"),
        extremes=Extremes(0.00111, 42.4),
    )


GRID = evaluation(
    [record(d, a, turn, 10 if d > 90 else 7) for turn in ("left", "right") for d in (120, 90) for a in ANGLES_DEG]
)


BARE = evaluation([PipeRecord(diameter_mm=70, angle_deg=55, turn="right", episodes=1)])


WHOLE = evaluation(
    [
        record(90, 60, located=10, rear_attempts=8, rear_successes=7, failures={"limit": 2, "rear timeout": 1}),
        record(90, 75, located=9, reach_attempts=9, failures={"not located": 1}, rear_attempts=8, rear_successes=8),
    ]
)


RUNS = evaluation(
    [
        PipeRecord(
            diameter_mm=d,
            angle_deg=None,
            turn=None,
            route=f"run-d{d:g}-{corners}",
            episodes=4,
            reach_attempts=4,
            reach_successes=passed,
            failures={"limit": 4 - passed},
        )
        for d, corners, passed in ((70, "R65-L70-R100-R55-L110", 1), (120, "-".join(["R120"] * 50), 3), (70, "L90", 2))
    ]
)


MIXED = evaluation([record(90, 60), *RUNS.pipes])


TEES = evaluation(
    [
        record(100, 180 if way == "straight" else angle, successes=2 * i + 1, fitting=f"tee {angle} {way}")
        for angle in (45, 90)
        for i, way in enumerate(("straight", "into", "out"))
    ]
    + [record(100, 90, successes=10)]
)


CASES = {
    "tees": TEES,
    "grid": GRID,
    "bare": BARE,
    "whole": WHOLE,
    "runs": RUNS,
    "mixed": MIXED,
    "perfect": evaluation([record(90, 60, successes=10)]),
}


def shown(case: Evaluation) -> str:
    """The table of an evaluation, as it is printed."""
    text = io.StringIO()
    Console(file=text, width=100).print(evaluation_table(case))
    return text.getvalue()
