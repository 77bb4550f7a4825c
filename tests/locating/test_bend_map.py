"""A bend is known from beams that were cast in it, whatever its width, radius and turn."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.locating.bend_map import bend_estimate
from pipenav.locating.corner_estimate import CornerEstimate
from pipenav.locating.corner_map import CornerMap
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import laser
from pipenav.robots.bend_reach import Bends, reach_along
from pipenav.robots.robot import RobotSpec, load_robot

DEPTH, TOLERANCE, SPREAD = 0.1, 0.01, 0.015
ONE = np.arange(1)


def approach(
    robot: RobotSpec, pipe: PipeCorner, tips: list[float], wrong: frozenset[int] = frozenset()
) -> CornerEstimate:
    """The estimate after a scan at each tip on the axis, x from where the bend starts [m]; the tip began 0.1 m before.

    Args:
        robot: the robot.
        pipe: a left bend.
        tips: where scans are taken.
        wrong: numbers of the beams, over all scans, that read the laser's minimum.
    """
    map, lidar = CornerMap(robot.laser, 1, TOLERANCE), robot.laser
    map.forget(ONE, np.zeros(1, bool))
    for number, tip in enumerate(tips):
        at = np.array([[tip - pipe.inner_edge, 0.0]])
        read = laser.measure(lidar, laser.cast(at, lidar.angles[None], pipe.segments[None]))
        lost = [i for i in range(lidar.beams) if number * lidar.beams + i in wrong]
        read[0, lost] = lidar.range_min
        own = np.array([[tip + 0.1 + robot.length, 0.0]])
        map.add(ONE, own, lidar.angles[None], read)
    return bend_estimate(robot, map.rays(ONE), DEPTH, TOLERANCE, np.array([SPREAD]), np.zeros(1, bool))


def bends_of(pipe: PipeCorner) -> Bends:
    return Bends(*np.array([[pipe.radius], [pipe.bend_radius], [math.pi - pipe.angle]]))


def wanted_along(robot: RobotSpec, pipe: PipeCorner) -> Floats:
    """Distance along the centre line of the target that is wanted, (1,) [m]."""
    reach = reach_along(robot, bends_of(pipe), np.array([-0.1 - robot.length]))
    return np.asarray(np.minimum(bends_of(pipe).end + DEPTH, reach))


def wanted(robot: RobotSpec, pipe: PipeCorner) -> Floats:
    """The target that is wanted, from where the bend starts, (2,) [m]."""
    return np.asarray(bends_of(pipe).points(wanted_along(robot, pipe), np.zeros(1))[0])


def clear_way(pipe: PipeCorner) -> list[float]:
    """Tips every 20 mm, from 0.1 m before the bend to 60 mm from its outer wall."""
    outer, turning = pipe.bend_radius + pipe.radius, pipe.bend_radius
    last = min(math.sqrt(outer**2 - turning**2), pipe.inner_edge + pipe.radius) - 0.06
    return np.arange(-0.1, max(last, -0.02), 0.02).tolist()


bends = st.builds(
    lambda d, angle, times: PipeCorner.of(d, angle, "left", times * d),
    st.floats(70, 120),
    st.floats(80, 145),
    st.floats(0.75, 4),
)


@pytest.mark.parametrize("name", ["basic", "high-fidelity"])
@settings(max_examples=25, deadline=None)
@given(pipe=bends)
def test_what_is_sure_is_right(name: str, pipe: PipeCorner) -> None:
    robot = load_robot(name)
    found = approach(robot, pipe, clear_way(pipe))
    own = found.target[0] - [0.1 + robot.length, 0.0]
    if found.spread[0] <= SPREAD and found.agreement[0] >= 0.4:
        along = bends_of(pipe).distance(own[None])
        beside = own - bends_of(pipe).points(along, np.zeros(1))[0]
        assert np.linalg.norm(beside) < 0.03  # well inside the pipe
        assert along == pytest.approx(wanted_along(robot, pipe), abs=0.07)


def test_in_most_bends_the_target_is_sure_and_near_what_is_wanted() -> None:
    rng, robot = np.random.default_rng(1), load_robot("basic")
    numbers = rng.uniform((70, 85, 1), (120, 140, 3), (40, 3))
    pipes = [PipeCorner.of(d, angle, "left", times * d) for d, angle, times in numbers]
    found = [approach(robot, pipe, clear_way(pipe)) for pipe in pipes]
    off = [
        np.linalg.norm(each.target[0] - [0.1 + robot.length, 0.0] - wanted(robot, pipe))
        for each, pipe in zip(found, pipes, strict=True)
    ]
    assert np.median(off) < 0.01
    assert max(off) < 0.03
    assert np.mean([each.spread[0] <= SPREAD for each in found]) > 0.7


def test_nothing_is_sure_before_the_bend_is_seen() -> None:
    robot = load_robot("basic")
    found = approach(robot, PipeCorner.of(100, 90, "left", 150, leg_mm=2000), [-1.0, -0.98, -0.96])
    assert not found.spread[0] <= SPREAD


@settings(max_examples=15, deadline=None)
@given(wrong=st.frozensets(st.integers(0, 79), max_size=6))
def test_the_vote_outlives_beams_that_read_the_minimum(wrong: frozenset[int]) -> None:
    robot, pipe = load_robot("basic"), PipeCorner.of(100, 90, "left", 150)
    found = approach(robot, pipe, clear_way(pipe), wrong)
    assert found.target[0] - [0.1 + robot.length, 0.0] == pytest.approx(wanted(robot, pipe), abs=0.02)
