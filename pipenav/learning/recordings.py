"""Recordings of `pipenav drive` as lessons for a policy: what it would have seen, and what the operator did then."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from pipenav.arrays import Table
from pipenav.deployment.telemetry import Recording, read_telemetry
from pipenav.errors import PipenavError
from pipenav.learning.config import TrainConfig
from pipenav.policies.header import robot_difference
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.registry import TaskConfig, task_of

EPISODES = "episode-*.jsonl"
"""Names of the recordings in a drive folder."""

Array32 = NDArray[np.float32]


class Lessons(NamedTuple):
    """Control steps to learn from, n of them, episode after episode.

    Attributes:
        observations: scaled observations, (n, size).
        actions: canonical actions that answered them, (n, action_size).
        returns: discounted rewards from each step on to the end of its episode, (n,); None where the recordings were
            rewarded in another way than the training is.
        episodes: number of episodes.
    """

    observations: Array32
    actions: Array32
    returns: Array32 | None
    episodes: int


class _Driven(Table):
    """Part of a recording's header that says what was driven."""

    robot_file: RobotSpec
    task: TaskConfig


def load_lessons(config: TrainConfig) -> Lessons:
    """The lessons in the folders that a training's configuration names: every control step of episodes that succeeded.

    Files come in the order of folders and of their names, so that the same folders give the same lessons.

    Raises:
        FileProblem, PipenavError: a folder cannot be read, holds no recordings that can be learned from, or was
            recorded with another robot, task, observation or control.
    """
    seen, done, returns = [], [], []
    alike = True
    for folder in config.recordings.folders:
        for path in _files(Path(folder)):
            recording = read_telemetry(path)
            task = _checked(path, recording, config)
            if not recording.ticks or not (config.recordings.failed or _succeeded(recording)):
                continue
            alike = alike and task.reward == config.task.reward
            seen.append(_column(path, recording, "observation"))
            done.append(_column(path, recording, "action"))
            rewards = _column(path, recording, "reward")
            returns.append(_discounted(rewards, config.learner.gamma))
    if not seen:
        folders = ", ".join(config.recordings.folders)
        raise PipenavError(
            f"no episode in {folders} succeeded: record some that do, or learn from failed ones as well with --set "
            "recordings.failed=true."
        )
    observations, actions = np.concatenate(seen), np.concatenate(done)
    sizes = len(task_of(config.task).observation_scale(load_robot(config.robot))), actions.shape[1]
    if observations.shape[1] != sizes[0]:
        raise PipenavError(
            f"the recordings hold {observations.shape[1]} numbers a step and the policy observes {sizes[0]}."
        )
    return Lessons(observations, actions, np.concatenate(returns) if alike else None, len(seen))


def _files(folder: Path) -> list[Path]:
    files = sorted(folder.glob(EPISODES)) if folder.is_dir() else []
    if not files:
        raise PipenavError(
            f"{folder} holds no recorded episodes: give a folder that pipenav drive wrote, without --no-record, in a "
            "simulator."
        )
    return files


def _checked(path: Path, recording: Recording, config: TrainConfig) -> Any:
    """Settings of the task that a recording was driven under, if a training can learn from it.

    Raises:
        PipenavError: it cannot.
    """
    header = recording.header
    if "robot_file" not in header or "task" not in header:
        raise PipenavError(
            f"{path} does not hold what a policy would have seen, as recordings in space and of earlier versions: "
            "drive in pipes that lie in a plane."
        )
    try:
        given = json.dumps({key: header[key] for key in ("robot_file", "task")})
        driven = _Driven.model_validate_json(given)
    except ValidationError as error:
        raise PipenavError(f"{path} is damaged in its first line: drive it again.") from error
    if difference := robot_difference(driven.robot_file, load_robot(config.robot)):
        raise PipenavError(
            f"{path} was recorded with another robot than {config.robot!r}: {difference}; give recordings of this one."
        )
    for name in ("kind", "observation", "control"):
        theirs, ours = getattr(driven.task, name), getattr(config.task, name)
        if theirs != ours:
            words = "task" if name == "kind" else name
            raise PipenavError(
                f"{path} was recorded with {words} {theirs!r}, and this training has {ours!r}: record with a policy of "
                f"this training's {words} (pipenav drive --policy), or train with --set task.{name}={theirs}."
            )
    robot, (theirs_, ours_) = load_robot(config.robot), (task_of(driven.task), task_of(config.task))
    same = np.array_equal(theirs_.observation_scale(robot), ours_.observation_scale(robot))
    if not (same and np.array_equal(theirs_.action_scale(robot), ours_.action_scale(robot))):
        raise PipenavError(
            f"{path} was recorded with other scales of observation or action than this training's: give both the same "
            "settings of the task."
        )
    return driven.task


def _succeeded(recording: Recording) -> bool:
    return recording.end is not None and recording.end.get("end") == Outcome.REACHED.label


def _column(path: Path, recording: Recording, key: str) -> Array32:
    """A quantity of every control step, (steps, ...).

    Raises:
        PipenavError: it is missing somewhere, or no finite number.
    """
    try:
        values = np.array([tick[key] for tick in recording.ticks], np.float32)
        sound = np.isfinite(values).all() and values.dtype == np.float32
    except (KeyError, TypeError, ValueError, OverflowError):
        sound = False
    if not sound:
        raise PipenavError(f"{path} has control steps without a whole {key}: drive it again.")
    return values


def _discounted(rewards: Array32, gamma: float) -> Array32:
    """Sum of the discounted rewards from each step on, (steps,)."""
    returns, after = np.zeros(len(rewards), np.float32), 0.0
    for i in range(len(rewards) - 1, -1, -1):
        after = float(rewards[i]) + gamma * after
        returns[i] = after
    return returns
