"""Motions that `baseline:centreline` plans: hinges that follow the leader along a line, then improved pose by pose."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.guide_line import guide_line, meet_line
from pipenav.policies.baselines.wall_distance import wall_distance
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec

WAYPOINTS = 40
"""Poses along the slide's whole travel, about a centimetre apart."""

WIDE_ENOUGH = 0.006
"""Distance from the walls that leaves room for the servos' lag [m]; a larger one counts no more."""

ROUNDS, FIRST_MOVE, SHRINK = 40, 0.08, 0.96
"""Rounds of the improvement, the first change of an angle that it tries [rad], and the factor on it per round."""

BEND_COST = 0.02
"""Cost of a bend of 1 rad between neighbouring waypoints, as wall distance [m]: keeps the motion smooth."""

TARGET_COST = 0.5
"""Cost of a millimetre of the tip's distance to the target, in millimetres of wall distance."""


class PlannedMotion(NamedTuple):
    """A motion through one pipe.

    Attributes:
        q: waypoints in the robot's frame, the slide's position rising, (k, joints) [m, rad].
        score: smallest wall distance of the motion [m], less a metre or more where it ends short of the target.
    """

    q: Floats
    score: float


def follow_line(
    robot: RobotSpec, pipe: PipeCorner, base: float, target: Floats, widths: tuple[float, ...]
) -> PlannedMotion:
    """The motion of a chain whose hinges follow the leader along one line, up to where the tip reaches the target.

    Args:
        robot: a slide, then hinges.
        pipe: a left turn.
        base: origin of the robot's frame, x in the pipe's frame [m].
        target: target in the pipe's frame, (2,) [m].
        widths: distances of the line from the inner wall, as in `guide_line`.
    """
    line, end = guide_line(pipe, target, widths)
    top = robot.upper - 0.01 * (robot.upper - robot.lower)  # off the limits, which end an episode
    q = np.zeros((WAYPOINTS, len(robot.links)))
    q[:, 0] = np.linspace(0.0, top[0], WAYPOINTS)
    hinge = np.stack([q[:, 0] + base + robot.links[0].length, np.zeros(WAYPOINTS)], axis=1)  # (k, 2)
    nearest = np.hypot(*np.moveaxis(line - hinge[:, None], -1, 0)).argmin(axis=1)
    positions = np.where(hinge[:, 0] < line[1, 0], 0.0, nearest)
    heading = np.zeros(WAYPOINTS)
    for j, link in enumerate(robot.links[1:], 1):
        far_end, positions = meet_line(line, hinge, positions, link.length)
        direction = np.arctan2(*(far_end - hinge).T[::-1])
        q[:, j] = np.mod(direction - heading + math.pi, 2 * math.pi) - math.pi
        hinge, heading = far_end, direction
    arrived = np.flatnonzero(positions >= end)
    if len(arrived):
        last = max(int(arrived[0]), 1)
        share = (end - positions[last - 1]) / (positions[last] - positions[last - 1])
        q[last] = q[last - 1] + share * (q[last] - q[last - 1])
        q = q[: last + 1]
    missing = 0.0 if len(arrived) else 1.0 + end - float(positions[-1])
    room = float(wall_distance(robot, pipe, q, base).min())
    too_bent = float((np.abs(q[:, 1:]) > np.minimum(top, -robot.lower)[1:]).any())
    return PlannedMotion(q, room - missing - too_bent)


def improve(robot: RobotSpec, pipe: PipeCorner, base: float, target: Floats, q: Floats) -> Floats:
    """Larger wall distances where they are below `WIDE_ENOUGH`, by small changes of one hinge at a time: (k, joints).

    Every other waypoint moves in a round, so that each can count on its neighbours. The first one, where the robot
    starts, stays; the last one also keeps the tip near the target. Arguments as for `follow_line`; `q` are waypoints.
    """
    hinges = np.eye(q.shape[1])[1:]
    moves = np.concatenate([np.zeros((1, q.shape[1])), hinges, -hinges])  # (m, joints), the first one is no move
    size = FIRST_MOVE
    for number in range(ROUNDS):
        moving = slice(1 + number % 2, None, 2)
        before, after = q[:-1], np.concatenate([q[2:], q[-1:]])
        middle = ((before + after) / 2)[number % 2 :: 2]  # between the neighbours of each waypoint that moves
        tried = q[moving, None] + size * moves  # (k / 2, m, joints)
        bend = ((tried - middle[:, None])[..., 1:] ** 2).sum(axis=-1)
        cost = BEND_COST * bend - np.minimum(wall_distance(robot, pipe, tried, base), WIDE_ENOUGH)
        if (len(q) - 2 - number) % 2 == 0:  # the last waypoint is among those that move
            tip = frames.robot_to_pipe(kinematics.forward(robot, tried[-1]).tip, base)
            cost[-1] += TARGET_COST * np.linalg.norm(tip - target, axis=-1)
        q = q.copy()
        q[moving] += size * moves[cost.argmin(axis=1)]
        size *= SHRINK
    return q
