"""Commands from actions in [-1, 1]: duties (eq 3.3) or position steps (eq 3.4, 3.5)."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.messages import Command
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.observation import joint_signs


def to_command(robot: RobotSpec, config: ReachConfig, action: Floats, q: Floats, turn_sign: Floats) -> Command:
    """Command for canonical actions.

    Args:
        robot: the robot.
        config: control mode and step size.
        action: canonical actions, (n, joints); clipped to [-1, 1].
        q: measured joint positions in the robot's own frame, (n, joints).
        turn_sign: +1 for a left turn, -1 for a right one, (n,).
    """
    own = np.clip(action, -1.0, 1.0) * joint_signs(robot, turn_sign)
    if config.control == "torque":
        return Command("torque", own)
    set_points = q + position_step(robot, config) * own
    return Command("position", np.clip(set_points, robot.lower, robot.upper))


def of_set_points(robot: RobotSpec, config: ReachConfig, set_points: Floats, q: Floats, turn_sign: Floats) -> Floats:
    """Canonical actions whose command comes nearest to set-points, (n, joints): `to_command` the other way round.

    Args:
        robot: the robot.
        config: step size, with position control.
        set_points: set-points in the robot's own frame, (n, joints) [rad or m].
        q: measured joint positions in that frame, (n, joints).
        turn_sign: +1 for a left turn, -1 for a right one, (n,).
    """
    own = (set_points - q) / position_step(robot, config)
    return np.clip(own * joint_signs(robot, turn_sign), -1.0, 1.0)


def full_action(robot: RobotSpec, config: ReachConfig) -> Floats:
    """Physical size of a full action: effort at standstill, or set-point step, (joints,) [N and N m, or m and rad]."""
    return robot.effort_limits if config.control == "torque" else position_step(robot, config)


def position_step(robot: RobotSpec, config: ReachConfig) -> Floats:
    """Set-point change of a full action, (joints,) [rad or m]."""
    return config.alpha * np.where(robot.hinges, 1.0, config.slide_unit)
