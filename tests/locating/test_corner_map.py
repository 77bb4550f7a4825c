"""The map knows a corner from beams that were cast in it, and says nothing before it has seen one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.locating.corner_estimate import CornerEstimate
from pipenav.locating.corner_map import CornerMap
from pipenav.locating.second_leg import HEADINGS, wall_votes
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import laser
from pipenav.robots.parts import Laser
from pipenav.robots.robot import load_robot

DEPTH = 0.1
TOLERANCE = 0.01
ROBOTS = ("basic", "high-fidelity", "real-setup")
ONE = np.arange(1)
ALONE = np.zeros(1, bool)
"""Flags of a corner that has no exit straight on."""


def scan(map: CornerMap, lidar: Laser, pipe: PipeCorner, before: float, robot: int = 0, heading: float = 0.0) -> None:
    """A scan from near the axis, so far before the inner edge of a left turn [m]."""
    tip = np.array([[-pipe.inner_edge - before, 0.002]])
    beams = lidar.angles[None] + heading
    read = laser.measure(lidar, laser.cast(tip, beams, pipe.segments[None]))
    map.add(np.array([robot]), tip, beams, read)


def approach(lidar: Laser, pipe: PipeCorner, first: float = 0.15, last: float = 0.01) -> CornerEstimate:
    """The map after scans every 20 mm."""
    map = CornerMap(lidar, 1, TOLERANCE)
    for before in np.arange(first, last, -0.02):
        scan(map, lidar, pipe, before)
    return map.corner(ONE, DEPTH, ALONE)


@pytest.mark.parametrize("robot", ROBOTS)
@settings(max_examples=15, deadline=None)
@given(d=st.floats(70, 120), angle=st.floats(55, 125))
def test_a_corner_is_recovered_from_its_beams(robot: str, d: float, angle: float) -> None:
    pipe = PipeCorner.of(d, angle)
    corner = approach(load_robot(robot).laser, pipe)
    assert corner.radius[0] == pytest.approx(pipe.radius, abs=0.012)
    assert corner.edge[0] == pytest.approx(-pipe.inner_edge, abs=0.015)
    assert corner.heading[0] == pytest.approx(math.pi - pipe.angle, abs=math.radians(18))
    assert corner.target[0] == pytest.approx((pipe.inner_edge + DEPTH) * pipe.second_leg, abs=0.04)


@pytest.mark.parametrize("robot", ROBOTS)
def test_most_corners_are_known_within_the_lasers_resolution(robot: str) -> None:
    rng, lidar = np.random.default_rng(1), load_robot(robot).laser
    pipes = [PipeCorner.of(d, angle) for d, angle in rng.uniform((70, 55), (120, 125), (60, 2))]
    corners = [approach(lidar, pipe) for pipe in pipes]
    aims = [(pipe.inner_edge + DEPTH) * pipe.second_leg for pipe in pipes]
    off = [np.linalg.norm(corner.target[0] - aim) for corner, aim in zip(corners, aims, strict=True)]
    assert np.median(off) < lidar.resolution
    assert np.mean([corner.spread[0] < 0.015 and corner.agreement[0] > 0.5 for corner in corners]) > 0.95


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize(("d", "angle"), [(70, 125), (90, 60), (120, 90)])
def test_nothing_is_known_before_the_second_leg_is_seen(robot: str, d: float, angle: float) -> None:
    corner = approach(load_robot(robot).laser, PipeCorner.of(d, angle, leg_mm=1500), first=1.2, last=1.0)
    assert np.isnan(corner.target).all()
    assert np.isinf(corner.spread).all()
    assert corner.votes[0] == 0


def test_one_beam_on_the_second_leg_leaves_many_corners_possible() -> None:
    lidar, pipe = load_robot("basic").laser, PipeCorner.of(70, 120)
    few, many = (approach(lidar, pipe, first=0.45, last=last) for last in (0.18, 0.05))
    assert few.spread[0] > 0.05 > many.spread[0]
    assert few.votes[0] < 4 < many.votes[0]


def test_robots_are_told_apart_and_forgotten_one_by_one() -> None:
    lidar = load_robot("basic").laser
    pipes = [PipeCorner.of(90, 60), PipeCorner.of(110, 100), PipeCorner.of(120, 90)]
    map = CornerMap(lidar, len(pipes), TOLERANCE)
    for before in np.arange(0.15, 0.01, -0.02):
        for robot, pipe in enumerate(pipes):
            scan(map, lidar, pipe, before, robot)
    together = map.corner(np.arange(3), DEPTH, np.zeros(3, bool))
    for robot, pipe in enumerate(pipes):
        np.testing.assert_array_equal(together.target[robot], approach(lidar, pipe).target[0])
    map.forget(np.array([1]), np.zeros(1, bool))
    left = map.corner(np.arange(3), DEPTH, np.zeros(3, bool))
    assert np.isnan(left.target[1]).all()
    np.testing.assert_array_equal(left.target[[0, 2]], together.target[[0, 2]])


def test_new_scans_replace_the_oldest() -> None:
    lidar, pipe, other = load_robot("basic").laser, PipeCorner.of(90, 60), PipeCorner.of(120, 120)
    map = CornerMap(lidar, 1, TOLERANCE)
    for before in np.linspace(0.15, 0.05, 32):
        scan(map, lidar, other, before)
    for before in np.linspace(0.15, 0.05, 32):
        scan(map, lidar, pipe, before)
    target = map.corner(ONE, DEPTH, ALONE).target[0]
    assert target == pytest.approx((pipe.inner_edge + DEPTH) * pipe.second_leg, abs=0.01)


@settings(max_examples=15, deadline=None)
@given(wrong=st.lists(st.tuples(st.integers(0, 6), st.integers(0, 9)), max_size=4, unique=True))
def test_the_vote_outlives_beams_that_read_the_minimum(wrong: list[tuple[int, int]]) -> None:
    lidar, pipe = load_robot("basic").laser, PipeCorner.of(100, 80)
    map = CornerMap(lidar, 1, TOLERANCE)
    for number, before in enumerate(np.arange(0.15, 0.01, -0.02)):
        tip, beams = np.array([[-pipe.inner_edge - before, 0.0]]), lidar.angles[None]
        read = laser.measure(lidar, laser.cast(tip, beams, pipe.segments[None]))
        for at, beam in wrong:
            if at == number:
                read[0, beam] = lidar.range_min
        map.add(ONE, tip, beams, read)
    target = map.corner(ONE, DEPTH, ALONE).target[0]
    assert target == pytest.approx((pipe.inner_edge + DEPTH) * pipe.second_leg, abs=0.02)


@given(seed=st.integers(0, 2**32 - 1))
def test_votes_are_to_the_bit_those_of_every_beam_for_every_wall(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wall = np.sort(rng.uniform(0.0, 0.3, (3, 9, len(HEADINGS))), axis=1)
    across = rng.uniform(-0.2, 0.5, (30, len(HEADINGS)))
    across[::2] = wall[0, rng.integers(9)] + TOLERANCE * rng.integers(-1, 2, (15, 1))  # at the edge of agreeing
    asked = rng.random((3, 30)) < 0.7
    votes, beyond = wall_votes(across, asked, wall, TOLERANCE)
    for i, beams in enumerate(asked):
        off = (across[beams, None] - wall[i]) / TOLERANCE
        assert np.array_equal(votes[i], np.maximum(1.0 - off * off, 0.0).sum(axis=0))
        assert np.array_equal(beyond[i], (off > 1.0).sum(axis=0))
