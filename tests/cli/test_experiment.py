"""The command `experiment`: a small experiment from end to end, and folders that it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.command import run

from pipenav.experiments.plan import ExperimentSettings, open_plan


def test_an_unknown_experiment_is_answered_with_the_known(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("experiment", "z") == 1
    assert "unknown experiment 'z': choose 'a', 'all', 'b'" in capsys.readouterr().err


def test_results_of_other_settings_are_not_mixed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    open_plan(["e"], 1, ExperimentSettings(steps=1000, episodes=2), tmp_path)
    assert run("experiment", "e", "--episodes", "2", "--out", str(tmp_path)) == 1
    assert "holds results of 1,000 steps, 2 episodes per pipe" in capsys.readouterr().err


def test_steps_where_nothing_is_trained_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("experiment", "e", "--steps", "2000", "--out", str(tmp_path / "new")) == 1
    assert "experiment e trains nothing, so --steps would do nothing: leave it out." in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
def test_a_damaged_folder_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    open_plan(["e"], 1, ExperimentSettings(episodes=1), tmp_path)
    (tmp_path / "elapsed.json").write_text('{"hours": 1}', encoding="utf-8")
    assert run("experiment", "e", "--seeds", "1", "--episodes", "1", "--out", str(tmp_path)) == 1
    assert "elapsed.json is damaged, it has no number 'seconds'" in capsys.readouterr().err


@pytest.mark.slow
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
    training_folder = tmp_path / "agents" / "high-fidelity-history-c3-1_5" / "seed-0"
    assert json.loads((training_folder / "trained.json").read_text())["steps"] == 2048
    whole = json.loads((training_folder / "eval-passage" / "eval.json").read_text())
    assert sum(record["located"] for record in whole["pipes"]) == 60

    assert "All of it took" in text
    assert run(*command, "--out", str(tmp_path)) == 0  # nothing is left to do
    assert (tmp_path / "report.md").read_text(encoding="utf-8") == text
