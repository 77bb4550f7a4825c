"""Recorded episodes and searches for a target are those of an evaluation, and repeat bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.locating import FAST, SIMULATOR

from pipenav.backends.backend import Backend
from pipenav.backends.simulators import SimulatorSettings
from pipenav.evaluation.passage import EpisodePlan, Passages, run_task
from pipenav.locating.printed_locator import point_on_beam
from pipenav.motions.mirror import plan_rear
from pipenav.motions.trajectory import Trajectory
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.named import open_controller
from pipenav.recording.record import RecordingSettings, record_locate, record_rear, record_task, tracking
from pipenav.robots.kinematics import forward
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.config import ReachConfig

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


def test_the_printed_method_turns_its_head_past_the_opening_of_a_narrow_pipe() -> None:
    located = record_locate(load_robot("basic"), "thesis", PipeCorner.of(80, 120), 0, 0, FAST)
    force = located.trajectory.contact_force
    assert force is not None
    assert located.trajectory.header.outcome == "timeout"
    assert located.found is None
    assert force.max() > 5.0
    better = record_locate(load_robot("basic"), "map", PipeCorner.of(80, 120), 0, 0, FAST)
    assert better.trajectory.succeeded


def test_a_recorded_search_is_the_one_that_an_evaluation_runs() -> None:
    robot, pipe = load_robot("high-fidelity"), PipeCorner.of(85, 70, "right")
    part = Passages(EpisodePlan(robot, ReachConfig(), [pipe], 3, 5, SIMULATOR)).locate()
    for number in range(3):
        located = record_locate(robot, "map", pipe, 5, number, FAST)
        np.testing.assert_array_equal(located.trajectory.q, part.motions[number])
        base, set_points = located.trajectory.header.base_m, located.trajectory.header.goal_m
        assert set_points == pytest.approx(part.targets[number] * [1.0, -1.0] + [base, 0.0])
        assert located.found is not None
        assert located.ranges.shape == (len(located.trajectory.q), robot.laser.beams)


def test_the_recorded_scan_is_the_one_that_gave_the_printed_target() -> None:
    located = record_locate(load_robot("basic"), "thesis", PipeCorner.of(120, 120), 0, 0, FAST)
    trajectory, found, beam = located.trajectory, located.found, located.beam
    assert found is not None
    assert beam == located.ranges[found].argmax()
    assert located.ranges[found, beam] > 0.3 >= located.ranges[:found].max(initial=0.0)
    target = point_on_beam(trajectory.robot, trajectory.q[found][None], np.array([beam]), 0.2)[0]
    assert trajectory.header.goal_m == pytest.approx((target[0] + trajectory.header.base_m, target[1]))
