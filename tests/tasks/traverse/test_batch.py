"""The traverse task: what is seen, what counts as progress, how episodes start and end."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from helpers.traversing import CONFIG, ROBOT, episodes, started

from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Command
from pipenav.backends.simulators import open_simulator
from pipenav.disturbances.disturbance import Disturbance
from pipenav.disturbances.disturbed_backend import DisturbedSimulator
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.registry import task_of
from pipenav.tasks.sampling import random_episodes
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.episode import GRAVITY
from pipenav.testing import KinematicBackend
from pipenav.testing.kinematic import KinematicOptions


def test_an_arm_on_a_mount_is_refused() -> None:
    arm = load_robot("basic")
    with (
        closing(open_simulator("mujoco", arm, 1, {})) as simulator,
        pytest.raises(PipenavError, match="hangs on a mount"),
    ):
        TraverseBatch(arm, CONFIG, simulator, 1, lambda _: episodes())


def test_a_backend_without_gravity_is_refused_where_pipes_are_inclined() -> None:
    inclined = CONFIG.model_copy(update={"inclination_deg": (0.0, 360.0)})
    simulator = KinematicBackend(ROBOT, 1, KinematicOptions())
    with pytest.raises(PipenavError, match="cannot simulate gravity"):
        TraverseBatch(ROBOT, inclined, simulator, 1, lambda _: episodes())


@pytest.mark.parametrize("steps", [3, 5])
def test_unclamped_in_an_upright_pipe_it_falls_freely(steps: int) -> None:
    pipe, n = PipeCorner.of(120, 90, leg_mm=3000), 1
    with closing(open_simulator("mujoco", ROBOT, n, {"threads": 1})) as simulator:
        simulator.incline(np.arange(n), np.array([[-GRAVITY, 0.0]]))
        simulator.reset(np.arange(n), [pipe], np.zeros((n, 9)), np.array([-1.0]))
        height = _tip_x(simulator)
        for _ in range(steps):
            simulator.step(Command("position", np.zeros((n, 12))))
        assert height - _tip_x(simulator) == pytest.approx(GRAVITY / 2 * (0.1 * steps) ** 2, rel=0.03)


def test_held_clamped_in_an_upright_pipe_it_stays_and_its_wheels_carry_it_up() -> None:
    upright = {"set_points": "held", "start_spread": (1.0, 1.0), "start_press": 0.16, "inclination_deg": (180.0, 180.0)}
    config, pipes = CONFIG.model_copy(update=upright), [PipeCorner.of(70, 90), PipeCorner.of(100, 90, "right")]
    with started(episodes(config, pipes=pipes), config) as batch:
        heights = [batch.q[:, 0]]
        for forwards in (0.0, 0.5):
            action = np.concatenate([np.zeros((2, 6)), np.full((2, 6), forwards)], axis=1)
            for _ in range(10):
                batch.step(action)
            heights.append(batch.q[:, 0])
    assert heights[1] - heights[0] == pytest.approx(0.0, abs=0.02)
    assert np.all(heights[2] - heights[1] > 0.03)


def _tip_x(simulator: Simulator) -> float:
    return float(simulator.truth().tip[0, 0])


def test_a_disturbed_robot_falls_too() -> None:
    n = 1
    simulator = open_simulator("mujoco", ROBOT, n, {"threads": 1})
    config = CONFIG.model_copy(update={"inclination_deg": (180.0, 180.0)})
    with closing(DisturbedSimulator(simulator, ROBOT, n, Disturbance(mass=(1.5, 1.5)), 0)) as disturbed:
        one = TraverseBatch(ROBOT, config, disturbed, n, lambda _: episodes(config, pipes=[PipeCorner.of(120, 90)]))
        one.reset()
        before = one.q[0, 0]
        for _ in range(3):
            one.step(np.zeros((n, 12)))
        assert one.q[0, 0] < before - 0.1


def test_both_tasks_are_described_alike() -> None:
    arm = load_robot("basic")
    for robot, config in ((arm, ReachConfig()), (ROBOT, CONFIG)):
        task, pipes = task_of(config), [PipeCorner.of(90, 90)]
        assert len(task.action_scale(robot)) == len(robot.driven_actuators)
        source = random_episodes(task, robot, [pipes], np.random.default_rng(0))
        with closing(task.batch(robot, open_simulator("mujoco", robot, 2, {}), 2, source)) as made:
            assert made.reset().shape == (2, made.observation_size) == (2, len(task.observation_scale(robot)))
            result = made.step(np.zeros((2, made.action_size)))
            assert result.reward.shape == result.cut_off.shape == (2,)
            assert made.q.shape == (2, robot.coordinates)
