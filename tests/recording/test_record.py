"""Recorded episodes are those of an evaluation, and repeat bit for bit."""

from __future__ import annotations

import numpy as np
import pytest

from pipenav.backends.backend import Backend
from pipenav.backends.simulators import SimulatorSettings
from pipenav.evaluation.passage import run_task
from pipenav.motions.mirror import plan_rear
from pipenav.motions.trajectory import Trajectory
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.named import open_controller
from pipenav.recording.record import RecordingSettings, record_rear, record_task, tracking
from pipenav.robots.kinematics import forward
from pipenav.tasks.outcome import Outcome

OPTIONS = {"timestep": 0.005, "threads": 1}
PIPE = PipeCorner.of(85, 70, "right")


@pytest.fixture(scope="module")
def fronts() -> list[Trajectory]:
    controller = open_controller("arm")
    return [
        record_task(controller, "arm", PIPE, 5, number, RecordingSettings("mujoco", OPTIONS)) for number in range(3)
    ]


def test_the_recorded_episode_is_the_one_that_an_evaluation_runs(fronts: list[Trajectory]) -> None:
    results = run_task(open_controller("arm"), [PIPE], 3, 5, SimulatorSettings("mujoco", OPTIONS))
    for number, front in enumerate(fronts):
        assert front.header.outcome == Outcome(results.outcome[number]).label
        assert len(front.q) - 1 == results.steps[number]
        assert np.array_equal(front.q[-1], results.q[number])
        assert front.contact_force is not None
        assert front.contact_force.max() == results.force[number]


def test_the_header_says_where_and_on_what(fronts: list[Trajectory]) -> None:
    header = fronts[0].header
    assert (header.robot, header.pipe, header.stage, header.seed) == ("basic", PIPE, "reach", 5)
    assert (header.backend, header.controller, header.options) == ("mujoco", "arm", OPTIONS)
    assert header.goal_m is not None
    tip = forward(fronts[0].robot, fronts[0].q[-1:]).tip[0] + [header.base_m, 0.0]
    assert np.linalg.norm(tip - header.goal_m) < 0.02  # reached, in the pipe's frame, where a right turn goes to -y
    assert header.goal_m[1] < 0


def test_forces_on_links_explain_the_contact_force(fronts: list[Trajectory]) -> None:
    for front in fronts:
        assert front.link_forces is not None
        assert front.contact_force == pytest.approx(np.linalg.norm(front.link_forces, axis=2).max(axis=1))
        assert not front.link_forces[0].any()


def test_who_looks_on_sees_the_start_and_every_step() -> None:
    seen: list[float] = []

    def watch(backend: Backend, _: object) -> None:
        seen.append(float(backend.read().time[0]))

    front = record_task(open_controller("arm"), "arm", PIPE, 5, 0, RecordingSettings("mujoco", OPTIONS, watch))
    assert seen == pytest.approx(front.time)


def test_a_rear_passage_and_how_well_it_follows(fronts: list[Trajectory]) -> None:
    plan = plan_rear(fronts[:1])
    rear = record_rear(plan, RecordingSettings("mujoco", OPTIONS))
    assert rear.succeeded
    assert (rear.header.stage, rear.header.backend, rear.header.pipe.turn) == ("rear", "mujoco", "left")
    assert np.array_equal(rear.q[0], plan.q[0])
    error = tracking(plan, rear)
    assert 0 < error.tip < 0.05
    assert 0 < error.joint < 0.2
    assert np.array_equal(rear.q, record_rear(plan, RecordingSettings("mujoco", OPTIONS)).q)


def test_tracking_is_the_largest_difference_beyond_the_plans_end_too(fronts: list[Trajectory]) -> None:
    plan = plan_rear(fronts[:1])
    assert tracking(plan, plan) == (0.0, 0.0, 0.0)
    longer = np.concatenate([plan.q, plan.q[-1:] + np.array([0.01, 0.0, 0.0, -0.2])])
    error = tracking(plan, Trajectory(plan.header, plan.robot, longer))
    assert error.slide == pytest.approx(0.01)
    assert error.joint == pytest.approx(0.2)
    tips = forward(plan.robot, longer[-2:]).tip
    assert error.tip == pytest.approx(np.linalg.norm(tips[0] - tips[1]))
