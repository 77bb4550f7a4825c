"""The bench on which laws are checked: a backend with its robot, and how its robots start and move."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Backend
from pipenav.backends.messages import Command, Control
from pipenav.backends.registry import check_options, construct, flaw_of, open_backend
from pipenav.errors import BackendUnavailable
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec, load_robot


@dataclass(frozen=True)
class Bench:
    """A backend to check, and the robots that it is opened for.

    Attributes:
        backend: name of an installed backend, or a backend's class.
        robot: the robot.
        n: number of robots; with 1 the laws about several robots hold trivially.
        options: settings of the backend.
    """

    backend: str | type[Backend]
    robot: RobotSpec = field(default_factory=lambda: load_robot("basic"))
    n: int = 3
    options: Mapping[str, Any] = field(default_factory=dict)

    def open(self, wall_segments: int = 4) -> closing[Backend]:
        """Open a new backend, which is closed at the end of the `with` block.

        Raises:
            BackendUnavailable: the backend cannot be loaded, or its class is no usable backend.
        """
        if isinstance(self.backend, str):
            return closing(open_backend(self.backend, self.robot, self.n, self.options, wall_segments))
        name = self.backend.__name__
        if flaw := flaw_of(self.backend):
            raise BackendUnavailable(name, f"it {flaw.what}", flaw.remedy or "complete the class")
        options = check_options(name, self.backend, self.options)
        return closing(construct(self.backend, self.robot, self.n, options, wall_segments))

    def commands(self, steps: int, control: Control = "torque", seed: int = 0) -> list[Command]:
        """Random commands: duties, or set-points in the middle half of the joints' travel and the wheels' speed."""
        values = np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, self.n, len(self.robot.driven_actuators)))
        if control == "position":
            travel = np.minimum(-self.robot.lower, self.robot.upper)
            wheels = [actuator.speed_limit for actuator in self.robot.driven_actuators[len(travel) :]]
            values *= 0.5 * np.concatenate([travel, wheels])
        return [Command(control, v) for v in values]


class Start(NamedTuple):
    """Arguments of `Backend.reset`."""

    indices: Ints
    pipes: list[PipeCorner]
    q: Floats
    base: Floats

    def part(self, rows: Ints) -> Start:
        """Start of some of the robots, by their rows."""
        return Start(self.indices[rows], [self.pipes[row] for row in rows], self.q[rows], self.base[rows])


def starts(bench: Bench, seed: int = 0) -> Start:
    """Start of every robot: nearly straight, its tip 50 to 80 mm before the inner edge of its own corner."""
    rng = np.random.default_rng(seed)
    corners = [PipeCorner.of(90, 90), PipeCorner.of(110, 75, "right"), PipeCorner.of(100, 120)]
    pipes = [corners[(i + seed) % len(corners)] for i in range(bench.n)]
    q = rng.uniform(-0.02, 0.02, (bench.n, bench.robot.coordinates))
    edges = np.array([pipe.inner_edge for pipe in pipes])
    return Start(np.arange(bench.n), pipes, q, -edges - rng.uniform(0.05, 0.08, bench.n) - bench.robot.length)
