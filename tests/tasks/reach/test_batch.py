"""The reach task stepped on a backend without physics: how episodes end, and what the history remembers."""

from __future__ import annotations

import numpy as np
import pytest

from pipenav.backends.backend import BackendOptions, Simulator
from pipenav.backends.messages import Command, Reading, Truth
from pipenav.pipes.corner_sets import parse_corners
from pipenav.robots import kinematics
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig, RewardConfig
from pipenav.tasks.reach.task import ReachTask
from pipenav.tasks.sampling import random_episodes

ROBOT, TASK = load_robot("basic"), ReachConfig()
PIPE = parse_corners(["working-range"])[0]


class Puppet(Simulator):
    """A backend without physics: the robot is where the test puts it."""

    Options = BackendOptions

    def __init__(self, n: int = 1) -> None:
        self.q, self.penetration = np.zeros((n, 4)), np.zeros(n)
        self.ranges = np.full((n, 10), 0.3)

    def reset(self, indices, pipes, q, base) -> Reading:  # type: ignore[no-untyped-def]  # noqa: ARG002
        self.q[indices] = q
        return self.read().part(indices)

    def step(self, command: Command) -> None:
        pass

    def read(self) -> Reading:
        return Reading(self.q.copy(), np.zeros_like(self.q), self.ranges.copy(), np.zeros(len(self.q)))

    def truth(self) -> Truth:
        zero = np.zeros(len(self.q))
        return Truth(np.zeros((len(self.q), 3)), zero, self.penetration.copy(), zero, np.zeros((len(self.q), 4, 2)))

    def close(self) -> None:
        pass


def puppet_batch(**task: object) -> tuple[ReachBatch, Puppet]:
    backend, config = Puppet(), ReachConfig.model_validate(task)
    source = random_episodes(ReachTask(config), ROBOT, [[PIPE]], np.random.default_rng(1))
    batch = ReachBatch(ROBOT, config, backend, 1, source)
    batch.reset()
    return batch, backend


def put_tip_at_the_target(batch: ReachBatch, backend: Puppet) -> None:
    """Bend two hinges and move the slide: two links to the target, the head in line with the second."""
    x, y = batch.target[0]
    theta = np.arctan2(y, x - 0.04 - 0.2)
    distance = np.hypot(y, x - 0.24)
    far = 0.23  # link2 and the head
    bend = np.arccos(np.clip((distance**2 - 0.12**2 - far**2) / (2 * 0.12 * far), -1, 1))
    first = theta - np.arctan2(far * np.sin(bend), 0.12 + far * np.cos(bend))
    backend.q[0] = [0.2, first, bend, 0.0]
    assert kinematics.forward(ROBOT, backend.q).tip[0] == pytest.approx(batch.target[0])


STILL = np.zeros((1, 4))


def test_outcomes_have_an_order_of_precedence() -> None:
    batch, backend = puppet_batch(max_steps=1)
    assert batch.step(STILL).outcome == Outcome.TIMEOUT
    put_tip_at_the_target(batch, backend)
    assert batch.step(STILL).outcome == Outcome.REACHED
    backend.q[0, 0] = ROBOT.upper[0]
    assert batch.step(STILL).outcome == Outcome.LIMIT
    backend.penetration[0] = 1.01 * TASK.max_penetration
    assert batch.step(STILL).outcome == Outcome.PENETRATION


def test_an_episode_that_reaches_its_target_in_a_wall_has_failed() -> None:
    batch, backend = puppet_batch()
    put_tip_at_the_target(batch, backend)
    backend.penetration[0] = 1.01 * TASK.max_penetration
    result = batch.step(STILL)
    assert result.outcome == Outcome.PENETRATION
    assert result.reward == pytest.approx([RewardConfig().limit])


def test_the_first_history_state_repeats_the_present_and_knows_no_action() -> None:
    batch, backend = puppet_batch(observation="history")
    scale = ReachTask(batch.config).observation_scale(ROBOT)
    first = batch.reset()[0] * scale
    assert np.array_equal(first[:18], first[18:36])
    assert np.array_equal(first[36:40], np.zeros(4))
    backend.q[0] += 0.01
    second = batch.step(np.array([[0.5, -2.0, 0.0, 1.0]])).observation[0] * scale
    assert second[18:36] == pytest.approx(first[:18])
    assert second[36:40] == pytest.approx([0.5, -1.0, 0.0, 1.0])
    backend.q[0] += 0.01
    again = batch.reset()[0] * scale
    assert np.array_equal(again[:18], again[18:36])
    assert np.array_equal(again[36:40], np.zeros(4))
