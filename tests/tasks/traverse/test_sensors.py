"""Sensors with errors: whom the errors depend on, how large they are, and what a robot makes of them."""

from __future__ import annotations

import math
from contextlib import closing

import numpy as np
import pytest
from helpers.rolling import ROBOT
from helpers.traversing import episodes, started
from hypothesis import given
from hypothesis import strategies as st

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.simulators import open_space
from pipenav.pipes.rotations import about_x
from pipenav.pipes.route import PipeRoute
from pipenav.robots.inertial import MEMS, SensorGrade
from pipenav.tasks.rolling.batch import RollingBatch
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import GRAVITY, sample
from pipenav.tasks.traverse.sensors import FUSION, Motion, Sensed, Sensors, turned_back

PERFECT = SensorGrade(*[0.0] * 8, accel_range=math.inf, rest=1.0, encoder_counts=2**20, tyre=0.0)
"""A grade without errors."""

INCLINED = TraverseConfig(kind="traverse", inclination_deg=(0.0, 360.0), sensors="mems")

angles = st.floats(-math.pi, math.pi)


def motion(n: int, down: tuple[float, float, float] = (0.0, 0.0, -1.0), turned: float = 0.0) -> Motion:
    """Robots with two sensors, all alike, that turn about x, (n,) of them."""
    return Motion(
        np.tile(down, (n, 2, 1)),
        np.tile([turned, 0.0, 0.0], (n, 2, 1)),
        np.zeros((n, 3)),
        np.tile(np.eye(3), (n, 2, 1, 1)),
    )


def readings(sensors: Sensors, n: int, steps: int, turned: float = 0.1) -> list[Sensed]:
    """Readings of robots that turn and roll evenly."""
    return [sensors.sense(motion(n, turned=turned), np.full((n, 6), 3.0)) for _ in range(steps)]


@given(
    seed=st.integers(0, 2**62), others=st.lists(st.integers(0, 2**62), min_size=1, max_size=3), late=st.integers(0, 5)
)
def test_errors_depend_on_the_seed_alone(seed: int, others: list[int], late: int) -> None:
    alone = Sensors(MEMS, 1, 2, 6)
    alone.start(np.arange(1), np.array([seed]), motion(1))
    among = Sensors(MEMS, n := len(others) + 1, 2, 6)
    among.start(np.arange(n), np.array([7, *others]), motion(n))
    readings(among, n, late)
    among.start(np.array([0]), np.array([seed]), motion(1))
    for one, all_of_them in zip(readings(alone, 1, 4), readings(among, n, 4), strict=True):
        for column, columns in zip(one, all_of_them, strict=True):
            np.testing.assert_array_equal(column[0], columns[0])


@given(turned=angles, roll=angles, down=st.tuples(*[st.floats(-1, 1)] * 3))
def test_vectors_turn_back_as_their_frames_turn(turned: float, roll: float, down: tuple[float, float, float]) -> None:
    vector = np.array(down)
    np.testing.assert_allclose(turned_back(vector, np.array([turned, 0, 0])), vector @ about_x(turned), atol=1e-12)
    about = turned * np.array([math.cos(roll), 0.0, math.sin(roll)])
    there = turned_back(vector, about)
    np.testing.assert_allclose(turned_back(there, -about), vector, atol=1e-9)
    assert np.linalg.norm(there) == pytest.approx(np.linalg.norm(vector))


@given(turns=st.lists(st.floats(-0.5, 0.5), min_size=1, max_size=20))
def test_without_errors_a_tumbling_robot_knows_where_down_is(turns: list[float]) -> None:
    sensors, down = Sensors(PERFECT, 1, 2, 6), np.array([0.2, 0.3, -0.9])
    sensors.start(np.arange(1), np.zeros(1, int), motion(1, tuple(down)))
    for turn in turns:
        down = turned_back(down, np.array([turn, 0, 0]))
        seen = sensors.sense(motion(1, tuple(down), turn), np.zeros((1, 6)))
        np.testing.assert_allclose(seen.down[0], [down] * 2, atol=1e-9)
        np.testing.assert_allclose(seen.turned[0, :, 0], turn, atol=1e-12)


