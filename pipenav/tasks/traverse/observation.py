"""Observations and commands of the traverse task, mirrored for right turns, in fixed scales."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.messages import Command, Reading
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.layout import BEYOND_STOP, IMPACT, ObservationField
from pipenav.tasks.traverse.config import TraverseConfig

STRAIGHT = 0.1
"""Bend below which a wheel rolls more slowly than asked, and at a straight joint not at all [rad]: there it moves from
one wall to the other, and its forward direction turns round."""

SLIGHT = 0.05
"""Share of a wheel's full direction below which its speed says nothing about the action behind it."""


class RouteAhead(NamedTuple):
    """Knowledge that n robots have of their routes.

    Attributes:
        turn_sign: +1 where the fitting turns left, or its branch lies to the left of a way straight on, else -1, (n,).
        neighbours: turn signs of the fittings before and after, 0 where there is none, (n, 2).
        straight_on: 1 where the route goes straight on at the fitting, else 0, (n,); None: robots are not told.
    """

    turn_sign: Floats
    neighbours: Floats
    straight_on: Floats | None = None


def layout(robot: RobotSpec, config: TraverseConfig) -> list[ObservationField]:
    """Parts of the observation, in order."""
    actuators, lidar = len(robot.driven_actuators), robot.laser
    weighs = config.inclination_deg is not None
    return [
        ObservationField("q", "rad", np.maximum(-robot.lower, robot.upper), BEYOND_STOP),
        ObservationField("qd", "rad/s", np.array(robot.speed_limits), IMPACT),
        ObservationField("wheel_speeds", "rad/s", wheel_limits(robot), IMPACT),
        ObservationField("loads", "1", np.ones(actuators)),
        ObservationField("ranges", "m", np.full(lidar.beams, lidar.range_max)),
        ObservationField("action_before", "1", np.ones(actuators)),
        ObservationField("turns_beside", "1", np.ones(2)),
        *([ObservationField("straight_on", "1", np.ones(1))] if config.exit_told else []),
        *([ObservationField("down", "1", np.ones(2))] if weighs else []),
    ]


def wheel_limits(robot: RobotSpec) -> Floats:
    """No-load speeds of the wheels, (wheels,) [rad/s]."""
    return np.array([robot.actuators[wheel.actuator].speed_limit for wheel in robot.wheels])


def action_scale(robot: RobotSpec, config: TraverseConfig) -> Floats:
    """Physical size of a full action: set-point changes of joints [rad], then wheel speeds [rad/s], (actuators,)."""
    return np.concatenate([np.full(len(robot.joints), config.alpha), wheel_limits(robot)])


def actuator_signs(robot: RobotSpec, turn_sign: Floats) -> Floats:
    """Factor on loads, commands and actions that turns them into the canonical frame or back, (n, actuators).

    The first columns also turn joint positions and speeds, the last ones wheel speeds.

    Args:
        robot: the robot.
        turn_sign: +1 for a left turn, -1 for a right one, (n,).
    """
    return np.where(turn_sign[:, None] > 0, 1.0, robot.mirror_actuators)


def mirror_action(robot: RobotSpec, action: Floats, change: Floats) -> Floats:
    """Canonical actions where the turn sign changes, (n, actuators): bends change sign, wheels roll forwards as before.

    Args:
        robot: the robot.
        action: canonical actions before the change, (n, actuators).
        change: -1 where the turn sign changes, else +1, (n,).
    """
    joints = len(robot.joints)
    return np.concatenate([action[:, :joints] * actuator_signs(robot, change)[:, :joints], action[:, joints:]], axis=1)


def accelerometer(robot: RobotSpec) -> int:
    """Index of the link with the accelerometer: the one that the roll joint divides, else the last one."""
    return len(robot.links) - 1 if robot.roll is None else [link.name for link in robot.links].index(robot.roll.link)


