"""Episodes of the traverse task: pipes with room for the robot, and start poses in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.errors import PipenavError
from pipenav.pipes.pipe import Pipe
from pipenav.robots import kinematics
from pipenav.robots.robot import BASE, RobotSpec
from pipenav.robots.zigzag import zigzag
from pipenav.tasks.traverse.config import TraverseConfig

GRAVITY = 9.81
"""Standard gravity, to three digits [m/s^2]."""

SPARE_LENGTHS = 2.2
"""Length of a leg in robot lengths: room to slide back before the corner, and to leave it afterwards."""


class TraverseEpisodes(NamedTuple):
    """k episodes about to start.

    Attributes:
        pipes: pipe of each episode, with ends long enough for the robot, k of them.
        q: start configurations in the robot's own frame, (k, coordinates).
        base: x of the robot's frame in the pipe's frame, (k,) [m].
        press: distances of the joints' set-points from the joints, (k, joints) [rad].
        gravity: gravity's part in the pipe's plane, where robots move in it, axes of the pipe's frame, (k, 2) [m/s^2].
        gravity_in_space: gravity where robots move in space, axes of the route's frame, (k, 3) [m/s^2].
        cable: length of the cable behind each robot, 0 without a tether, (k,) [m].
        sensor_seeds: seeds of the sensors' errors, 0 where sensors are ideal, (k,).
    """

    pipes: tuple[Pipe, ...]
    q: Floats
    base: Floats
    press: Floats
    gravity: Floats
    gravity_in_space: Floats
    cable: Floats
    sensor_seeds: Ints

    def part(self, rows: slice) -> TraverseEpisodes:
        """Episodes of some rows."""
        return TraverseEpisodes(self.pipes[rows], *(column[rows] for column in self[1:]))  # type: ignore[arg-type]  # all alike


class _FirstCorner(NamedTuple):
    """Radius of a pipe, and distance before its first corner at which the inner wall's bend begins [m]."""

    radius: float
    inner_edge: float


def sample(
    robot: RobotSpec, config: TraverseConfig, pipes: Sequence[Pipe], rng: np.random.Generator
) -> TraverseEpisodes:
    """Random start poses, one episode for each of the given pipes.

    The robot lies along the first leg with its wheels on alternating sides of the axis. At a full spread they touch the
    walls, so that the robot can clamp at once.
    """
    k = len(pipes)
    gap, spread = rng.uniform(*config.start_gap, k), rng.uniform(*config.start_spread, k)
    first_side, inclination = rng.integers(2, size=k) * 2.0 - 1.0, rng.uniform(0.0, 1.0, k)
    roomy = tuple(with_room(robot, config, pipe) for pipe in pipes)
    radius, inner = np.array([_first_corner(pipe) for pipe in pipes]).reshape(k, 2).T
    q = np.zeros((k, robot.coordinates))
    pose = zigzag(robot, first_side * spread * (radius - robot.width / 2))
    q[:, 1 : len(BASE)], q[:, len(BASE) :] = pose.first_link, pose.bends
    base = -inner - gap - kinematics.forward(robot, q).tip[:, 0]
    gravity, in_space = np.zeros((k, 2)), np.zeros((k, 3))
    if config.inclination_deg is not None:
        low, high = np.deg2rad(config.inclination_deg)
        direction = low + (high - low) * inclination
        gravity = GRAVITY * np.stack([np.cos(direction), np.sin(direction)], axis=1)
        in_space = GRAVITY * np.array([pipe.down for pipe in pipes]).reshape(k, 3)
    cable = np.zeros(k) if config.tether is None else rng.uniform(*config.tether.length, k)
    seeds = np.zeros(k, np.intp) if config.sensors == "ideal" else rng.integers(2**62, size=k)
    press = config.start_press * np.sign(pose.bends)
    return TraverseEpisodes(roomy, q, base, press, gravity, in_space, cable, seeds)


def check_robot(robot: RobotSpec) -> None:
    """Refuse a robot that cannot do the task.

    Raises:
        PipenavError: the robot hangs on a mount, or has no wheels.
    """
    if not (robot.free and robot.wheels):
        raise PipenavError(f"robot {robot.name!r} hangs on a mount and cannot traverse a pipe: choose --robot pirate.")


def with_room(robot: RobotSpec, config: TraverseConfig, pipe: Pipe) -> Pipe:
    """The pipe with ends in which the robot can start and leave; before a single corner, it can also slide back.

    Raises:
        CrossesItself: the ends of a route are too short, and longer ends would meet other straights.
    """
    first, last = pipe.inner_edges[[0, -1]]
    if pipe.corner is not None:
        back = SPARE_LENGTHS * robot.length
        return pipe.with_ends(first + back, last + back)
    ahead = max(config.start_gap[1], config.through)
    return pipe.with_ends(first + robot.length + ahead, last + robot.length + ahead)


def _first_corner(pipe: Pipe) -> _FirstCorner:
    return _FirstCorner(pipe.radius, float(pipe.inner_edges[0]))
