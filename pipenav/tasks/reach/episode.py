"""Episodes of the reach task: start poses, targets, the distance between them, and joint limits."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import chain
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.robots import bend_reach, frames
from pipenav.robots.bend_reach import Bends
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.config import ReachConfig
from pipenav.units import m_to_mm


class ReachEpisodes(NamedTuple):
    """k episodes about to start.

    Attributes:
        pipes: pipe of each episode, k of them.
        q: start joint positions in the robot's own frame, (k, joints).
        base: x of the robot's frame in the pipe's frame, (k,) [m].
        turn_sign: +1 for a left turn, -1 for a right one, (k,).
        target: target in the canonical frame, (k, 2) [m].
        edge: edge of the inner wall, or the point where its bend starts, in the canonical frame, (k, 2) [m].
    """

    pipes: tuple[PipeCorner, ...]
    q: Floats
    base: Floats
    turn_sign: Floats
    target: Floats
    edge: Floats

    def part(self, rows: slice) -> ReachEpisodes:
        """Episodes of some rows."""
        pipes, *columns = self
        return ReachEpisodes(pipes[rows], *(column[rows] for column in columns))


class _CornerNumbers(NamedTuple):
    """Numbers of one corner: its turn, its radii and its inner edge, as `PipeCorner` defines them."""

    turn_sign: float
    turn_angle: float
    radius: float
    inner_edge: float
    bend_radius: float


class _LegDirections(NamedTuple):
    """Unit vectors along a leg and to its left, (k, 2) each."""

    along: Floats
    left: Floats


def sample(
    robot: RobotSpec, config: ReachConfig, pipes: Sequence[PipeCorner], rng: np.random.Generator
) -> ReachEpisodes:
    """Random start poses and targets, one episode for each of the given pipes.

    A target lies at the drawn depth past the end of the inner wall's bend. In a swept bend too long for that it lies
    where the arm can reach (`bend_reach`): an arm passes such a bend in several steps, and this is one of them.
    """
    k = len(pipes)
    bend = np.where(robot.hinges, rng.uniform(-config.start_bend, config.start_bend, (k, len(robot.joints))), 0.0)
    gap = rng.uniform(*config.start_gap, k)
    depth = rng.uniform(*config.target_depth, k)
    lateral = rng.uniform(-config.target_lateral, config.target_lateral, k)
    numbers = chain.from_iterable(map(_corner, pipes))  # a list of tuples would take numpy ten times as long
    turn_sign, turn_angle, radius, inner, bend_radius = np.fromiter(numbers, float, 5 * k).reshape(k, 5).T
    q = bend * _bend_factor(robot, bend, radius)[:, None]
    base, target = _targets(robot, _Corners(turn_angle, radius, inner, bend_radius), _Drawn(gap, depth, lateral))
    edge = np.stack([-inner, radius], axis=1)
    return ReachEpisodes(
        tuple(pipes), q, base, turn_sign, frames.pipe_to_robot(target, base), frames.pipe_to_robot(edge, base)
    )


class _Corners(NamedTuple):
    """Numbers of k corners as in `_CornerNumbers`, (k,) each."""

    turn_angle: Floats
    radius: Floats
    inner_edge: Floats
    bend_radius: Floats


class _Drawn(NamedTuple):
    """Drawn numbers of k episodes: distance of the tip before the inner wall's bend, depth and side, (k,) each."""

    gap: Floats
    depth: Floats
    lateral: Floats


def _targets(robot: RobotSpec, corners: _Corners, drawn: _Drawn) -> tuple[Floats, Floats]:
    """Bases, (k,), and targets in the canonical frame of the pipe, (k, 2) [m]."""
    turn_angle, radius, inner, bend_radius = corners
    base = -inner - drawn.gap - robot.length
    leg = _second_leg(turn_angle)
    aside = 2 * radius * drawn.lateral
    target = (inner + drawn.depth)[:, None] * leg.along + aside[:, None] * leg.left
    if (bent := bend_radius > 0).any():
        bends, start = Bends(radius, bend_radius, turn_angle).part(bent), -inner[bent]
        reach = bend_reach.reach_along(robot, bends, base[bent] - start)
        short = reach < bends.end + drawn.depth[bent]
        inside = frames.robot_to_pipe(bends.points(reach, aside[bent]), start)
        target[bent] = np.where(short[:, None], inside, target[bent])
    return base, target


