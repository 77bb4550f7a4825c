"""The robot's outline."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.kinematics import forward
from pipenav.outline import foremost, link_outlines
from pipenav.robot import load_robot

ROBOT = load_robot("basic")


@given(st.integers(0, 2**32))
def test_outlines_keep_their_size_and_hold_their_joints(seed: int) -> None:
    q = np.random.default_rng(seed).uniform(ROBOT.lower, ROBOT.upper, (5, 4))
    pose, outlines = forward(ROBOT, q), link_outlines(ROBOT, q)
    pose_ends = np.concatenate([pose.joints[:, 1:], pose.tip[:, None]], axis=1)
    assert len(outlines) == len(ROBOT.links)
    for i, (link, (polygon,)) in enumerate(zip(ROBOT.links, outlines, strict=True)):
        sides = np.linalg.norm(np.roll(polygon, -1, axis=1) - polygon, axis=2)
        assert np.sort(sides) == pytest.approx(np.tile(np.sort([link.width, link.length] * 2), (5, 1)))
        assert polygon.mean(axis=1) == pytest.approx((pose.joints[:, i] + pose_ends[:, i]) / 2)


def test_the_foremost_point_of_a_straight_robot_is_its_tip() -> None:
    q = np.array([[0.0, 0, 0, 0], [0.1, 0, 0, 0]])
    assert foremost(ROBOT, q) == pytest.approx([ROBOT.length, ROBOT.length + 0.1])


def test_the_foremost_point_of_a_robot_that_looks_back_is_a_bent_link() -> None:
    q = np.array([[0.0, 0.0, 1.5, 1.5]])
    assert foremost(ROBOT, q)[0] > forward(ROBOT, q).tip[0, 0] + 0.1
