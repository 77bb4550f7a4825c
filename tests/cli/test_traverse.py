"""`train`, `eval` and `view` serve a whole robot as they serve an arm; what serves only one says so of the other."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from helpers.command import run

from pipenav.errors import PipenavError
from pipenav.evaluation.results import read_evaluation
from pipenav.motions.trajectory_file import read_trajectory
from pipenav.pipes.route_sets import parse_routes
from pipenav.policies.policy import load_policy
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome

pytestmark = pytest.mark.slow

TINY = {
    "learner.robots": 4,
    "learner.rollout_steps": 16,
    "learner.batch_size": 64,
    "network.policy": [8],
    "network.value": [8],
    "check.episodes": 1,
    "task.max_steps": 12,
}
RUN = [(90, "left"), (75, "right")]


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a short training."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    settings = [part for key, value in TINY.items() for part in ("--set", f"{key}={value}")]
    args = ("train", "--preset", "pirate-strong", "--steps", "128", "--pipes", "d=90,angle=90", "--out", str(folder))
    assert run(*args, *settings) == 0
    return folder


def test_training_writes_a_policy_that_says_what_it_is_for(trained: Path) -> None:
    header = load_policy(trained / "best.zip").header
    assert header.robot == load_robot("pirate-strong")
    assert header.task.kind == "traverse"
    assert [part.name for part in header.observation][-1] == "turns_beside"
    assert [part.joint for part in header.action] == [one.name for one in header.robot.commanded_parts]
    assert {part.unit for part in header.action} == {"rad", "rad/s"}
    table = json.loads((trained / "config.json").read_text(encoding="utf-8"))
    assert table["task"]["kind"] == "traverse"


def test_a_training_goes_on_where_it_stopped(trained: Path) -> None:
    assert run("train", "--resume", str(trained), "--steps", "192") == 0


def test_an_evaluation_counts_traverses(trained: Path, tmp_path: Path) -> None:
    args = ("--pipes", "d=90,angle=90", "--pipes", "d=70,angle=60,turn=right", "--episodes", "2")
    assert run("eval", "--policy", str(trained / "best.zip"), *args, "--out", str(tmp_path)) == 0
    found = read_evaluation(tmp_path)
    assert (found.stage, found.robot) == ("traverse", "pirate-strong")
    for record in found.pipes:
        assert (record.traverse_attempts, record.traverse_successes) == (2, 0)
        assert record.reach_attempts is record.rear_attempts is record.located is None
        assert record.failures == {"timeout": 2}
    assert found.diameters[0].traverse_success == 0.0
    assert found.diameters[0].traverse_success_high is not None


def test_a_view_is_the_evaluations_episode_and_can_be_read_again(trained: Path, tmp_path: Path) -> None:
    table, picture = tmp_path / "way.csv", tmp_path / "way.png"
    args = ("--pipes", "d=90,angle=60", "--out", str(table), "--out", str(picture))
    assert run("view", "--policy", str(trained / "best.zip"), *args) == 0
    recording = read_trajectory(table)
    assert recording.q.shape[1] == load_robot("pirate").coordinates
    assert recording.header.outcome == Outcome.TIMEOUT.label
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert run("view", "--trajectory", str(table), "--out", str(tmp_path / "again.png")) == 0
    assert (tmp_path / "again.png").stat().st_size == pytest.approx(picture.stat().st_size, rel=0.1)
    assert run("mirror-rear", "--trajectory", str(table), "--out", str(tmp_path / "rear.csv")) == 1


def test_an_evaluation_names_routes_beside_corners(trained: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    corners = "".join(f'[[corners]]\nangle_deg = {angle}\nturn = "{turn}"\n' for angle, turn in RUN)
    mine.write_text(f"schema = 1\ndiameter_mm = 100\n{corners}", encoding="utf-8")
    args = ("--pipes", "runs-level:3", "--pipes", str(mine), "--pipes", "d=90,angle=80", "--episodes", "1")
    assert run("eval", "--policy", str(trained / "best.zip"), *args, "--out", str(tmp_path / "eval")) == 0
    found = read_evaluation(tmp_path / "eval")
    names = [parse_routes(["runs-level:3"])[0].name, "run-d100-L90-R75", None]
    assert [(record.route, record.angle_deg, record.turn) for record in found.pipes] == [
        (names[0], None, None),
        (names[1], None, None),
        (None, 80.0, "left"),
    ]
    assert [record.failures for record in found.pipes] == [{"timeout": 1}] * 3
    assert [row.diameter_mm for row in found.diameters] == [100.0, 90.0]
    rows = list(csv.DictReader((tmp_path / "eval" / "eval.csv").open(encoding="utf-8")))
    assert [row["route"] for row in rows] == [*names[:2], ""]
    assert {row["angle_deg"] for row in rows[:2]} == {""}


def test_a_view_of_a_route_can_be_read_again_and_has_no_rear_half(trained: Path, tmp_path: Path) -> None:
    table, picture = tmp_path / "run.csv", tmp_path / "run.png"
    args = ("--pipes", "runs-level:3", "--out", str(table), "--out", str(picture))
    assert run("view", "--policy", str(trained / "best.zip"), *args) == 0
    recording = read_trajectory(table)
    assert recording.header.pipe == parse_routes(["runs-level:3"])[0]
    assert len(recording.q) == 1 + 5 * TINY["task.max_steps"]  # type: ignore[operator]  # twelve steps for each corner
    assert run("view", "--trajectory", str(table), "--out", str(tmp_path / "again.png")) == 0
    assert (tmp_path / "again.png").stat().st_size == pytest.approx(picture.stat().st_size, rel=0.1)
    assert run("mirror-rear", "--trajectory", str(table), "--out", str(tmp_path / "rear.csv")) == 1
    broken = table.read_text(encoding="utf-8").replace('"diameter_m": 0.09', '"diameter_m": "wide"')
    table.write_text(broken, encoding="utf-8")
    with pytest.raises(PipenavError, match=r"line 1: pipe\.diameter: input should be a valid number, given 'wide'"):
        read_trajectory(table)


def test_runs_can_be_trained_in(tmp_path: Path) -> None:
    settings = [part for key, value in TINY.items() for part in ("--set", f"{key}={value}")]
    args = ("train", "--preset", "pirate", "--steps", "64", "--set", 'pipes=["runs-level", "d=90,angle=90"]')
    assert run(*args, "--out", str(tmp_path / "run"), *settings) == 0
    assert load_policy(tmp_path / "run" / "best.zip").header.task.kind == "traverse"


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["train", "--preset", "pirate", "--robot", "basic"], "robot 'basic' hangs on a mount"),
        (["train", "--robot", "pirate"], "robot 'pirate' stands free"),
        (["train", "--preset", "pirate", "--set", "task.alfa=1"], "did you mean 'task.alpha'"),
        (["eval", "--policy", "arm", "--stage", "traverse"], "reaches a target around the corner"),
        (
            ["train", "--preset", "pirate-strong-gravity", "--pipes", "runs-rolled", "--backend", "pybullet"],
            "backend 'pybullet' moves robots only in a plane: choose --backend mujoco",
        ),
        (
            ["train", "--preset", "pirate", "--pipes", "runs-rolled", "--set", "randomise.noise=[0.0, 0.01]"],
            "randomise disturbs robots in a plane",
        ),
        (["eval", "--policy", "arm", "--pipes", "runs-level"], "'runs-level' names routes: give single corners"),
        (["eval", "--stage", "locate", "--robot", "pirate"], "drives a slide followed by hinges"),
        (["eval", "--policy", "baseline:centreline", "--robot", "pirate"], "drives a slide followed by hinges"),
    ],
)
def test_what_does_not_fit_is_said_and_nothing_is_left_behind(
    args: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*args) == 1
    assert said in " ".join(capsys.readouterr().err.split())
    assert not list(tmp_path.rglob("*.zip"))


def test_a_random_baseline_traverses_where_the_robot_does(tmp_path: Path) -> None:
    args = ("--robot", "pirate", "--pipes", "d=90,angle=90", "--episodes", "1", "--out", str(tmp_path))
    assert run("eval", "--policy", "baseline:random", *args) == 0
    assert read_evaluation(tmp_path).stage == "traverse"


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["--policy", "baseline:sequence", "--pipes", "runs-rolled:1"], "turns corners in one plane"),
        (["--policy", "pirate-strong-gravity", "--backend", "pybullet"], "cannot simulate gravity along the pipe"),
    ],
)
def test_an_evaluation_that_is_refused_once_it_runs_leaves_no_folder(
    args: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("eval", *args, "--episodes", "1") == 1
    assert said in " ".join(capsys.readouterr().err.split())
    assert not list(tmp_path.iterdir())