def spread_targets(robot: RobotSpec, config: ReachConfig, pipe: PipeCorner, gaps: int) -> tuple[Floats, Floats]:
    """Bases, (k,), and targets, (k, 2) [m], of episodes spread evenly over all that `sample` may draw in a pipe.

    Both in the canonical frame of the pipe. Gaps of the start are combined with the ends of the depths and of the
    sides, and the middles of the sides: targets at other depths and sides lie between these.

    Args:
        robot: the arm.
        config: the task.
        pipe: the pipe.
        gaps: number of gaps, their ends included.
    """
    side = config.target_lateral
    grid = np.meshgrid(np.linspace(*config.start_gap, gaps), config.target_depth, (-side, 0.0, side), indexing="ij")
    every = np.stack(grid).reshape(3, -1)
    numbers = np.repeat(np.array(_corner(pipe)[1:])[:, None], every.shape[1], axis=1)
    return _targets(robot, _Corners(*numbers), _Drawn(*every))


@lru_cache(maxsize=4096)  # every pipe of the largest shipped training set
def _corner(pipe: PipeCorner) -> _CornerNumbers:
    return _CornerNumbers(pipe.turn_sign, abs(pipe.heading_change), pipe.radius, pipe.inner_edge, pipe.bend_radius)


def check_robot(robot: RobotSpec) -> None:
    """Refuse a robot that cannot do the task.

    Raises:
        PipenavError: the robot stands free.
    """
    if robot.free:
        raise PipenavError(
            f"robot {robot.name!r} stands free, and this task moves an arm on a mount: choose --preset pirate."
        )


START_WALL_DISTANCE = 0.002
"""Least distance between the robot and the wall at the start [m]."""


def check_fits(robot: RobotSpec, pipes: Sequence[Pipe]) -> None:
    """Refuse pipes in which the robot cannot lie straight.

    Raises:
        PipenavError: the first such pipe.
    """
    need = robot.width + 2 * START_WALL_DISTANCE
    for pipe in pipes:
        if pipe.narrowest < need:
            raise PipenavError(
                f"pipe {pipe.label} is too narrow for robot {robot.name!r}, which is {m_to_mm(robot.width):g} mm wide "
                f"and needs {m_to_mm(need):g} mm at rest: choose a wider pipe."
            )


def _bend_factor(robot: RobotSpec, bend: Floats, radius: Floats) -> Floats:
    """Factor in [0, 1] on start angles that keeps the robot off the walls, (k,).

    Every hinge swings the rest of the robot sideways by at most its angle times the length that follows it.
    """
    following = np.cumsum(robot.lengths[::-1])[::-1]
    sideways = np.abs(bend) @ following
    free = radius - robot.width / 2 - START_WALL_DISTANCE
    return np.asarray(np.clip(free / np.maximum(sideways, 1e-9), 0.0, 1.0))


def _second_leg(turn_angle: Floats) -> _LegDirections:
    """Directions of the second leg of a left turn by `turn_angle`, (k,) [rad]."""
    along = np.stack([np.cos(turn_angle), np.sin(turn_angle)], axis=1)
    return _LegDirections(along, np.stack([-along[:, 1], along[:, 0]], axis=1))


INSIDE_WALL = np.deg2rad(165.0)
"""A heading from the inner edge into the wall of every pipe: the wall fills pi - angle to pi, with angle >= 30 deg."""


def distance_to_target(tip: Floats, target: Floats, edge: Floats) -> Floats:
    """Length of the path from the tip to the target: straight, or around the inner edge where that is in between.

    Seen from the edge, the free space is a wedge; the wall is in between when tip and target lie more than a half turn
    apart in it. The length changes by no more than the tip moves.

    Args:
        tip: tip in the canonical frame, (n, 2) [m].
        target: target in that frame, (n, 2) [m].
        edge: inner edge in that frame, (n, 2) [m].
    """
    x, y = np.array([(target - edge).T, (tip - edge).T, (target - tip).T]).swapaxes(0, 1)  # (3, n) each
    target_distance, tip_distance, straight = np.hypot(x, y)
    target_turn, tip_turn = np.mod(np.arctan2(y[:2], x[:2]) - INSIDE_WALL, 2 * np.pi)  # counter-clockwise
    return np.asarray(np.where(target_turn - tip_turn > np.pi, tip_distance + target_distance, straight))


def at_limit(robot: RobotSpec, config: ReachConfig, q: Floats) -> Flags:
    """Whether any joint has hit its limit, (n,)."""
    margin = config.limit_margin * (robot.upper - robot.lower)
    return np.asarray(((q <= robot.lower + margin) | (q >= robot.upper - margin)).any(axis=1))
