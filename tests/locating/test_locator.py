"""Approach I: the printed equations by hand, the two traps they fall into, and what the default variant promises."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.locating import ONE

from pipenav.arrays import Floats
from pipenav.backends.messages import Reading
from pipenav.evaluation.locate_stage import inside_second_leg
from pipenav.locating.locator import Exit, LocateConfig, robot_for
from pipenav.locating.printed_locator import PrintedLocator, point_on_beam
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import kinematics, laser
from pipenav.robots.robot import RobotSpec, load_robot


def reading(robot: RobotSpec, q: Floats, ranges: Floats) -> Reading:
    return Reading(q[None], np.zeros((1, len(robot.joints))), ranges[None], np.zeros(1))


def printed(robot: RobotSpec, first: Reading, turn_sign: float) -> PrintedLocator:
    locator = PrintedLocator(robot, LocateConfig(), 1)
    locator.start(ONE, first, Exit("left" if turn_sign > 0 else "right").told)
    return locator


@pytest.mark.parametrize(
    ("name", "beta_deg"),
    [
        ("basic", [0, 18, 36, 54, 72, 90, 108, 126, 144, 162]),  # (180 - 180) / 2 + 180 / 10 (i - 1)
        ("real-setup", [47, 55.6, 64.2, 72.8, 81.4, 90, 98.6, 107.2, 115.8, 124.4]),  # (180 - 86) / 2 + 8.6 (i - 1)
    ],
)
def test_eq_3_16_beams_from_the_heads_right(name: str, beta_deg: list[float]) -> None:
    angles = robot_for(load_robot(name), "thesis").laser.angles
    assert np.degrees(angles) + 90 == pytest.approx(beta_deg)


@pytest.mark.parametrize(
    ("theta", "beam", "ahead", "left"),
    [
        (0.0, 5, 0.2, 0.0),  # beta = 90 deg: straight ahead
        (0.0, 0, 0.0, -0.2),  # beta = 0: to the right
        (0.0, 9, 0.2 * math.cos(math.radians(72)), 0.2 * math.sin(math.radians(72))),  # beta = 162 deg
        (math.pi / 2, 5, 0.0, 0.2),  # the head looks left
        (-math.pi / 2, 0, -0.2, 0.0),  # the head looks right, its right is behind
    ],
)
def test_eq_3_17_the_target_on_a_beam(theta: float, beam: int, ahead: float, left: float) -> None:
    robot = robot_for(load_robot("basic"), "thesis")
    q = np.array([[0.03, 0.0, 0.0, theta]])
    tip = kinematics.forward(robot, q).tip[0]
    assert point_on_beam(robot, q, np.array([beam]), 0.2)[0] - tip == pytest.approx([ahead, left], abs=1e-12)


def test_eq_3_18_the_advance_and_the_turn() -> None:
    robot = robot_for(load_robot("basic"), "thesis")
    q, clear, near = np.array([0.1, 0.02, -0.03, 0.2]), np.full(10, 0.3), np.full(10, 0.3)
    near[5] = 0.05  # no more than delta, straight ahead
    locator = printed(robot, reading(robot, q, clear), 1.0)
    advances = []
    for ranges in (clear, near, near, clear):
        set_points = locator.act(reading(robot, q, ranges)).set_points[0]
        advances.append(set_points[0] - 0.1)
        assert set_points[1:] == pytest.approx([0.02, -0.03, 0.35])  # theta1, theta2 hold, theta3 turns by 0.15 rad
    assert advances == pytest.approx([0.02, 0.02 / 8, 0.02 / 64, 0.02])
    right = printed(robot, reading(robot, q, clear), -1.0)
    assert right.act(reading(robot, q, clear)).set_points[0, 3] == pytest.approx(0.05)


def test_a_near_wall_beside_the_head_does_not_slow_the_advance() -> None:
    robot = robot_for(load_robot("basic"), "thesis")
    q, ranges = np.zeros(4), np.full(10, 0.3)
    ranges[[0, 1, 8, 9]] = 0.01
    assert printed(robot, reading(robot, q, ranges), 1.0).act(reading(robot, q, ranges)).set_points[0, 0] == 0.02


def test_eq_3_19_only_a_beam_beyond_0_3_m_is_open() -> None:
    robot = robot_for(load_robot("basic"), "thesis")
    q, ranges = np.array([0.05, 0.0, 0.0, 0.1]), np.full(10, 0.3)
    locator = printed(robot, reading(robot, q, ranges), 1.0)
    shut = locator.act(reading(robot, q, ranges))
    assert not shut.done[0]
    assert shut.beam[0] == -1
    assert np.isnan(shut.target).all()
    ranges[7] = 0.305
    open_ = locator.act(reading(robot, q, ranges))
    assert open_.done[0]
    assert open_.beam[0] == 7
    assert open_.target[0] == pytest.approx(point_on_beam(robot, q[None], np.array([7]), 0.2)[0])
    assert open_.set_points[0] == pytest.approx(q)  # it stays


def test_the_printed_method_takes_a_straight_pipe_ahead_for_an_open_space() -> None:
    robot, pipe, base = robot_for(load_robot("basic"), "thesis"), PipeCorner.of(120, 90), -0.9
    tip = np.array([[base + robot.length, 0.0]])
    ranges = laser.measure(robot.laser, laser.cast(tip, robot.laser.angles[None], pipe.segments[None]))[0]
    first = reading(robot, np.zeros(4), ranges)
    decision = printed(robot, first, 1.0).act(first)
    assert decision.done[0]
    target = decision.target[0] + [base, 0.0]
    assert pipe.contains(target)
    assert not inside_second_leg(pipe, target)
