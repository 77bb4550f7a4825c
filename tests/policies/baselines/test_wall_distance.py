"""Wall distances by plane geometry against MuJoCo's own distances between the shapes of robots and pipes."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from pipenav_mujoco.model import Contact, static_spec

from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.wall_distance import wall_distance
from pipenav.robots.robot import load_robot
from pipenav.robots.variants import robot_names

ROBOT = load_robot("basic")


@pytest.mark.slow
@pytest.mark.parametrize("name", robot_names())
@pytest.mark.parametrize(("diameter", "angle", "bend"), [(110, 60, 0), (120, 100, 0), (130, 90, 120)])
def test_the_wall_distance_is_the_distance_of_the_shapes(name: str, diameter: float, angle: float, bend: float) -> None:
    rng = np.random.default_rng(7)
    robot, pipe = load_robot(name), PipeCorner.of(diameter, angle, bend_radius_mm=bend)
    base = -pipe.inner_edge - 0.32
    model = static_spec(robot, pipe, 0.0025, Contact(0.005, (0.95, 0.99, 0.001)), base).compile()
    data = mujoco.MjData(model)
    wheels = {wheel.name for wheel in robot.wheels}
    addresses = [i for i in range(model.njnt) if model.joint(i).name not in wheels]
    pairs = [(a, b) for a in range(model.ngeom) for b in range(model.ngeom) if _meet(model, a, b)]
    errors = []
    for _ in range(500):
        q = rng.uniform(-0.2, 0.5, robot.coordinates)
        q[0] = rng.uniform(0.0, 0.1)
        if robot.free:
            q[:3], q[3:] = [-0.23, 0.0, 0.0] + 0.1 * q[:3], 0.5 * (q[3:] - 0.1)
        data.qpos[addresses] = q
        mujoco.mj_kinematics(model, data)
        distance = min(mujoco.mj_geomDistance(model, data, a, b, 1.0, None) for a, b in pairs)
        if distance > 1e-3:
            errors.append(distance - wall_distance(robot, pipe, q, base))
    assert len(errors) > 30
    # Never more than the truth; less only between two corners, and by what a chord leaves of an arc.
    assert np.min(errors) > -2e-4
    assert np.median(np.abs(errors)) < 2e-4
    assert np.max(errors) < 0.02


def _meet(model: mujoco.MjModel, link: int, wall: int) -> bool:
    return bool(model.geom_contype[link] & model.geom_conaffinity[wall]) and model.geom_bodyid[link] > 0


def test_the_wall_distance_of_a_straight_arm_is_what_the_walls_leave() -> None:
    pipe = PipeCorner.of(100, 90)
    base = -pipe.inner_edge - ROBOT.length - 0.1
    poses = np.zeros((3, 4))
    poses[1, 0] = 0.1 + pipe.inner_edge + 0.03  # the tip's end face 20 mm off the outer wall
    poses[2, 1] = 0.5  # into the wall
    found = wall_distance(ROBOT, pipe, poses, base)
    np.testing.assert_allclose(found[:2], [0.04, 0.02], atol=1e-9)
    assert found[2] < 0


def test_the_wall_distance_agrees_with_a_dense_outline() -> None:
    """The distance is positive exactly where all points of the links' outlines lie inside the pipe."""
    rng = np.random.default_rng(0)
    pipe = PipeCorner.of(80, 70)
    base = -pipe.inner_edge - ROBOT.length
    q = rng.uniform([0.0, -0.3, -0.3, -0.3], [0.2, 0.3, 1.2, 1.5], (400, 4))
    found = wall_distance(ROBOT, pipe, q, base)
    inside = np.array([_outline_inside(pipe, pose, base) for pose in q])
    sure = np.abs(found) > 0.002
    np.testing.assert_array_equal(found[sure] > 0, inside[sure])
    assert 10 < inside[sure].sum() < sure.sum() - 10


def _outline_inside(pipe: PipeCorner, q: np.ndarray, base: float) -> bool:
    from pipenav.robots import kinematics

    chain = kinematics.forward(ROBOT, q[None])
    t = np.linspace(0.0, 1.0, 200)
    for start, heading, link in zip(chain.joints[0], chain.headings[0], ROBOT.links, strict=True):
        along, across = (np.array([np.cos(a), np.sin(a)]) for a in (heading, heading + np.pi / 2))
        sides = [start + link.length * t[:, None] * along + w * link.width / 2 * across for w in (-1, 1)]
        ends = [start + x * along + link.width * (t[:, None] - 0.5) * across for x in (0.0, link.length)]
        if not pipe.contains(np.concatenate(sides + ends) + np.array([base, 0.0])).all():
            return False
    return True