def observe(
    robot: RobotSpec,
    reading: Reading,
    action_before: Floats,
    route: RouteAhead,
    down: Floats | None = None,
) -> Floats:
    """Unscaled observation, (n, size).

    Args:
        robot: the robot.
        reading: readings of the sensors, in the robot's own frame.
        action_before: the last action in the canonical frame, zero at the first step, (n, actuators).
        route: what the robots know of their routes.
        down: direction of down by the accelerometer, as a share of the weight, forwards along its link and to its left,
            (n, 2); None in a level plane.

    Raises:
        TypeError: the backend measures no wheel speeds or no loads.
    """
    if reading.wheel_speeds is None or reading.loads is None:
        raise TypeError("the traverse task needs a backend that measures wheel speeds and loads")
    turn_sign = route.turn_sign
    signs, joints = actuator_signs(robot, turn_sign), len(robot.joints)
    ranges = np.where(turn_sign[:, None] > 0, reading.ranges, reading.ranges[:, ::-1])
    own = (reading.q * signs[:, :joints], reading.qd * signs[:, :joints], reading.wheel_speeds * signs[:, joints:])
    felt = [] if down is None else [down[:, :1], down[:, 1:] * turn_sign[:, None]]
    told = [route.neighbours * turn_sign[:, None]]
    if route.straight_on is not None:
        told.append(route.straight_on[:, None])
    return np.concatenate([*own, reading.loads * signs, ranges, action_before, *told, *felt], axis=1)


def to_command(
    robot: RobotSpec, config: TraverseConfig, action: Floats, q: Floats, set_points: Floats, turn_sign: Floats
) -> Command:
    """Command for canonical actions: set-points of bending joints change, wheels roll forwards.

    A bent joint presses its wheel against the wall on the outside of the bend, so the bend decides which way round is
    forwards; the wheel of a straight joint stands.

    Args:
        robot: the robot.
        config: size of a full action, and what set-point changes start from.
        action: canonical actions, (n, actuators); clipped to [-1, 1].
        q: measured joint positions in the robot's own frame, (n, joints).
        set_points: set-points of the command before, (n, joints).
        turn_sign: +1 for a left turn, -1 for a right one, (n,).
    """
    asked, joints = np.clip(action, -1.0, 1.0) * action_scale(robot, config), q.shape[1]
    bends = asked[:, :joints] * actuator_signs(robot, turn_sign)[:, :joints]
    bends += q if config.set_points == "measured" else set_points
    bends = np.clip(np.clip(bends, q - config.alpha, q + config.alpha), robot.lower, robot.upper)
    rolls = asked[:, joints:] * _forwards(robot, q)
    return Command("position", np.concatenate([bends, rolls], axis=1))


def of_command(
    robot: RobotSpec, config: TraverseConfig, told: Floats, q: Floats, start: Floats, signs: Floats
) -> Floats:
    """Canonical actions whose command comes nearest to what robots were told, (n, actuators): `to_command` backwards.

    The wheel of a straight joint rolls for no action: 0 stands for whatever it was told.

    Args:
        robot: the robot.
        config: size of a full action.
        told: set-points of joints, then speeds of wheels, in the robot's own frame, (n, actuators).
        q: measured joint positions in that frame, (n, joints).
        start: positions or set-points that set-point changes start from, (n, joints).
        signs: +1 for a left turn, -1 for a right one, (n,).
    """
    joints = q.shape[1]
    bends = (told[:, :joints] - start) * actuator_signs(robot, signs)[:, :joints]
    forwards = _forwards(robot, q)
    rolls = np.divide(told[:, joints:], forwards, out=np.zeros_like(forwards), where=np.abs(forwards) > SLIGHT)
    return np.clip(np.concatenate([bends, rolls], axis=1) / action_scale(robot, config), -1.0, 1.0)


def _forwards(robot: RobotSpec, q: Floats) -> Floats:
    """Direction in which each wheel rolls forwards, in [-1, 1], (n, wheels), by the bends of the joints, (n, joints).

    A bend to the right presses its wheel on the left wall, where turning to the left rolls forwards.
    """
    return np.asarray(-np.clip(q[:, robot.wheel_joints] / STRAIGHT, -1.0, 1.0))
