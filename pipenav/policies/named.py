"""Controllers by name: a trained policy, or a baseline to compare it with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError, UnknownName
from pipenav.policies.baselines.centreline import CentrelineController
from pipenav.policies.baselines.sequence import SequenceController
from pipenav.policies.controller import AnyController
from pipenav.policies.policy import Policy, load_policy, resolve_policy
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.tasks.registry import TaskConfig, default_config

BASELINE = "baseline:"

BASELINES = {"random": "basic", "centreline": "basic", "sequence": "pirate", "sequence-line": "pirate"}
"""Names of the baselines, and the robot that each of them controls by default."""


class PolicyController:
    """A trained policy as a controller."""

    def __init__(self, policy: Policy) -> None:
        self.policy = policy
        self.robot, self.task = policy.header.robot, policy.header.task

    def act(self, observation: Floats) -> Floats:
        return self.policy.act(observation).astype(float)


class RandomController:
    """Uniform random actions: the lower end of every comparison."""

    def __init__(self, robot: RobotSpec, seed: int | Sequence[int], task: TaskConfig | None = None) -> None:
        self.robot, self.task = robot, task or default_config(robot)
        self._rng = np.random.default_rng(seed)

    def seeded(self, seed: int | Sequence[int]) -> RandomController:
        """The same controller with another seed."""
        return RandomController(self.robot, seed, self.task)

    def act(self, observation: Floats) -> Floats:
        return self._rng.uniform(-1.0, 1.0, (len(observation), len(self.robot.driven_actuators)))


def open_controller(text: str, robot_name: str | None = None, seed: int = 0) -> AnyController:
    """Open a controller by its name.

    Args:
        text: `baseline:` and one of `BASELINES`, a shipped policy's name, or a policy file.
        robot_name: robot of a baseline, by default the one in `BASELINES`; a policy brings its own, no other.
        seed: seed of `baseline:random`.

    Raises:
        UnknownName: no such baseline, policy or robot.
        PolicyFileError: the policy file cannot be used.
        PipenavError: the baseline cannot control the robot, or the policy was made for another.
    """
    baselines = [BASELINE + known for known in BASELINES]
    if not text.startswith(BASELINE):
        if f"{text}:".lower().startswith(BASELINE):
            raise UnknownName("baseline", text, baselines)
        policy = load_policy(resolve_policy(text))
        if robot_name is not None and load_robot(robot_name).name != policy.header.robot.name:
            raise PipenavError(
                f"policy {text} was made for robot {policy.header.robot.name!r} and brings it, given {robot_name!r}: "
                "leave out the robot, or name another policy."
            )
        return PolicyController(policy)
    name = text.removeprefix(BASELINE)
    if name not in BASELINES:
        raise UnknownName("baseline", text, baselines)
    robot = load_robot(robot_name or BASELINES[name])
    if name == "random":
        return RandomController(robot, seed)
    if name == "centreline":
        return CentrelineController(robot)
    return SequenceController(robot, load_policy(resolve_policy("arm")) if name == "sequence" else None)
