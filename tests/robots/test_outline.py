"""The robot's outline."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.wall_distance import wall_distance
from pipenav.robots.kinematics import forward
from pipenav.robots.outline import foremost, link_outlines
from pipenav.robots.robot import load_robot
from pipenav.robots.variants import robot_names

BASIC = load_robot("basic")
ARMS = [name for name in robot_names() if not load_robot(name).free]


@given(st.integers(0, 2**32), st.sampled_from(robot_names()))
def test_parts_keep_their_size_and_their_position_on_the_link(seed: int, name: str) -> None:
    robot = load_robot(name)
    q = np.random.default_rng(seed).uniform(-2.0, 2.0, (5, robot.coordinates))
    pose, outlines = forward(robot, q), link_outlines(robot, q)
    along = np.stack([np.cos(pose.headings), np.sin(pose.headings)], axis=-1)
    for i, (link, polygons) in enumerate(zip(robot.links, outlines, strict=True)):
        for part, polygon in zip(link.outline, polygons, strict=True):
            across = np.array([-along[0, i, 1], along[0, i, 0]])
            assert np.ptp(polygon[0] @ across) == pytest.approx(part.width)
            middle = pose.joints[0, i] + part.x * along[0, i] + part.y * across
            assert polygon[0].mean(axis=0) == pytest.approx(middle)


@given(st.integers(0, 2**32), st.sampled_from(ARMS))
def test_outlines_are_as_far_from_a_straight_pipes_walls_as_the_robot(seed: int, name: str) -> None:
    robot, pipe = load_robot(name), PipeCorner.of(300, 180, leg_mm=20000)
    q = np.random.default_rng(seed).uniform(-0.3, 0.3, (5, len(robot.joints)))
    points = np.concatenate([polygon for link in link_outlines(robot, q) for polygon in link], axis=1)
    room = pipe.radius - np.abs(points[..., 1]).max(axis=1)
    assert room == pytest.approx(wall_distance(robot, pipe, q, 0.0), abs=1e-4)


@pytest.mark.parametrize("name", robot_names())
def test_the_foremost_point_of_a_straight_robot_is_its_tip(name: str) -> None:
    robot = load_robot(name)
    q = np.zeros((2, robot.coordinates))
    q[1, 0] = 0.1
    assert foremost(robot, q) == pytest.approx([robot.length, robot.length + 0.1], abs=0.011)


def test_the_foremost_point_of_a_robot_that_looks_back_is_a_bent_link() -> None:
    q = np.array([[0.0, 0.0, 1.5, 1.5]])
    assert foremost(BASIC, q)[0] > forward(BASIC, q).tip[0, 0] + 0.1
