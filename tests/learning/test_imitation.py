"""Recordings as lessons, and what a policy learns from them before PPO."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from helpers.command import run
from helpers.tiny_training import tiny, weights
from hypothesis import given
from hypothesis import strategies as st

from pipenav.backends.messages import Reading
from pipenav.backends.simulators import open_simulator
from pipenav.deployment.telemetry import read_telemetry
from pipenav.driving.plans import make_plan
from pipenav.driving.scripted import script_for
from pipenav.driving.sessions import Session
from pipenav.envs.sb3_env import TaskVecEnv
from pipenav.errors import PipenavError
from pipenav.learning.config import TrainConfig
from pipenav.learning.imitation import imitate
from pipenav.learning.progress import TrainingProgress
from pipenav.learning.recordings import Lessons, _discounted, load_lessons
from pipenav.learning.train import new_model, train, training_env
from pipenav.learning.training_folder import TrainingFolder
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach import action as actions
from pipenav.tasks.reach import observation
from pipenav.tasks.registry import task_of


def drive(folder: Path, policy: str | None, robot: str | None, pipe: str, by_hand: bool = True) -> Path:
    plan = make_plan(policy, robot, [pipe], 2, 0).on("mujoco", {}, None, folder)
    folder.mkdir()
    shared = plan.controller is not None
    Session(plan, (lambda _: script_for(plan.robot, 0, shared)) if by_hand else None).run()
    return folder


@pytest.fixture(scope="module")
def taught(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two episodes of an arm by hand, in a left turn; not to be changed."""
    return drive(tmp_path_factory.mktemp("drives") / "taught", None, "basic", "d=100,angle=90")


def lessons_config(*folders: Path, **more: Any) -> TrainConfig:
    return tiny(**{"recordings.folders": [str(folder) for folder in folders], "recordings.epochs": 3, **more})


def test_recordings_hold_what_a_policy_would_have_seen_and_the_action_of_each_command(taught: Path) -> None:
    """Observations and actions are those of the task, computed anew from the readings and the commands beside them."""
    robot, task = load_robot("basic"), make_plan(None, "basic", ["d=100,angle=90"], 1, 0).task
    scale = task_of(task).observation_scale(robot)
    for path in sorted(taught.glob("*.jsonl")):
        for tick in read_telemetry(path).ticks:
            q, qd, ranges, command = (np.array([tick[key]]) for key in ("q", "qd", "ranges", "command"))
            now = observation.canonical(robot, Reading(q, qd, ranges, np.zeros(1)), np.ones(1))
            nearest = np.clip((command - q) / actions.position_step(robot, task), -1, 1)
            assert np.allclose(tick["action"], nearest, atol=1e-12)
            seen = np.array([tick["observation"]]) * scale
            parts = np.split(seen, np.cumsum([len(field.scale) for field in task_of(task).layout(robot)])[:-1], axis=1)
            named = {field.name: part for field, part in zip(task_of(task).layout(robot), parts, strict=True)}
            for name, value in (("q", now.q), ("qd", now.qd), ("ranges", now.ranges)):
                assert np.allclose(named[name], value, atol=1e-9)


@pytest.mark.parametrize(
    ("policy", "pipe"), [("arm", "d=100,angle=90,turn=right"), ("pirate-strong", "d=90,angle=90,turn=right")]
)
def test_actions_of_a_policy_are_found_again_in_its_commands(policy: str, pipe: str) -> None:
    """The batch's way from a command back to an action, on commands whose action is known."""
    plan = make_plan(policy, None, [pipe], 1, 0)
    rng = np.random.default_rng(0)
    task = task_of(plan.task)
    episodes = task.sample(plan.robot, plan.pipes, rng)
    simulator = open_simulator("mujoco", plan.robot, 1, {"threads": 1}, 8)
    told: list[Any] = []
    step = simulator.step
    simulator.step = lambda command: (told.append(command.values.copy()), step(command))[1]  # type: ignore[method-assign]
    batch = task.batch(plan.robot, simulator, 1, lambda _: episodes)
    batch.reset()
    joints = len(plan.robot.joints)
    for _ in range(10):
        action = rng.uniform(-0.5, 0.5, (1, batch.action_size))
        batch.begin(action)()
        again = batch.carried_out(np.array([0]), told[-1])
        bends = told[-1][:, :joints]  # at a limit, or as far from its joint as may be, a command has many actions
        free = (bends > plan.robot.lower) & (bends < plan.robot.upper)
        free &= np.abs(bends - batch.q[:, -joints:]) < 0.999 * plan.task.alpha
        assert np.allclose(again[:, :joints][free], action[:, :joints][free], atol=1e-9)
        assert free.any()
        rolled = again[:, joints:] != 0
        assert np.allclose(again[:, joints:][rolled], action[:, joints:][rolled], atol=1e-9)
        batch.end()
    batch.close()


@given(st.lists(st.floats(-10, 10, width=32), min_size=1, max_size=30), st.floats(0, 1))
def test_returns_follow_bellmans_equation(rewards: list[float], gamma: float) -> None:
    returns = _discounted(np.array(rewards, np.float32), gamma)
    following = np.append(returns[1:], 0.0)
    assert np.allclose(returns, np.array(rewards) + gamma * following, atol=1e-3)


