"""Where an episode of the traverse task starts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route_sets import parse_pipes
from pipenav.robots import kinematics
from pipenav.robots.robot import BASE, RobotSpec
from pipenav.tasks.traverse.config import TraverseConfig

GRAVITY = 9.81
"""Standard gravity, to three digits [m/s^2]."""

SPARE_LENGTHS = 2.2
"""Length of a leg in robot lengths: room before the corner to slide back in, and beyond it to leave the corner."""

STEEPEST = 0.95
"""Sine of the largest angle between a link and the pipe's axis at the start: a steeper one would be hard to clamp."""


class TraverseEpisodes(NamedTuple):
    """k episodes about to start.

    Attributes:
        pipes: the pipe of each, its ends long enough for the robot.
        q: start configurations in the robot's own frame, (k, coordinates).
        base: x of the robot's frame in the pipe's frame, (k,) [m].
        gravity: its part in the pipe's plane, axes of the pipe's frame, (k, 2) [m/s^2].
    """

    pipes: tuple[Pipe, ...]
    q: Floats
    base: Floats
    gravity: Floats

    def part(self, rows: slice) -> TraverseEpisodes:
        """Some of the episodes."""
        return TraverseEpisodes(self.pipes[rows], *(column[rows] for column in self[1:]))


def sample(
    robot: RobotSpec, config: TraverseConfig, pipes: Sequence[Pipe], rng: np.random.Generator
) -> TraverseEpisodes:
    """Random start poses, one episode for each of the given pipes.

    The robot lies along the first leg with its wheels off the axis to either side by turns, at a full spread touching
    the walls, from where it can clamp at once.
    """
    k = len(pipes)
    gap, spread = rng.uniform(*config.start_gap, k), rng.uniform(*config.start_spread, k)
    first, angle = rng.integers(2, size=k) * 2.0 - 1.0, rng.uniform(0.0, 1.0, k)
    long = tuple(with_room(robot, config, pipe) for pipe in pipes)
    radius, inner = np.array([_first_corner(pipe) for pipe in pipes]).reshape(k, 2).T
    q = np.zeros((k, robot.coordinates))
    q[:, 1 : len(BASE)], q[:, len(BASE) :] = _zigzag(robot, first * spread * (radius - robot.width / 2))
    base = -inner - gap - kinematics.forward(robot, q).tip[:, 0]
    gravity = np.zeros((k, 2))
    if config.inclination_deg is not None:
        low, high = np.deg2rad(config.inclination_deg)
        direction = low + (high - low) * angle
        gravity = GRAVITY * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    return TraverseEpisodes(long, q, base, gravity)


def check_robot(robot: RobotSpec) -> None:
    """Refuse a robot that cannot do the task.

    Raises:
        PipenavError: it hangs on a mount, or has no wheels.
    """
    if not (robot.free and robot.wheels):
        raise PipenavError(f"robot {robot.name!r} hangs on a mount and cannot traverse a pipe: choose --robot pirate.")


def parse_planar(given: Sequence[str]) -> list[Pipe]:
    """Pipes and runs as `pipenav.pipes.route_sets.parse_pipes` takes them.

    Raises:
        PipenavError: something unknown or impossible, or a run that leaves the plane in which the robot is trained.
    """
    pipes = parse_pipes(given)
    for pipe in pipes:
        if not pipe.planar:
            raise PipenavError(
                f"{pipe.name} leaves the plane, in which robots are trained: choose a run without rolls, as runs-level."
            )
    return pipes


def with_room(robot: RobotSpec, config: TraverseConfig, pipe: Pipe) -> Pipe:
    """The pipe with ends in which the robot has room to start and to leave, and of a single corner to slide back.

    Raises:
        CrossesItself: the ends of a run are too short, and longer they would meet other straights.
    """
    first, last = pipe.inner_edges[[0, -1]]
    if pipe.corner is not None:
        back = SPARE_LENGTHS * robot.length
        return pipe.with_ends(first + back, last + back)
    ahead = max(config.start_gap[1], config.through)
    return pipe.with_ends(first + robot.length + ahead, last + robot.length + ahead)


def _first_corner(pipe: Pipe) -> tuple[float, float]:
    """Radius of the pipe, and how far before its first corner the inner wall's bend begins [m]."""
    return pipe.radius, float(pipe.inner_edges[0])


def _zigzag(robot: RobotSpec, offset: Floats) -> tuple[Floats, Floats]:
    """First link's y and heading (k, 2), and joint positions (k, joints), that put joints at +-offset by turns.

    The first and the last link lie along the axis.
    """
    links = len(robot.links)
    signs = np.ones(links)
    signs[2::2] = -1.0  # the first link lies where its end is, at the first joint
    sideways = offset[:, None] * signs  # where each link starts, (k, links)
    rise = np.diff(sideways, axis=1)[:, 1:] / robot.lengths[1:-1]
    headings = np.zeros((len(offset), links))
    headings[:, 1:-1] = np.arcsin(np.clip(rise, -STEEPEST, STEEPEST))
    start = np.stack([sideways[:, 0], headings[:, 0]], axis=1)
    return start, np.diff(headings, axis=1)
