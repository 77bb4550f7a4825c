"""Inputs and outputs of a policy that is used elsewhere: every value with its name, its unit and its scale."""

from __future__ import annotations

import json
from typing import Any, NamedTuple

import numpy as np

from pipenav.policies.header import PolicyHeader
from pipenav.policies.policy import Policy
from pipenav.robots.robot import RobotSpec

OBSERVATION, ACTION, PHYSICAL_ACTION = "observation", "action", "physical_action"
"""Names of the model's input and of its two outputs."""

METADATA_KEY = "pipenav"
"""Key of the model's metadata under which the text of `metadata` stands."""

FRAME = (
    "canonical frame: x along the first leg, origin at the first link's rear end at rest, every turn a left turn; for "
    "a right turn, hinge positions, hinge speeds and hinge actions change sign and beams come in reverse order"
)
"""Frame of observations and actions, as docs/formats/policy-file.md defines it."""


class Value(NamedTuple):
    """A value of an observation or an action.

    Attributes:
        name: name, as `q.hinge1` or `ranges.3`.
        unit: unit.
        scale: size of a scaled 1 in that unit.
    """

    name: str
    unit: str
    scale: float


def observed_values(policy: Policy) -> list[Value]:
    """Values of an observation, in order."""
    header, values = policy.header, list[Value]()
    scales = iter(policy.observation_scale.tolist())
    for part in header.observation:
        names, units = _names(header.robot, part.name, part.size), _units(header.robot, part.unit, part.size)
        values += [
            Value(f"{part.name}.{name}", unit, scale)
            for name, unit, scale in zip(names, units, scales, strict=False)  # the scales go on for the next part
        ]
    return values


def acted_values(header: PolicyHeader) -> list[Value]:
    """Values of an action, in order."""
    return [Value(part.joint, part.unit, part.scale) for part in header.action]


def metadata(policy: Policy) -> str:
    """Text, JSON, that says what the model takes and gives; the same for the same policy."""
    header = policy.header
    told: dict[str, Any] = {
        "format": "pipenav-portable-policy",
        "version": 1,
        "robot": header.robot.name,
        "task": header.task.kind,
        "control": header.task.control,
        "rate_hz": header.rate_hz,
        "frame": FRAME,
        "observation": [value._asdict() for value in observed_values(policy)],
        "action": [value._asdict() for value in acted_values(header)],
        "policy": header.model_dump(mode="json"),
    }
    return json.dumps(told, allow_nan=False, ensure_ascii=True)


def action_scale(header: PolicyHeader) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Physical size of an action of 1, (action_size,) float32."""
    return np.array([part.scale for part in header.action], np.float32)


def _names(robot: RobotSpec, part: str, size: int) -> list[str]:
    """Names of the values of a part: of joints, wheels or both where there are as many, numbers elsewhere."""
    joints, wheels = [joint.name for joint in robot.joints], [wheel.name for wheel in robot.wheels]
    named = {
        "q": joints,
        "qd": joints,
        "wheel_speeds": wheels,
        "loads": [*joints, *wheels],
        "action": [*joints, *wheels],
        "p_ee": ["x", "y"],
        "p_goal": ["x", "y"],
        "goal_in_tip": ["forwards", "left"],
        "goal_near": ["forwards", "left"],
        "down": ["forwards", "left"],
        "turns_beside": ["before", "after"],
    }.get(part.removesuffix("_before"), [])
    return named if len(named) == size else [str(number) for number in range(size)]


def _units(robot: RobotSpec, unit: str, size: int) -> list[str]:
    """Unit of each value of a part; a part of joints has that of hinges first, then that of slides."""
    of_hinges, _, of_slides = unit.partition(", ")
    if not of_slides or size != len(robot.joints):
        return [of_hinges] * size
    return [of_hinges if joint.type == "hinge" else of_slides for joint in robot.joints]