def test_encoders_count_and_tyres_wear() -> None:
    robots, steps, speed = 400, 50, 3.0
    sensors = Sensors(MEMS._replace(tyre=0.0), robots, 2, 6)
    sensors.start(np.arange(robots), np.arange(robots), motion(robots))
    seen = np.array([one.wheel_speeds for one in readings(sensors, robots, steps)])
    count = 2 * math.pi / MEMS.encoder_counts
    np.testing.assert_allclose(seen * CONTROL_PERIOD / count, np.rint(seen * CONTROL_PERIOD / count), atol=1e-6)
    assert np.abs(seen.sum(axis=0) * CONTROL_PERIOD - speed * steps * CONTROL_PERIOD).max() <= count + 1e-9
    worn = Sensors(MEMS, robots, 2, 6)
    worn.start(np.arange(robots), np.arange(robots), motion(robots))
    shares = np.array([one.wheel_speeds for one in readings(worn, robots, steps)]).mean(axis=0) / speed
    assert shares.std() == pytest.approx(MEMS.tyre, rel=0.1)


def test_errors_are_as_large_as_the_grade_says() -> None:
    robots, steps = 1000, 100
    still = MEMS._replace(gyro_scale=0.0, accel_scale=0.0)
    sensors = Sensors(still, robots, 2, 6)
    first = sensors.start(np.arange(robots), np.arange(robots), motion(robots))
    assert (first.down - [0, 0, -1]).std() == pytest.approx(MEMS.accel_bias, rel=0.05)
    seen = readings(sensors, robots, steps, turned=0.0)
    time = steps * CONTROL_PERIOD
    # Angle after that time: noise, the bias that standing still left, and a random walk of the bias, integrated.
    left = MEMS.gyro_noise / math.sqrt(MEMS.rest) * time
    drifted = MEMS.gyro_drift * math.sqrt(time**3 / 3)
    expected = math.sqrt(MEMS.gyro_noise**2 * time + left**2 + drifted**2)
    assert sum(one.turned for one in seen).std() == pytest.approx(expected, rel=0.06)


@given(push=st.floats(-3, 3))
def test_an_accelerating_robot_takes_its_acceleration_for_weight_but_slowly(push: float) -> None:
    sensors, start = Sensors(PERFECT, 1, 2, 6), motion(1)
    sensors.start(np.arange(1), np.zeros(1, int), start)
    for step in range(round(FUSION / CONTROL_PERIOD)):
        time = (step + 1) * CONTROL_PERIOD
        place = np.array([[push * time**2 / 2, 0.0, 0.0]])
        seen = sensors.sense(start._replace(centre=place), np.zeros((1, 6)))
    share = float(seen.down[0, 0, 0]) / (-push / GRAVITY) if abs(push) > 1e-3 else 0.63
    assert share == pytest.approx(1 - math.exp(-1), abs=0.03)
    assert seen.down[0, :, 2] == pytest.approx(-1.0)


@given(seed=st.integers(0, 2**32 - 1))
def test_sensors_change_nothing_else_of_an_episode(seed: int) -> None:
    real, ideal = (episodes(INCLINED.model_copy(update={"sensors": name}), seed) for name in ("mems", "ideal"))
    for name in real._fields[1:-1]:
        np.testing.assert_array_equal(getattr(real, name), getattr(ideal, name))
    assert (real.sensor_seeds > 0).all() and not ideal.sensor_seeds.any()


def test_in_a_plane_a_robot_sees_where_down_is_with_the_errors_of_its_sensors() -> None:
    real, ideal = list[np.ndarray](), list[np.ndarray]()
    for name, seen in (("mems", real), ("ideal", ideal)):
        config = INCLINED.model_copy(update={"sensors": name})
        start = episodes(config, 3)
        with started(start, config) as batch:
            seen += [batch.step(np.zeros((len(start.pipes), 12))).observation for _ in range(5)]
    away = np.abs(np.array(real) - np.array(ideal))
    assert 0 < away[..., -2:].max() < 0.3
    assert not away[0][:, :12].any(), "joints have no errors"


def test_in_space_the_policy_sees_and_the_pilot_gets_what_the_sensors_read() -> None:
    route = PipeRoute.of(90, [(90, "left", 0), (75, "right", 90)], [1200, 900, 800])
    start = sample(ROBOT, INCLINED, [route], np.random.default_rng(0))
    backend = open_space("mujoco", ROBOT, 1, {"threads": 1})
    with closing(RollingBatch(ROBOT, INCLINED, backend, 1, lambda _: start)) as batch:
        first = batch.reset()
        later = [batch.step(np.zeros((1, 12))).observation for _ in range(3)]
        again = batch.reset()
        np.testing.assert_array_equal(first, again)
        np.testing.assert_array_equal(later, [batch.step(np.zeros((1, 12))).observation for _ in range(3)])
        true = backend.read().down[0, 1, :2]
    assert 0 < np.abs(np.abs(later[-1][0, -2:]) - np.abs(true)).max() < 0.3
