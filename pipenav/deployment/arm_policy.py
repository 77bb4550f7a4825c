"""The policy for an arm, and the reasons for which one cannot drive it."""

from __future__ import annotations

from pipenav.deployment.stages import USE
from pipenav.errors import PipenavError
from pipenav.locating.locator import require_arm
from pipenav.policies.header import RATE_HZ
from pipenav.policies.policy import Policy, load_policy, policy_names, resolve_policy
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.tasks.registry import require_reach

DEFAULT_ROBOT = "real-setup"
"""The physical arm."""


def policy_for(name: str | None, robot: str | None) -> Policy:
    """The policy for an arm.

    Args:
        name: a policy file or a shipped policy's name; None for the shipped one that drives the robot.
        robot: the robot's name; None for the robot of the named policy, `DEFAULT_ROBOT` where no policy is named.

    Raises:
        UnknownName, PolicyFileError: there is no such policy or robot, or the file cannot be used.
        PipenavError: no shipped policy drives the robot; the policy is for another one, commands torques, or was
            trained at another rate.
    """
    if name is None:
        return _shipped_policy(load_robot(robot or DEFAULT_ROBOT))
    policy = load_policy(resolve_policy(name))
    if robot is not None:
        policy.require(load_robot(robot))
    _require_drivable(policy)
    return policy


def _shipped_policy(robot: RobotSpec) -> Policy:
    require_arm(robot)
    for name in policy_names():
        policy = load_policy(resolve_policy(name))
        if policy.header.robot == robot and policy.header.task.control == "position":
            return policy
    raise PipenavError(
        f"no shipped policy drives robot {robot.name!r}: train one (pipenav presets lists recipes) and give --policy."
    )


def _require_drivable(policy: Policy) -> None:
    require_arm(policy.header.robot)
    header = policy.header
    require_reach(header.task, USE)
    if header.task.control != "position":
        raise PipenavError(
            f"policy {policy.path} commands torques, and the arm's servos take positions: "
            "train one with --control position."
        )
    if abs(header.rate_hz - RATE_HZ) > 1e-9:
        raise PipenavError(
            f"policy {policy.path} was trained at {header.rate_hz:g} Hz, the arm is driven at {RATE_HZ:g} Hz: "
            "train one with this version."
        )
