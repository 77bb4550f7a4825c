"""A folder of experiments' results that holds the thesis's own figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.results import Evaluation
from pipenav.evaluation.thesis import ANGLES_DEG, thesis_rows
from pipenav.experiments.definition import experiment_names, load_experiment
from pipenav.experiments.plan import ExperimentPlan, ExperimentSettings, open_plan, resolved_agent
from pipenav.experiments.tables import SHOWN_STAGES


def thesis_evaluation(stage: str, percent: dict[str, dict[float, float]], policy: str = "p") -> Evaluation:
    """An evaluation of the thesis's pipes in which each stage succeeded in so many percent of its attempts."""
    records = []
    for diameter in (120.0, 110.0, 100.0, 90.0):
        for angle in ANGLES_DEG:
            counts: dict[str, Any] = {}
            left = 100
            for shown in SHOWN_STAGES[stage]:
                passed = round(left * percent.get(shown, {}).get(diameter, 100.0) / 100)
                if shown == "locate":
                    counts["located"] = passed
                elif shown != "whole":
                    counts |= {f"{shown}_attempts": left, f"{shown}_successes": passed}
                left = passed
            failed = {"timeout": 100 - left} if left < 100 else {}
            records.append(
                PipeRecord(diameter_mm=diameter, angle_deg=angle, turn="left", episodes=100, failures=failed, **counts)
            )
    config = EvaluationConfig(policy=None if stage == "locate" else policy, episodes=100, stage=stage)
    return Evaluation.of(records, config=config, robot="basic")


def thesis_figures(table: str | None, label: str) -> dict[str, dict[float, float]]:
    """Success [percent] by diameter [mm], for each stage of a row of the thesis."""
    return {row.stage: row.percent for row in thesis_rows() if (row.table, row.agent) == (table, label)}


def write_thesis_results(folder: Path) -> ExperimentPlan:
    """A folder of results that holds the thesis's own figures, and for (d) and (e) what it says in words."""
    plan = open_plan(experiment_names(), 2, ExperimentSettings(episodes=100), folder)
    said = {
        "d": {"rear": {120.0: 100.0, 110.0: 100.0, 100.0: 60.0, 90.0: 2.0}},
        "e": {"locate": dict.fromkeys((120.0, 110.0, 100.0, 90.0), 100.0)},
    }
    for name in experiment_names():
        for row in load_experiment(name).rows:
            percent = thesis_figures(row.table, row.label) or said.get(name, {})
            for seed in plan.seeds:
                folder = plan.evaluation_folder(row, resolved_agent(plan, row), seed)
                if not (folder / "eval.json").exists():
                    folder.mkdir(parents=True)
                    (folder / "eval.json").write_text(thesis_evaluation(row.stage, percent).to_json(), encoding="utf-8")
    return plan
