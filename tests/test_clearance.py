"""Clearance by plane geometry against MuJoCo's own distances between the shapes of robots and pipes."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from pipenav_mujoco.model import Contact, static_spec

from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.wall_distance import clearance
from pipenav.robots.robot import load_robot, robot_names


@pytest.mark.parametrize("name", robot_names())
@pytest.mark.parametrize(("diameter", "angle", "bend"), [(110, 60, 0), (120, 100, 0), (130, 90, 120)])
def test_clearance_is_the_distance_of_the_shapes(name: str, diameter: float, angle: float, bend: float) -> None:
    rng = np.random.default_rng(7)
    robot, pipe = load_robot(name), PipeCorner.of(diameter, angle, bend_radius_mm=bend)
    base = -pipe.inner_edge - 0.32
    model = static_spec(robot, pipe, 0.0025, Contact(0.005, (0.95, 0.99, 0.001)), base).compile()
    data = mujoco.MjData(model)
    wheels = {wheel.name for wheel in robot.wheels}
    places = [i for i in range(model.njnt) if model.joint(i).name not in wheels]
    pairs = [(a, b) for a in range(model.ngeom) for b in range(model.ngeom) if _meet(model, a, b)]
    errors = []
    for _ in range(500):
        q = rng.uniform(-0.2, 0.5, robot.coordinates)
        q[0] = rng.uniform(0.0, 0.1)
        if robot.free:
            q[:3], q[3:] = [-0.23, 0.0, 0.0] + 0.1 * q[:3], 0.5 * (q[3:] - 0.1)
        data.qpos[places] = q
        mujoco.mj_kinematics(model, data)
        distance = min(mujoco.mj_geomDistance(model, data, a, b, 1.0, None) for a, b in pairs)
        if distance > 1e-3:
            errors.append(distance - clearance(robot, pipe, q, base))
    assert len(errors) > 30
    # Never more than the truth; less only between two corners, and by what a chord leaves of an arc.
    assert np.min(errors) > -2e-4
    assert np.median(np.abs(errors)) < 2e-4
    assert np.max(errors) < 0.02


def _meet(model: mujoco.MjModel, link: int, wall: int) -> bool:
    return bool(model.geom_contype[link] & model.geom_conaffinity[wall]) and model.geom_bodyid[link] > 0
