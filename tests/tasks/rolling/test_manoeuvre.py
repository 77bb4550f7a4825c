"""The manoeuvre that rolls a robot between corners in several planes."""

from __future__ import annotations

import math
from contextlib import closing

import numpy as np
import pytest
from helpers.rolling import ROBOT, clamped

from pipenav.backends.simulators import open_space
from pipenav.pipes.route import PipeRoute
from pipenav.tasks.rolling.clamp import axle_offset
from pipenav.tasks.rolling.manoeuvre import Roll, RollPhase
from pipenav.tasks.traverse.episode import GRAVITY


@pytest.mark.slow
@pytest.mark.parametrize(
    ("diameter", "gravity", "plane", "third"),
    [(70, GRAVITY, 90, 1.0), (90, GRAVITY, 0, -1.0), (120, GRAVITY, 90, -1.0), (120, 0.0, 0, 1.0)],
)
def test_a_roll_turns_the_plane_by_what_was_asked_and_the_robot_stays_where_it_is(
    diameter: int, gravity: float, plane: float, third: float
) -> None:
    route, turn, start = PipeRoute.of(diameter, [(90, "left", 0)], [1500, 600]), math.radians(90), math.radians(plane)
    q = np.concatenate(
        [[0.0, third * axle_offset(ROBOT, route.radius - 1e-4), 0.0], clamped(route.radius - 1e-4, third)]
    )
    one = np.arange(1)
    with closing(open_space("mujoco", ROBOT, 1, {})) as backend:
        backend.incline(one, np.array([[0.0, 0.0, -gravity]]))
        backend.reset(one, [route], q[None], np.array([-1.0]), np.array([start]))
        now, before = backend.read(), backend.truth().points[0, :, 0].mean()
        roll, deepest = Roll(ROBOT, 1), 0.0
        roll.begin(one, np.array([route.radius]), np.array([turn]), now.body.q, now.down)
        while roll.phase[0] != RollPhase.DONE:
            assert now.body.wheel_speeds is not None
            backend.step(*roll.act(one, now.body.q, now.roll, now.body.wheel_speeds, now.down))
            now, deepest = backend.read(), max(deepest, float(backend.truth().penetration[0]))
        truth = backend.truth()
    turned = np.arctan2(-truth.normals[0, :, 1], truth.normals[0, :, 2]) - start
    assert np.abs(np.remainder(turned - turn + math.pi, 2 * math.pi) - math.pi).max() < math.radians(12)
    assert abs(now.roll[0]) < 0.05
    np.testing.assert_allclose(np.abs(now.body.q[0]), np.abs(clamped(route.radius, 1.0)), atol=0.4)
    assert deepest < 1e-3
    assert abs(truth.points[0, :, 0].mean() - before) < 0.12
