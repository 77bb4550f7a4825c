"""A planar route as walls in the plane and as walls in space: the same commands give the same motion."""

from __future__ import annotations

import math
from contextlib import closing

import numpy as np
import pytest

from pipenav.backends.messages import Command
from pipenav.backends.simulators import open_simulator, open_space
from pipenav.pipes.reducer import reducer
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import load_robot
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import sample

ROBOT = load_robot("pirate-strong")
ONE = np.arange(1)

PRESS = 0.3 * np.array([0.0, 1.0, 0.0, 0.0, 1.0, 0.0])
"""Angles by which the joints of a clamped robot are asked to bend farther than they can [rad]."""

ROLL = 5.0
"""Speed of the wheels [rad/s]."""


def as_wide_as_a_tread_finds_it(route: PipeRoute) -> PipeRoute:
    """The route between two boards as far apart as the chords on which a wheel's tread stands in the round bore."""

    def between(diameter: float) -> float:
        return math.sqrt(diameter**2 - ROBOT.wheels[0].height ** 2)

    corners = [
        corner if corner.to_diameter is None else corner.model_copy(update={"to_diameter": between(corner.to_diameter)})
        for corner in route.corners
    ]
    return PipeRoute(diameter=between(route.diameter), corners=tuple(corners), straights=route.straights)


@pytest.mark.parametrize(
    ("route", "gap", "steps"),
    [
        (PipeRoute.of(70, [(90, "left", 0)], [1500, 1500]), 0.4, 30),
        (PipeRoute.of(120, [(90, "left", 0)], [1500, 1500]), 0.4, 30),
        (PipeRoute.of(90, [(120, "left", 0, 450)], [1500, 1500]), 0.05, 60),
        (PipeRoute.of(90, [(150, "right", 0)], [1500, 1500]), 0.1, 60),
        (PipeRoute.of(90, [(90, "left", 0)], [1500, 1500]), 0.1, 40),
        (reducer(90, 70, 60), 0.1, 60),
        (reducer(80, 110, 60), 0.1, 60),
    ],
    ids=lambda value: value.name if isinstance(value, PipeRoute) else None,
)
def test_a_clamped_robot_moves_in_space_as_in_the_plane(route: PipeRoute, gap: float, steps: int) -> None:
    flat = as_wide_as_a_tread_finds_it(route)
    task = TraverseConfig(kind="traverse", start_spread=(1.0, 1.0), start_gap=(gap, gap + 1e-3))
    start = sample(ROBOT, task, [flat], np.random.default_rng(0))
    with (
        closing(open_simulator("mujoco", ROBOT, 1, {"threads": 1}, len(flat.segments))) as plane,
        closing(open_space("mujoco", ROBOT, 1, {"threads": 1})) as space,
    ):
        q = plane.reset(ONE, [flat], start.q, start.base).q[0]
        space.reset(ONE, [route], start.q, start.base, np.zeros(1))
        begin, apart = plane.truth().tip[0, 0], []
        set_points = np.concatenate([q + PRESS * np.sign(q), -ROLL * np.sign(q)])[None]
        for _ in range(steps):
            plane.step(Command("position", set_points))
            space.step(set_points, np.zeros(1))
            apart.append(np.linalg.norm(plane.truth().tip[0, :2] - space.truth().points[0, -1, :2]))
        gone, points = plane.truth().tip[0, 0] - begin, space.truth().points[0]
    assert gone > 0.12 and max(apart) < 3e-3
    assert np.abs(points[:, 2]).max() < 1e-3
