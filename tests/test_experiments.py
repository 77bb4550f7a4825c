"""The thesis's experiments: definitions that fit its tables, findings judged rightly, a small run from end to end."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from command import run

from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.results import Evaluation
from pipenav.evaluation.thesis import ANGLES_DEG, thesis_rows
from pipenav.experiments.definition import agents_of, chosen, experiment_names, load_agents, load_experiment
from pipenav.experiments.figures import success_figure
from pipenav.experiments.findings import paragraph
from pipenav.experiments.jobs import evaluation_jobs, training_jobs
from pipenav.experiments.plan import ExperimentPlan, ExperimentSettings, open_plan, resolved_agent
from pipenav.experiments.tables import SHOWN_STAGES, results


def evaluation(stage: str, percent: dict[str, dict[float, float]], policy: str = "p") -> Evaluation:
    """An evaluation of the thesis's pipes in which each phase succeeded in so many percent of its attempts."""
    records = []
    for diameter in (120.0, 110.0, 100.0, 90.0):
        for angle in ANGLES_DEG:
            counts: dict[str, Any] = {}
            left = 100
            for phase in SHOWN_STAGES[stage]:
                passed = round(left * percent.get(phase, {}).get(diameter, 100.0) / 100)
                if phase == "locate":
                    counts["located"] = passed
                elif phase != "whole":
                    counts |= {f"{phase}_attempts": left, f"{phase}_successes": passed}
                left = passed
            failed = {"timeout": 100 - left} if left < 100 else {}
            records.append(
                PipeRecord(diameter_mm=diameter, angle_deg=angle, turn="left", episodes=100, failures=failed, **counts)
            )
    config = EvaluationConfig(policy=None if stage == "locate" else policy, stage=stage, episodes=100)
    return Evaluation.of(records, config=config, robot="basic")


def thesis_figures(table: str | None, label: str) -> dict[str, dict[float, float]]:
    return {row.stage: row.percent for row in thesis_rows() if (row.table, row.agent) == (table, label)}


@pytest.fixture
def thesis_plan(tmp_path: Path) -> ExperimentPlan:
    """A folder of results that holds the thesis's own figures, and for (d) and (e) what it says in words."""
    plan = open_plan(experiment_names(), 2, ExperimentSettings(episodes=100), tmp_path)
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
                    (folder / "eval.json").write_text(evaluation(row.stage, percent).to_json(), encoding="utf-8")
    return plan


@pytest.mark.parametrize("name", experiment_names())
def test_every_row_that_names_a_table_stands_in_it(name: str) -> None:
    for row in load_experiment(name).rows:
        assert bool(thesis_figures(row.table, row.label)) == (row.table is not None)


@pytest.mark.parametrize("name", experiment_names())
def test_every_row_can_be_told_apart_and_stands_in_the_legend(name: str, thesis_plan: ExperimentPlan) -> None:
    titles = [row.title for row in load_experiment(name).rows]
    assert len(set(titles)) == len(titles)
    (legend,) = success_figure(results(thesis_plan, name), name).legends
    assert {text.get_text() for text in legend.get_texts()} == set(titles)


def test_every_row_of_the_thesis_stands_in_an_experiment() -> None:
    ours = {(row.table, row.label) for name in experiment_names() for row in load_experiment(name).rows}
    assert {(row.table, row.agent) for row in thesis_rows()} <= ours


@pytest.mark.parametrize("agent", load_agents())
def test_every_agent_is_a_recipe_of_the_thesis(agent: str) -> None:
    config = load_agents()[agent].config(seed=3, steps=None)
    assert config.seed == 3
    assert config.steps == 120_000
    assert config.pipes == ("thesis-train",)
    assert config.task.control == ("torque" if agent.startswith("torque") else "position")
    assert config.task.observation == ("basic" if "basic" in agent else "history")
    assert agent in agents_of(chosen("all"))


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


def test_the_best_agent_is_taken_over(thesis_plan: ExperimentPlan) -> None:
    (row,) = load_experiment("d").rows
    assert resolved_agent(thesis_plan, row) == "position-history-c3-1_5"


def test_what_is_there_is_not_done_again(thesis_plan: ExperimentPlan) -> None:
    assert evaluation_jobs(thesis_plan, 1, ("reach", "reach-rear", "locate", "passage")) == []
    assert len(training_jobs(thesis_plan, 1)) == 2 * len(load_agents())


def test_an_agent_that_several_experiments_show_is_trained_once() -> None:
    names = agents_of(chosen("all"))
    assert len(names) == len(set(names)) == len(load_agents())


def test_an_unknown_experiment_is_answered_with_the_known(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("experiment", "z") == 1
    assert "unknown experiment 'z': choose 'a', 'all', 'b'" in capsys.readouterr().err


def test_results_of_other_settings_are_not_mixed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    open_plan(["e"], 1, ExperimentSettings(steps=1000, episodes=2), tmp_path)
    assert run("experiment", "e", "--steps", "2000", "--episodes", "2", "--out", str(tmp_path)) == 1
    assert "holds results of 1,000 steps, 2 episodes per pipe" in capsys.readouterr().err


def test_a_damaged_folder_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    open_plan(["e"], 1, ExperimentSettings(steps=1000, episodes=1), tmp_path)
    (tmp_path / "elapsed.json").write_text('{"hours": 1}', encoding="utf-8")
    assert run("experiment", "e", "--seeds", "1", "--steps", "1000", "--episodes", "1", "--out", str(tmp_path)) == 1
    assert "elapsed.json is damaged, it has no number 'seconds'" in capsys.readouterr().err


def test_an_experiment_from_end_to_end(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ("experiment", "f", "--seeds", "1", "--steps", "2048", "--episodes", "1", "--jobs", "2")
    assert run(*command, "--out", str(tmp_path)) == 0
    assert "report.html" in capsys.readouterr().out
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "| history state, C3=1.5, target located (approach I) | locate | ours |" in text
    assert "thesis, table 5.6" in text
    assert "pipenav train --preset thesis-position --set robot=high-fidelity" in text
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == 2
    run_folder = tmp_path / "agents" / "high-fidelity-history-c3-1_5" / "seed-0"
    assert json.loads((run_folder / "trained.json").read_text())["steps"] == 2048
    whole = json.loads((run_folder / "eval-passage" / "eval.json").read_text())
    assert sum(record["located"] for record in whole["pipes"]) == 60

    assert "All of it took" in text
    assert run(*command, "--out", str(tmp_path)) == 0  # nothing is left to do
    assert (tmp_path / "report.md").read_text(encoding="utf-8") == text
