"""Recorded searches for a target are those of an evaluation."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.locating import FAST, SIMULATOR

from pipenav.evaluation.passage import EpisodePlan, Passages
from pipenav.locating.printed_locator import point_on_beam
from pipenav.pipes.corner import PipeCorner
from pipenav.recording.record import record_locate
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach.config import ReachConfig


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
