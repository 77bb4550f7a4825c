"""Files that pipenav 0.1 wrote: each is opened by the command or function that a user would open it with."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from stable_baselines3 import PPO

from pipenav.cli import main
from pipenav.evaluation.results import read_evaluation
from pipenav.export.corner_folder import read_pipe
from pipenav.export.route_folder import read_route_folder
from pipenav.learning.config import load_config
from pipenav.learning.figures import write_training_plot
from pipenav.learning.progress import PROGRESS_COLUMNS, progress_columns
from pipenav.learning.training_folder import TrainingFolder
from pipenav.motions.trajectory_file import read_trajectory
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.route_sets import read_route
from pipenav.policies.policy import load_policy
from pipenav.robots.robot import load_robot

EARLIER = Path(__file__).parent / "data" / "0.1"


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path


def run(*arguments: object) -> None:
    """Run a command, which must succeed."""
    with pytest.raises(SystemExit) as left:
        main([str(argument) for argument in arguments])
    assert left.value.code in (None, 0)


def test_a_policy_is_evaluated(here: Path) -> None:
    policy = EARLIER / "mission" / "policy.zip"
    assert load_policy(policy).header.robot.name == "real-setup"
    run("eval", "--policy", policy, "--pipes", "d=130,angle=90", "--episodes", 3, "--out", here / "evaluation")
    assert read_evaluation(here / "evaluation").success == 1.0


@pytest.mark.slow
def test_stable_baselines_opens_a_policy() -> None:
    model = PPO.load(EARLIER / "mission" / "policy.zip", device="cpu")
    assert model.lr_schedule(0.0) < model.lr_schedule(1.0)


def test_a_pipe_folder_is_read() -> None:
    assert read_pipe(EARLIER / "corner-d90-a60-right") == PipeCorner.of(90, 60, "right")


def test_a_route_folder_is_read_and_made_again_by_the_older_option(here: Path) -> None:
    route = read_route(EARLIER / "my-run.toml")
    assert read_route_folder(EARLIER / "my-run") == route
    assert sum(route.straights) == pytest.approx(1.9)
    shutil.copytree(EARLIER / "my-run", here / "my-run")
    run("gen-pipe", "--run", EARLIER / "my-run.toml", "--out", here)
    assert read_route_folder(here / "my-run") == route


@pytest.mark.slow
def test_a_training_goes_on(here: Path) -> None:
    training = here / "training"
    shutil.copytree(EARLIER / "training", training)
    run("train", "--resume", training, "--steps", 600)
    with (training / "progress.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == PROGRESS_COLUMNS
    assert (rows[0]["steps"], rows[0]["min_range_m"]) == ("64", "0.02672")
    assert int(rows[-1]["steps"]) >= 600
    assert all(row["min_range_m"] for row in rows)
    assert load_policy(training / "last.zip").header.training["steps"] == int(rows[-1]["steps"])


@pytest.mark.slow
def test_a_training_is_drawn_and_its_weights_are_a_start(here: Path) -> None:
    folder = TrainingFolder(EARLIER / "training")
    columns = progress_columns(folder.progress.read_text(encoding="utf-8"))
    assert columns["min_range_m"] == [0.02672, 0.02555, 0.02508, 0.02711, 0.02391, 0.03516, 0.03797]
    write_training_plot(here / "training.png", folder.progress)
    assert Image.open(here / "training.png").size[0] > 500
    run("train", "--config", EARLIER / "recipe.toml", "--steps", 64, "--from", folder.path, "--out", here / "next")
    assert (here / "next" / "best.zip").is_file()


def test_a_configuration_file_is_laid_over_a_preset() -> None:
    config = load_config(file=EARLIER / "recipe.toml")
    assert (config.seed, config.steps, config.learner.robots, config.network.policy) == (3, 400, 8, (16,))
    assert config.task == load_config("arm").task
    before = TrainingFolder.open(EARLIER / "training").config
    # The preset trains otherwise since.
    today = {name: getattr(config, name) for name in ("pipes", "description", "options", "learner")}
    assert before.model_copy(update=today) == config


def test_an_evaluation_of_a_passage_is_read() -> None:
    evaluation = read_evaluation(EARLIER / "evaluation")
    assert (evaluation.success, evaluation.success_low, evaluation.stage) == (1.0, 0.6755924351161198, "passage")
    assert [(pipe.located, pipe.reach_successes, pipe.rear_successes) for pipe in evaluation.pipes] == [(4, 4, 4)] * 2
    assert evaluation.pipes[0].min_range_m == 0.035
    assert evaluation.config.pipes == ("d=100.0,angle=90.0,turn=left", "d=90.0,angle=60.0,turn=right")
    assert (evaluation.config.policy, evaluation.config.episodes) == ("arm", 4)


def test_an_evaluation_in_routes_is_read_as_today(here: Path) -> None:
    evaluation = read_evaluation(EARLIER / "evaluation-routes")
    assert (evaluation.stage, len(evaluation.pipes), evaluation.episodes) == ("traverse", 24, 48)
    assert evaluation.pipes[0].route == evaluation.config.pipes[0]
    assert all(pipe.traverse_attempts == 2 for pipe in evaluation.pipes)
    (here / "eval.json").write_text(evaluation.to_json(), encoding="utf-8")
    assert read_evaluation(here) == evaluation
    assert '"schema": 2' in evaluation.to_json()


@pytest.mark.slow
def test_trajectories_are_drawn_and_mirrored(here: Path) -> None:
    run("mirror-rear", "--trajectory", EARLIER / "front.csv", "--out", "rear.csv")
    now, before = read_trajectory(here / "rear.csv"), read_trajectory(EARLIER / "rear.csv")
    assert np.array_equal(now.q, before.q)
    assert (now.header.stage, now.header.pipe) == (before.header.stage, before.header.pipe)
    parts = [f"--trajectory={EARLIER / 'mission' / name}" for name in ("locate.csv", "front.csv")]
    run("mirror-rear", *parts, "--out", "whole.csv")
    motions = [f"--trajectory={EARLIER / name}" for name in ("locate.csv", "front.csv", "rear.csv")]
    run("view", *motions, "--out", "passage.png")
    assert Image.open(here / "passage.png").size[0] > 1000


def test_trajectories_say_what_they_said() -> None:
    stages = {name: str(read_trajectory(EARLIER / f"{name}.csv").header.stage) for name in ("locate", "front", "rear")}
    assert stages == {"locate": "locate", "front": "reach", "rear": "rear"}
    traverse = read_trajectory(EARLIER / "traverse.csv")
    assert (traverse.header.stage, traverse.header.outcome, traverse.robot.name) == ("traverse", "reached", "pirate")
    assert len(traverse.header.pipe.interior_angles) == 5
    assert read_trajectory(EARLIER / "mission" / "front.csv").header.outcome == "reached"


def test_a_mission_is_replayed_bit_for_bit(capsys: pytest.CaptureFixture[str]) -> None:
    run("replay", EARLIER / "mission" / "telemetry.jsonl", "--draw", "mission.png")
    assert "29 ticks" in capsys.readouterr().out


@pytest.mark.parametrize(("name", "now"), [("basic", "basic"), ("pirate", "pirate-strong")])
def test_a_robot_of_schema_1_is_the_shipped_one(name: str, now: str, capsys: pytest.CaptureFixture[str]) -> None:
    earlier, today = load_robot(str(EARLIER / "robots" / f"{name}.toml")), load_robot(now)
    assert (earlier.links, earlier.laser, earlier.actuators) == (today.links, today.laser, today.actuators)
    run("robots", EARLIER / "robots" / f"{name}.toml")
    assert earlier.description in capsys.readouterr().out
