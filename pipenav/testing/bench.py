"""What the laws are checked on: one backend with its robot, and how its robots start and move."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Backend
from pipenav.backends.messages import Command, Control
from pipenav.backends.registry import check_options, construct, open_backend
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec, load_robot


@dataclass(frozen=True)
class Bench:
    """What a check is run on.

    Attributes:
        backend: a backend's name in the registry, or its class.
        robot: the robot.
        n: how many; with 1 the laws about several robots hold trivially.
        options: the backend's settings.
    """

    backend: str | type[Backend]
    robot: RobotSpec = field(default_factory=lambda: load_robot("basic"))
    n: int = 3
    options: Mapping[str, Any] = field(default_factory=dict)

    def open(self, wall_segments: int = 4) -> closing[Backend]:
        """A new backend, closed at the end of the `with` block."""
        if isinstance(self.backend, str):
            return closing(open_backend(self.backend, self.robot, self.n, self.options, wall_segments))
        options = check_options(self.backend.__name__, self.backend, self.options)
        return closing(construct(self.backend, self.robot, self.n, options, wall_segments))

    def commands(self, steps: int, control: Control = "torque", seed: int = 0) -> list[Command]:
        """Random commands: drives, or set-points within the middle half of what joints travel and wheels turn."""
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


def starts(bench: Bench, seed: int = 0) -> Start:
    """Every robot before a corner of its own, its tip 80 mm or less from where the corner begins, nearly straight."""
    rng = np.random.default_rng(seed)
    corners = [PipeCorner.of(90, 90), PipeCorner.of(110, 75, "right"), PipeCorner.of(100, 120)]
    pipes = [corners[(i + seed) % len(corners)] for i in range(bench.n)]
    q = rng.uniform(-0.02, 0.02, (bench.n, bench.robot.coordinates))
    edges = np.array([pipe.inner_edge for pipe in pipes])
    return Start(np.arange(bench.n), pipes, q, -edges - rng.uniform(0.05, 0.08, bench.n) - bench.robot.length)
