"""Robots in space on MuJoCo: the same robot as in the plane, in a pipe of prisms."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import closing, contextmanager

import numpy as np
import pytest

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.simulators import open_simulator, open_space
from pipenav.backends.spatial import SpaceBackend
from pipenav.errors import PipenavError
from pipenav.pipes.rotations import about_x
from pipenav.pipes.route import PipeRoute
from pipenav.robots import traction
from pipenav.robots.kinematics import waypoints
from pipenav.robots.robot import load_robot
from pipenav.tasks.rolling.clamp import ZIGZAG, RollForward, steepness
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import GRAVITY, sample

ROBOT = load_robot("pirate-strong")
RUN = PipeRoute.of(90, [(90, "left", 0), (75, "right", 90)], [1200, 900, 800])
ONE = np.arange(1)


def world(n: int = 1, gravity: float = GRAVITY, **options: float) -> SpaceBackend:
    backend = open_space("mujoco", ROBOT, n, options)
    backend.incline(np.arange(n), np.tile([0.0, 0.0, -gravity], (n, 1)))
    return backend


@contextmanager
def placed(
    route: PipeRoute, plane: float = 0.0, gravity: float = GRAVITY
) -> Iterator[tuple[SpaceBackend, Floats, float]]:
    """A robot in its plane at the start of a route: the backend, its configuration and its base."""
    task = TraverseConfig(kind="traverse", start_spread=(1.0, 1.0), start_gap=(0.4, 0.5))
    episode = sample(ROBOT, task, [route], np.random.default_rng(3))
    with closing(world(gravity=gravity)) as backend:
        backend.reset(ONE, [route], episode.q, episode.base, np.array([plane]))
        yield backend, episode.q, float(episode.base[0])


@pytest.mark.parametrize("plane", [0.0, 0.7, -math.pi / 2, math.pi])
def test_a_robot_lies_in_its_plane_and_feels_which_way_is_down(plane: float) -> None:
    with placed(RUN, plane) as (backend, q, base):
        flat = np.concatenate([waypoints(ROBOT, q)[0], np.zeros((len(ROBOT.links) + 1, 1))], axis=1)
        truth, reading = backend.truth(), backend.read()
        np.testing.assert_allclose(truth.points[0], flat @ about_x(plane).T + [base, 0, 0], atol=1e-9)
        np.testing.assert_allclose(truth.normals[0], [about_x(plane) @ [0, 0, 1]] * 2, atol=1e-9)
        np.testing.assert_allclose(reading.down[0, :, 2], -math.cos(plane), atol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(reading.down, axis=2), 1.0)
        np.testing.assert_allclose(reading.body.q, q[:, 3:])
        assert reading.roll[0] == 0.0


def test_where_nothing_weighs_nothing_is_down() -> None:
    with placed(RUN, gravity=0.0) as (backend, *_):
        assert not backend.read().down.any()


def test_an_option_overrules_the_tasks_gravity() -> None:
    with (
        placed(RUN, gravity=0.0) as (_, q, base),
        closing(open_space("mujoco", ROBOT, 1, {"gravity": 9.81})) as other,
    ):
        assert other.reset(ONE, [RUN], q, np.array([base]), np.zeros(1)).down.any()


def test_the_laser_reads_in_the_corners_plane_what_it_reads_in_the_plane() -> None:
    level = PipeRoute.of(90, [(90, "left", 0), (75, "right", 0)], [1200, 900, 800])
    with placed(level) as (backend, q, base), closing(open_simulator("mujoco", ROBOT, 1, {}, 6)) as plane:
        flat = plane.reset(ONE, [level], q, np.array([base])).ranges
        assert np.abs(backend.read().body.ranges - flat).max() <= ROBOT.laser.resolution + 1e-9


@pytest.mark.parametrize("diameter", [70, 120])
@pytest.mark.parametrize("plane", [0.0, math.pi / 2])
def test_a_clamped_robot_drives_and_stays_in_its_plane_and_out_of_the_wall(diameter: int, plane: float) -> None:
    route = PipeRoute.of(diameter, [(90, "left", 0)], [1500, 900])
    with placed(route, plane) as (backend, *_):
        q = backend.read().body.q
        rolling = RollForward(ROBOT, 1)
        rolling.begin(ONE, np.array([route.radius]), q, q)
        start, deepest = backend.truth().points[0, :, 0].mean(), 0.0
        for _ in range(30):
            body = backend.read().body
            assert body.wheel_speeds is not None
            backend.step(rolling.act(ONE, body.q, body.wheel_speeds), np.zeros(1))
            deepest = max(deepest, backend.truth().penetration[0])
        truth = backend.truth()
        gone = truth.points[0, :, 0].mean() - start
        assert gone > 0.1
        assert rolling.clamped[0] and rolling.distance[0] == pytest.approx(gone, abs=0.02)
        zigzag = rolling.zigzag_sign[0] * steepness(ROBOT, np.array([route.radius]))[0] * ZIGZAG
        np.testing.assert_allclose(backend.read().body.q[0], zigzag, atol=0.1)
        assert deepest < 1e-3
        upright = about_x(plane) @ np.array([0, 0, 1])
        assert (truth.normals[0] @ upright > math.cos(math.radians(5))).all()


def test_robots_do_not_depend_on_each_other_nor_on_threads() -> None:
    routes = [RUN, PipeRoute.of(70, [(120, "right", 90), (90, "left", 0)], [1300, 1000, 800])]
    episodes = sample(ROBOT, TraverseConfig(kind="traverse"), routes, np.random.default_rng(0))
    assert all(isinstance(route, PipeRoute) for route in episodes.pipes)
    ends = []
    for rows, threads in ([0, 1], 2), ([0, 1], 1), ([1], 1):
        chosen = [routes[row] for row in rows]
        with closing(world(len(rows), threads=threads)) as backend:
            backend.reset(np.arange(len(rows)), chosen, episodes.q[rows], episodes.base[rows], np.zeros(len(rows)))
            for _ in range(5):
                backend.step(np.full((len(rows), len(ROBOT.driven_actuators)), 0.3), np.full(len(rows), 0.2))
            ends.append(backend.truth().points)
    np.testing.assert_array_equal(ends[0], ends[1])
    np.testing.assert_array_equal(ends[0][1:], ends[2])


def test_a_backend_of_the_plane_says_so() -> None:
    with pytest.raises(PipenavError, match="'pybullet' moves robots only in a plane: choose --backend mujoco"):
        open_space("pybullet", ROBOT, 1, {})


def test_a_timestep_must_divide_the_control_period_in_space_too() -> None:
    with pytest.raises(PipenavError, match="does not divide the control period"):
        world(timestep=0.003)


@pytest.mark.parametrize("axis", range(3))
def test_a_pull_moves_a_robot_as_newton_says_and_its_rear_end_farthest(axis: int) -> None:
    route, q, n = PipeRoute.of(300, [(90, "left", 0)], [4000, 2000]), np.zeros((3, ROBOT.coordinates)), 3
    ways = 0.01 * np.outer([-1.0, 0.0, 1.0], np.eye(3)[axis])  # of the centre of mass in a control period
    with closing(world(n, gravity=0.0)) as backend:
        backend.reset(np.arange(n), [route] * n, q, np.full(n, -2.0), np.zeros(n))
        before = backend.truth().points
        backend.pull(2 * traction.mass(ROBOT) / CONTROL_PERIOD**2 * ways)
        backend.step(np.zeros((n, len(ROBOT.driven_actuators))), np.zeros(n))
        moved = backend.truth().points - before
    links = np.array([link.mass for link in ROBOT.links])
    wheels = np.array([link.wheel.mass if link.wheel else 0.0 for link in ROBOT.links])
    middles = (moved[:, :-1] + moved[:, 1:]) / 2  # of the links; a wheel sits at a link's joint
    centre = np.tensordot(middles, links, (1, 0)) + np.tensordot(moved[:, :-1], wheels, (1, 0))
    np.testing.assert_allclose(centre / traction.mass(ROBOT), ways, atol=5e-4)
    assert (np.abs(moved[:, 0, axis]) >= np.abs(ways[:, axis]) * (2.0 if axis else 1.0)).all()
