"""Traction of a robot on wheels, as its motors allow it: pull at standstill, speed without load, and between them."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats
from pipenav.robots.robot import RobotSpec


def mass(robot: RobotSpec) -> float:
    """Mass of the links and wheels [kg]."""
    return sum(link.mass + (link.wheel.mass if link.wheel else 0.0) for link in robot.links)


def pull(robot: RobotSpec) -> float:
    """Force of all wheels together at standstill, if they grip [N]."""
    return sum(robot.actuators[wheel.actuator].effort_limit / wheel.radius for wheel in robot.wheels)


def top_speed(robot: RobotSpec) -> float:
    """Speed at which the slowest wheel rolls without load [m/s]."""
    return min(robot.actuators[wheel.actuator].speed_limit * wheel.radius for wheel in robot.wheels)


def speed_under(robot: RobotSpec, load: Floats) -> Floats:
    """Speed of the wheels against a force along the pipe, in the shape of `load` [m/s]; negative beyond their pull.

    A motor's effort falls in a straight line from standstill to its no-load speed.

    Args:
        robot: a robot on wheels.
        load: force that all wheels work against together [N].
    """
    return np.asarray(top_speed(robot) * (1.0 - np.asarray(load) / pull(robot)))