def learned(config: TrainConfig, lessons: Lessons) -> tuple[float, float]:
    """Errors of a fresh policy's actions and values on lessons after a supervised start."""
    env: TaskVecEnv = training_env(config, np.random.default_rng(0))
    model = new_model(config, env)
    imitate(model, lessons, config)
    with torch.no_grad():
        seen = torch.from_numpy(lessons.observations)
        distribution = model.policy.get_distribution(seen)
        values = model.policy.predict_values(seen)[:, 0].numpy()
    env.close()
    error = float(((distribution.mode().numpy() - lessons.actions) ** 2).mean())
    away = np.nan if lessons.returns is None else float(((values - lessons.returns) ** 2).mean())
    return error, away


def test_a_policy_learns_actions_and_values_the_better_the_longer(taught: Path) -> None:
    config = lessons_config(taught)
    lessons = load_lessons(config)
    assert lessons.returns is not None
    assert lessons.episodes == 2
    few, many = (
        learned(lessons_config(taught, **{"recordings.epochs": n, "recordings.batch_size": 16}), lessons)
        for n in (1, 40)
    )
    assert many[0] < few[0] / 2
    assert many[1] < few[1] / 2
    assert many[0] < np.var(lessons.actions, axis=0).mean() / 2


def test_values_of_recordings_that_were_rewarded_otherwise_are_left_alone(taught: Path) -> None:
    assert load_lessons(lessons_config(taught, **{"task.reward.step": -0.2})).returns is None


def test_the_same_recordings_start_the_same_training(taught: Path, tmp_path: Path) -> None:
    config, told = lessons_config(taught, steps=512), []
    made = []
    for name in ("one", "other"):
        folder = TrainingFolder.create(tmp_path / name, config, "pipenav train")
        train(config, folder, report=told.append)
        made.append(weights(folder.last))
    assert made[0] == made[1]
    other = lessons_config(taught, steps=512, **{"recordings.epochs": 4})
    folder = TrainingFolder.create(tmp_path / "third", other, "pipenav train")
    train(other, folder)
    assert weights(folder.last) != made[0]
    shares = [progress.imitated for progress in told if not np.isnan(progress.imitated)]
    assert shares == [1 / 3, 2 / 3, 1.0] * 2
    kept = json.loads((tmp_path / "one" / "config.json").read_text())["recordings"]
    assert kept["folders"] == [str(taught)]


def test_a_resumed_training_does_not_start_again(taught: Path, tmp_path: Path) -> None:
    """The recordings may be gone then: what they taught is in the checkpoint."""
    copy = tmp_path / "taught"
    shutil.copytree(taught, copy)
    config = lessons_config(copy, steps=1024)
    folder = TrainingFolder.create(tmp_path / "training", config, "pipenav train")
    seen: list[TrainingProgress] = []
    train(config, folder, should_stop=lambda: len(seen) > 3, report=seen.append)
    shutil.rmtree(copy)
    after: list[TrainingProgress] = []
    summary = train(config, folder, resumed=True, report=after.append)
    assert summary.steps >= 1024
    assert all(np.isnan(progress.imitated) for progress in after)


REFUSED = {
    "another robot": ({"robot": "high-fidelity"}, "another robot"),
    "another observation": ({"task.observation": "history"}, "observation 'relative'"),
    "another control": ({"task.control": "torque"}, "control 'position'"),
    "other actions": ({"task.alpha": 0.1}, "scales"),
}


@pytest.mark.parametrize(("more", "said"), REFUSED.values(), ids=REFUSED)
def test_recordings_that_do_not_fit_are_refused_before_a_folder_is_made(
    more: dict[str, Any], said: str, taught: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = [word for key, value in more.items() for word in ("--set", f"{key}={value}")]
    out = tmp_path / "training"
    assert run("train", "--from-recordings", str(taught), *settings, "--out", str(out)) == 1
    error = capsys.readouterr().err.strip()
    assert said in error
    assert len(error.splitlines()) == 1
    assert not out.exists()


def damaged(taught: Path, folder: Path, change: Any) -> Path:
    """The recordings with every line changed."""
    folder.mkdir()
    for path in taught.glob("*.jsonl"):
        lines = [json.loads(line) for line in path.read_text().splitlines()]
        (folder / path.name).write_text("\n".join(json.dumps(change(line)) for line in lines) + "\n")
    return folder


def without(*keys: str) -> Any:
    return lambda line: {key: value for key, value in line.items() if key not in keys}


DAMAGED = {
    "an earlier version": (without("robot_file", "task"), "earlier versions"),
    "no actions": (without("action"), "without a whole action"),
    "numbers that are none": (lambda line: line | ({"reward": None} if "reward" in line else {}), "whole reward"),
    "nothing that succeeded": (lambda line: line | ({"end": "timeout"} if "end" in line else {}), "no episode"),
    "a robot that is none": (lambda line: line | ({"robot_file": 3} if "task" in line else {}), "first line"),
}


@pytest.mark.parametrize(("change", "said"), DAMAGED.values(), ids=DAMAGED)
def test_damaged_recordings_are_refused(change: Any, said: str, taught: Path, tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match=said):
        load_lessons(lessons_config(damaged(taught, tmp_path / "damaged", change)))


def test_only_what_succeeded_is_learned_unless_failures_are_asked_for(taught: Path, tmp_path: Path) -> None:
    failed = damaged(taught, tmp_path / "failed", lambda line: line | ({"end": "limit"} if "end" in line else {}))
    assert load_lessons(lessons_config(taught, failed)).episodes == 2
    assert load_lessons(lessons_config(taught, failed, **{"recordings.failed": True})).episodes == 4
