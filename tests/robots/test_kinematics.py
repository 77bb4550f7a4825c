"""Forward kinematics against complex numbers."""

from __future__ import annotations

import cmath

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipenav.robots.kinematics import configuration, forward
from pipenav.robots.robot import load_robot

ROBOT, WHOLE = load_robot("basic"), load_robot("pirate")
poses = arrays(float, (3, 4), elements=st.floats(-3, 3))


@settings(max_examples=40)
@given(poses)
def test_the_chain_is_a_sum_of_phasors(q) -> None:  # type: ignore[no-untyped-def]
    pose = forward(ROBOT, q)
    for i, (slide, *hinges) in enumerate(q):
        lengths = [link.length for link in ROBOT.links]
        headings = [0.0, *np.cumsum(hinges)]
        ends = slide + np.cumsum([length * cmath.exp(1j * h) for length, h in zip(lengths, headings, strict=True)])
        starts = [slide, *ends[:-1]]
        assert pose.joints[i] @ [1, 1j] == pytest.approx(np.array(starts))
        assert pose.tip[i] @ [1, 1j] == pytest.approx(ends[-1])
        assert pose.headings[i] == pytest.approx(headings)


@settings(max_examples=40)
@given(poses)
def test_robots_do_not_touch_each_others_poses(q) -> None:  # type: ignore[no-untyped-def]
    together = forward(ROBOT, q)
    for i in range(len(q)):
        for one, all_of_them in zip(forward(ROBOT, q[i : i + 1]), together, strict=True):
            assert one[0] == pytest.approx(all_of_them[i], abs=1e-15)


def test_straight_it_is_as_long_as_its_links() -> None:
    assert forward(ROBOT, np.zeros((1, 4))).tip[0] == pytest.approx([ROBOT.length, 0.0])


@settings(max_examples=40)
@given(arrays(float, (3, 9), elements=st.floats(-3, 3)))
def test_a_free_chain_is_a_mounted_one_moved_and_turned(q) -> None:  # type: ignore[no-untyped-def]
    moved, lying = forward(WHOLE, q), forward(WHOLE, q * ([0.0] * 3 + [1.0] * 6))
    for i, (x, y, heading) in enumerate(q[:, :3]):
        turn = cmath.exp(1j * heading)
        assert moved.joints[i] @ [1, 1j] == pytest.approx(complex(x, y) + turn * (lying.joints[i] @ [1, 1j]))
        assert moved.tip[i] @ [1, 1j] == pytest.approx(complex(x, y) + turn * (lying.tip[i] @ [1, 1j]))
        assert moved.headings[i] == pytest.approx(heading + lying.headings[i])


@settings(max_examples=40)
@given(arrays(float, (3, 9), elements=st.floats(-3, 3)))
def test_a_configuration_follows_from_joints_and_tip(q) -> None:  # type: ignore[no-untyped-def]
    pose = forward(WHOLE, q)
    tip = np.concatenate([pose.tip, pose.headings[:, -1:]], axis=1)
    assert configuration(WHOLE, q[:, 3:], tip) == pytest.approx(q, abs=1e-12)


def test_that_of_a_mounted_chain_is_its_joints() -> None:
    q = np.array([[0.1, 0.2, -0.3, 0.4]])
    assert configuration(ROBOT, q, np.zeros((1, 3))).tolist() == q.tolist()
