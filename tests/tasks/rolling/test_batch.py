"""The traverse task in space: which gravity comes with it."""

from __future__ import annotations

from contextlib import closing
from typing import get_args

import numpy as np
import pytest
from helpers.rolling import ROBOT

from pipenav.backends.simulators import open_space
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.tee import TeePassage, Way, tee
from pipenav.tasks.rolling.batch import RollingBatch
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import sample


@pytest.mark.parametrize("inclination", [None, (0.0, 360.0)])
def test_gravity_comes_with_the_task(inclination: tuple[float, float] | None) -> None:
    task = TraverseConfig(kind="traverse", inclination_deg=inclination)
    route = PipeRoute.of(90, [(90, "left", 0), (75, "right", 90)], [1200, 900, 800])
    episode = sample(ROBOT, task, [route], np.random.default_rng(0))
    backend = open_space("mujoco", ROBOT, 1, {"threads": 1})
    with closing(RollingBatch(ROBOT, task, backend, 1, lambda _: episode)) as batch:
        batch.reset()
        down = backend.read().down[0]
    np.testing.assert_allclose(down, [[0.0, 0.0, 0.0 if inclination is None else -1.0]] * 2, atol=1e-9)


def test_in_space_too_a_robot_is_told_where_its_route_goes_straight_on() -> None:
    task = TraverseConfig(kind="traverse", exit_told=True)
    pipes = [tee(90, 90, TeePassage(way, "right")) for way in get_args(Way)]
    episode = sample(ROBOT, task, pipes, np.random.default_rng(0))
    backend = open_space("mujoco", ROBOT, len(pipes), {"threads": 1})
    with closing(RollingBatch(ROBOT, task, backend, len(pipes), lambda _: episode)) as batch:
        seen = batch.reset()
    assert list(seen[:, -1]) == [float(way == "straight") for way in get_args(Way)]
