"""Plans of sessions, from the names by which a person gives them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pipenav.backends.simulators import DEFAULT_SIMULATOR, SimulatorSettings
from pipenav.disturbances.disturbance import UNDISTURBED, Disturbance, load_disturbance
from pipenav.driving.records import RECORDS
from pipenav.errors import PipenavError
from pipenav.pipes.pipe import Pipe
from pipenav.policies.controller import AnyController
from pipenav.policies.header import robot_difference
from pipenav.policies.named import open_controller
from pipenav.policies.policy import load_policy, policy_names, resolve_policy
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.tasks.registry import TaskConfig, default_config, task_of
from pipenav.tasks.rolling.batch import check_in_space
from pipenav.units import m_to_mm, rad_to_deg

DEFAULT_ROBOT = "pirate"
"""The robot that is driven where none is named: the thesis's robot is driven by hand as a whole."""

STARTS = ("start_gap", "start_spread", "start_press", "start_bend", "target_depth", "target_lateral")
"""Settings of a task that say how an episode starts: the same for every driver, so that they can be compared."""


SLOWER = 10
"""Factor on the time limits of an episode: hands are slower than policies."""


@dataclass(frozen=True)
class DrivePlan:
    """Plan of a session: the robot, the pipes, and who drives.

    Attributes:
        robot: the robot.
        task: settings of the task; its time limits are lengthened by `SLOWER`.
        pipes: the pipes.
        names: names of the pipes, in words that `--pipes` takes.
        episodes: number of episodes in each.
        seed: seed of starts and targets.
        controller: the policy or baseline that drives while the operator does not; None without one.
        simulator: the simulator.
        disturbance: disturbances.
        folder: folder for the telemetry of every episode; None for no telemetry.
    """

    robot: RobotSpec
    task: TaskConfig
    pipes: Sequence[Pipe]
    names: Sequence[str]
    episodes: int
    seed: int
    controller: AnyController | None
    simulator: SimulatorSettings = DEFAULT_SIMULATOR
    disturbance: Disturbance = UNDISTURBED
    folder: Path | None = None

    def on(self, backend: str, options: Mapping[str, Any], disturb: str | None, folder: Path | None) -> DrivePlan:
        """The same session on a simulator, under disturbances by their name or file, with telemetry in a folder.

        Raises:
            UnknownName, ConfigError, FileProblem: there are no such disturbances.
            PipenavError: a pipe leaves the plane, and the robot, the simulator or the disturbances do not.
        """
        disturbance = UNDISTURBED if disturb is None else load_disturbance(disturb)
        if self.in_space:
            check_in_space(self.robot, backend, None if disturb is None else "--disturb")
        simulator = SimulatorSettings(backend, options)
        return replace(self, simulator=simulator, disturbance=disturbance, folder=folder)

    @property
    def total(self) -> int:
        """Number of episodes in all."""
        return len(self.pipes) * self.episodes

    @property
    def in_space(self) -> bool:
        """Whether a pipe leaves the plane; robots then move in space in all of them."""
        return any(pipe.in_space for pipe in self.pipes)

    @property
    def lengthened(self) -> TaskConfig:
        """The task with time for hands."""
        longer = {"max_steps": min(self.task.max_steps * SLOWER, 100_000)}
        if hasattr(self.task, "patience"):
            longer["patience"] = min(self.task.patience * SLOWER, 100_000)
        return self.task.model_copy(update=longer)


def make_plan(policy: str | None, robot_name: str | None, given: Sequence[str], episodes: int, seed: int) -> DrivePlan:
    """The plan of a session.

    Args:
        policy: name of a policy or baseline; None where a person drives alone.
        robot_name: the robot; None for the policy's, or `DEFAULT_ROBOT`.
        given: pipes, by the words that `--pipes` takes.
        episodes: number of episodes in each pipe.
        seed: seed of starts and targets.

    Raises:
        UnknownName, ConfigError: no such policy, robot or pipe.
        PipenavError: they do not fit together.
    """
    controller: AnyController | None = None
    if policy is None:
        robot = load_robot(robot_name or DEFAULT_ROBOT)
        task = _task(robot)
    else:
        controller = open_controller(policy, robot_name, seed)
        robot, task = controller.robot, controller.task
        own = _task(robot)
        if own.kind == task.kind:
            same = {key: getattr(own, key) for key in STARTS if hasattr(own, key)}
            task = task.model_copy(update=same)
    task_of(task).check_robot(robot)
    pipes = task_of(task).parse_pipes(given)
    return DrivePlan(robot, task, pipes, [name_of(pipe) for pipe in pipes], episodes, seed, controller)


def name_of(pipe: Pipe) -> str:
    """The pipe in words that `--pipes` takes, where it is a corner; else its label."""
    corner = pipe.corner
    if corner is None or corner.branches:
        return pipe.label
    bend = f",bend_radius={m_to_mm(corner.bend_radius):g}" if corner.bend_radius else ""
    turn = "" if corner.turn == "left" else ",turn=right"
    return f"d={m_to_mm(corner.diameter):g},angle={rad_to_deg(corner.angle):g}{bend}{turn}"


def free_drive_folder(given: Path | None) -> Path:
    """Path of a new session's folder, which is yet to be made: the given one, or the next free one under `runs/`.

    Raises:
        PipenavError: the given folder holds a session already.
    """
    if given is not None:
        if (given / RECORDS).exists() or any(given.glob("episode-*.jsonl")):
            raise PipenavError(f"{given} holds a session already: give another folder with --out.")
        return given
    number = 1
    while (folder := Path("runs") / f"drive-{number}").exists():
        number += 1
    return folder


def _task(robot: RobotSpec) -> TaskConfig:
    """The task of a robot: that of a shipped policy for it under position control, so that all drivers start alike."""
    for name in policy_names():
        header = load_policy(resolve_policy(name)).header
        if not robot_difference(header.robot, robot) and header.task.control == "position":
            return header.task
    default = default_config(robot)
    return default.model_copy(update={"control": "position"})
