"""Header of a policy file, the content of its `pipenav.json`: the robot and the task that a policy was made for."""

from __future__ import annotations

import contextlib
import platform
import re
from collections.abc import Sequence
from importlib import metadata
from typing import Literal

from pydantic import Field

import pipenav
from pipenav.arrays import Table
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.registry import TaskConfig, task_of

FORMAT_VERSION = 1
RATE_HZ = 1 / CONTROL_PERIOD
PROSE = re.compile(r"(^|\.)(description|(\w+_)?source)$")
"""Keys of a robot description that explain numbers and change nothing."""

RECORDED_PACKAGES = ("mujoco", "numpy", "pybullet", "safetensors", "stable-baselines3", "torch")
"""Packages whose versions the header records."""


class ObservationPart(Table):
    """A named part of the observation vector."""

    name: str
    unit: str = Field(description="unit of the values before scaling; for q and qd, units of hinges, then of slides")
    size: int = Field(ge=1)


class ActionPart(Table):
    """Meaning of one action value; a full action is 1."""

    joint: str = Field(description="name of the joint, or of a wheel")
    unit: str
    scale: float = Field(
        gt=0, description="size of a full action: effort at standstill (torque), set-point step or speed (position)"
    )


class PolicyHeader(Table):
    """Facts about a policy other than its weights; the content of `pipenav.json`."""

    format: Literal["pipenav-policy"] = "pipenav-policy"
    version: Literal[1] = 1
    robot: RobotSpec
    task: TaskConfig
    observation: tuple[ObservationPart, ...]
    action: tuple[ActionPart, ...]
    rate_hz: float = Field(gt=0, description="control rate that the policy was trained at [Hz]")
    train_pipes: tuple[str, ...] = Field(description="pipe sets or pipes that it was trained in")
    training: dict[str, str | int | float | bool] = Field(description="summary: steps, seconds, seed, preset, success")
    versions: dict[str, str] = Field(description="versions of pipenav, Python and the libraries that took part")


def header_for(
    robot: RobotSpec, task: TaskConfig, train_pipes: Sequence[str], training: dict[str, str | int | float | bool]
) -> PolicyHeader:
    """Header of a policy that this installation trained for a robot and a task."""
    return PolicyHeader(
        robot=robot,
        task=task,
        observation=observation_parts(robot, task),
        action=action_parts(robot, task),
        rate_hz=RATE_HZ,
        train_pipes=tuple(train_pipes),
        training=training,
        versions=installed_versions(),
    )


def observation_parts(robot: RobotSpec, task: TaskConfig) -> tuple[ObservationPart, ...]:
    """Parts of the observation, in order."""
    parts = task_of(task).layout(robot)
    return tuple(ObservationPart(name=part.name, unit=part.unit, size=len(part.scale)) for part in parts)


def action_parts(robot: RobotSpec, task: TaskConfig) -> tuple[ActionPart, ...]:
    """Meaning of each action value: the joints in order, then the wheels."""
    torque = task.control == "torque"
    units = {"slide": "N", "hinge": "N m"} if torque else {"slide": "m", "hinge": "rad"}
    named = [(joint.name, units[joint.type]) for joint in robot.joints]
    named += [(wheel.name, "N m" if torque else "rad/s") for wheel in robot.wheels]
    scales = zip(named, task_of(task).action_scale(robot), strict=True)
    return tuple(ActionPart(joint=name, unit=unit, scale=float(scale)) for (name, unit), scale in scales)


def installed_versions() -> dict[str, str]:
    """Versions of pipenav, Python and the recorded packages that are installed; imports none of them."""
    versions = {"pipenav": pipenav.__version__, "python": platform.python_version()}
    for name in RECORDED_PACKAGES:
        with contextlib.suppress(metadata.PackageNotFoundError):
            versions[name] = metadata.version(name)
    return versions


def robot_difference(made: RobotSpec, given: RobotSpec) -> str:
    """First number or name that differs, as `links.1.length is 0.12, here 0.13`; empty where only prose differs."""
    one, other = _leaves(made.model_dump()), _leaves(given.model_dump())
    for key in [*one, *other]:
        if not PROSE.search(key) and one.get(key) != other.get(key):
            return f"{key} is {one.get(key, 'missing')}, here {other.get(key, 'missing')}"
    return ""


def _leaves(tree: object, prefix: str = "") -> dict[str, object]:
    """Values of nested dicts and lists by dotted keys."""
    if isinstance(tree, dict):
        items = list(tree.items())
    elif isinstance(tree, list | tuple):
        items = list(enumerate(tree))
    else:
        return {prefix: tree}
    return {k: v for key, value in items for k, v in _leaves(value, f"{prefix}.{key}" if prefix else str(key)).items()}
