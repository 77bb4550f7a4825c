"""The bench on which laws of robots in space are checked, and how its robots start."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.simulators import open_space
from pipenav.backends.spatial import SpaceBackend
from pipenav.pipes.route import PipeRoute
from pipenav.robots.kinematics import waypoints
from pipenav.robots.robot import BASE, RobotSpec, load_robot

STEEP = 0.45
"""Angle between the links of a clamped robot and the pipe's axis [rad]."""

PRESS = 0.1
"""Angle by which a clamped robot's joints are asked to bend farther than they can [rad]."""


class SpaceStart(NamedTuple):
    """Arguments of `SpaceBackend.reset`, and the gravity in which robots start, (k, 3) [m/s^2]."""

    indices: Ints
    routes: list[PipeRoute]
    q: Floats
    base: Floats
    plane: Floats
    gravity: Floats

    def part(self, rows: Ints) -> SpaceStart:
        """Start of some of the robots, by their rows."""
        routes = [self.routes[row] for row in rows]
        return SpaceStart(self.indices[rows], routes, *(column[rows] for column in self[2:]))

    def begin(self, subject: SpaceBackend) -> None:
        """Incline and reset the robots."""
        subject.incline(self.indices, self.gravity)
        subject.reset(*self[:5])


@dataclass(frozen=True)
class SpaceBench:
    """A backend in space to check, and the robots that it is opened for.

    Attributes:
        backend: name of an installed simulator that moves robots in space, or what constructs a backend of a robot and
            a number of robots.
        robot: the robot, with a roll joint and wheels.
        n: number of robots; with 1 the laws about several robots hold trivially.
        options: settings of the simulator.
    """

    backend: str | Callable[[RobotSpec, int], SpaceBackend]
    robot: RobotSpec = field(default_factory=lambda: load_robot("pirate-strong"))
    n: int = 3
    options: Mapping[str, Any] = field(default_factory=dict)

    def open(self) -> closing[SpaceBackend]:
        """Open a new backend, which is closed at the end of the `with` block.

        Raises:
            PipenavError: the simulator cannot be opened, or moves robots in a plane alone.
        """
        if isinstance(self.backend, str):
            return closing(open_space(self.backend, self.robot, self.n, self.options))
        return closing(self.backend(self.robot, self.n))

    def commands(self, steps: int, seed: int = 0) -> list[tuple[Floats, Floats]]:
        """Random set-points of actuators and of the roll joints, in the middle half of their travel and speed."""
        robot, rng = self.robot, np.random.default_rng(seed)
        travel = np.minimum(-robot.lower, robot.upper)
        wheels = [actuator.speed_limit for actuator in robot.driven_actuators[len(travel) :]]
        reach = 0.5 * np.concatenate([travel, wheels])
        values = rng.uniform(-1.0, 1.0, (steps, self.n, len(reach)))
        return [(reach * value, rng.uniform(-0.5, 0.5, self.n)) for value in values]


def space_starts(bench: SpaceBench, seed: int = 0) -> SpaceStart:
    """Start of every robot: nearly straight, in a plane and under a gravity of its own, before its own corners."""
    rng, n = np.random.default_rng(seed), bench.n
    routes = [
        PipeRoute.of(90, [(90, "left", 0), (75, "right", 90)], [1500, 900, 800]),
        PipeRoute.of(110, [(120, "right", 50)], [1500, 900]),
        PipeRoute.of(100, [(60, "left", 180), (90, "left", 270, 150), (100, "left", 0)], [1500, 900, 900, 800]),
    ]
    chosen = [routes[(i + seed) % len(routes)] for i in range(n)]
    q = rng.uniform(-0.02, 0.02, (n, bench.robot.coordinates)) * np.r_[0.1, 0.1, np.ones(bench.robot.coordinates - 2)]
    edges = np.array([route.inner_edges[0] for route in chosen])
    base = -edges - rng.uniform(0.05, 0.08, n) - bench.robot.length
    down = rng.normal(size=(n, 3))
    gravity = 9.81 * down / np.linalg.norm(down, axis=1, keepdims=True)
    return SpaceStart(np.arange(n), chosen, q, base, rng.uniform(-math.pi, math.pi, n), gravity)


def clamped(bench: SpaceBench) -> SpaceStart:
    """Start of every robot in a zigzag that fits its straight pipe, under a gravity of its own across the pipe.

    Along the pipe wheels would creep, as they have servos of speed.
    """
    robot, n, start = bench.robot, bench.n, space_starts(bench)
    links = len(robot.links)
    headings = STEEP * np.where(np.arange(links) % 2, -1.0, 1.0) * (np.arange(links) % (links - 1) > 0)
    q = np.concatenate([np.zeros(len(BASE)), np.diff(headings)])
    across = waypoints(robot, q[None])[0, 1:-1, 1]  # of the joints, which have the wheels
    q[1] = -(across.max() + across.min()) / 2
    tread, reach = robot.wheels[0], (across.max() - across.min()) / 2 + robot.wheels[0].radius
    route = PipeRoute.of(2e3 * math.hypot(reach, tread.height / 2), [(90, "left", 0)], [1500, 900])
    gravity = start.gravity * [0.0, 1.0, 1.0]
    return start._replace(routes=[route] * n, q=np.tile(q, (n, 1)), base=np.full(n, -1.0), gravity=gravity)
