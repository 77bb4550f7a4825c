"""Where an episode starts, where its target lies, and how it ends."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.robots import frames
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.config import ReachConfig
from pipenav.units import m_to_mm


class ReachEpisodes(NamedTuple):
    """k episodes about to start.

    Attributes:
        pipes: the pipe of each.
        q: start joint positions in the robot's own frame, (k, joints).
        base: x of the robot's frame in the pipe's frame, (k,) [m].
        turn_sign: +1 for a left turn, -1 for a right one, (k,).
        target: target in the canonical frame, (k, 2) [m].
        edge: the inner wall's edge, of a bend the point where it starts, in the canonical frame, (k, 2) [m].
    """

    pipes: tuple[PipeCorner, ...]
    q: Floats
    base: Floats
    turn_sign: Floats
    target: Floats
    edge: Floats

    def part(self, which: slice) -> ReachEpisodes:
        """Some of the episodes."""
        pipes, *columns = self
        return ReachEpisodes(pipes[which], *(column[which] for column in columns))


def sample(
    robot: RobotSpec, config: ReachConfig, pipes: Sequence[PipeCorner], rng: np.random.Generator
) -> ReachEpisodes:
    """Random start poses and targets, one episode for each of the given pipes."""
    k = len(pipes)
    bend = np.where(robot.hinges, rng.uniform(-config.start_bend, config.start_bend, (k, len(robot.joints))), 0.0)
    gap = rng.uniform(*config.start_gap, k)
    depth = rng.uniform(*config.target_depth, k)
    lateral = rng.uniform(-config.target_lateral, config.target_lateral, k)
    turn_sign, turn, radius, inner = np.array([_corner(pipe) for pipe in pipes]).reshape(k, 4).T
    q = bend * _room(robot, bend, radius)[:, None]
    base = -inner - gap - robot.length
    along, left = _second_leg(turn)
    along_target = (inner + depth)[:, None] * along + (2 * radius * lateral)[:, None] * left
    edge = np.stack([-inner, radius], axis=1)
    return ReachEpisodes(
        tuple(pipes), q, base, turn_sign, frames.pipe_to_robot(along_target, base), frames.pipe_to_robot(edge, base)
    )


@lru_cache(maxsize=4096)  # every pipe of the largest shipped training set
def _corner(pipe: PipeCorner) -> tuple[float, ...]:
    """Side, absolute change of heading, radius and inner edge, as `PipeCorner` says."""
    return pipe.turn_sign, abs(pipe.heading_change), pipe.radius, pipe.inner_edge


def check_robot(robot: RobotSpec) -> None:
    """Refuse a robot that cannot do the task.

    Raises:
        PipenavError: it stands free.
    """
    if robot.free:
        raise PipenavError(
            f"robot {robot.name!r} stands free, and this task moves an arm on a mount: choose --preset pirate."
        )


START_CLEARANCE = 0.002
"""Least room between the robot and the wall at the start [m]."""


def check_fits(robot: RobotSpec, pipes: Sequence[Pipe]) -> None:
    """Refuse pipes in which the robot cannot lie straight.

    Raises:
        PipenavError: the first such pipe.
    """
    need = robot.width + 2 * START_CLEARANCE
    for pipe in pipes:
        if pipe.diameter < need:
            raise PipenavError(
                f"pipe {pipe.label} is too narrow for robot {robot.name!r}, which is {m_to_mm(robot.width):g} mm wide "
                f"and needs {m_to_mm(need):g} mm at rest: choose a wider pipe."
            )


def _room(robot: RobotSpec, bend: Floats, radius: Floats) -> Floats:
    """Factor in [0, 1] on start angles that keeps the robot off the walls, (k,).

    Every hinge swings the rest of the robot sideways by at most its angle times the length that follows it.
    """
    following = np.cumsum(robot.lengths[::-1])[::-1]
    sideways = np.abs(bend) @ following
    free = radius - robot.width / 2 - START_CLEARANCE
    return np.asarray(np.clip(free / np.maximum(sideways, 1e-9), 0.0, 1.0))


def _second_leg(turn: Floats) -> tuple[Floats, Floats]:
    """Directions along the second leg and to its left, as a left turn by `turn` (k,), (k, 2) each."""
    along = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return along, np.stack([-along[:, 1], along[:, 0]], axis=1)


INSIDE_WALL = np.deg2rad(165.0)
"""A heading from the inner edge that lies in every pipe's wall: that fills pi - angle to pi, with angle >= 30 deg."""


def distance_to_target(tip: Floats, target: Floats, edge: Floats) -> Floats:
    """Length of the way from the tip to the target: straight, or around the inner edge where that is in between.

    Seen from the edge, the free space is a wedge; the wall is in between when tip and target lie more than a half turn
    apart in it. The way changes by no more than the tip moves.

    Args:
        tip: (n, 2) [m], canonical frame.
        target: (n, 2) [m].
        edge: the inner edge, (n, 2) [m].
    """
    x, y = np.array([(target - edge).T, (tip - edge).T, (target - tip).T]).swapaxes(0, 1)  # (3, n) each
    goal_distance, tip_distance, straight = np.hypot(x, y)
    goal_turn, tip_turn = np.mod(np.arctan2(y[:2], x[:2]) - INSIDE_WALL, 2 * np.pi)  # counter-clockwise
    return np.asarray(np.where(goal_turn - tip_turn > np.pi, tip_distance + goal_distance, straight))


def at_limit(robot: RobotSpec, config: ReachConfig, q: Floats) -> Flags:
    """Whether any joint has hit its limit, (n,)."""
    margin = config.limit_margin * (robot.upper - robot.lower)
    return np.asarray(((q <= robot.lower + margin) | (q >= robot.upper - margin)).any(axis=1))
