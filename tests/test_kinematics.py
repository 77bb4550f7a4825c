"""Forward kinematics against complex numbers."""

from __future__ import annotations

import cmath

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipenav.kinematics import forward
from pipenav.robot import load_robot

ROBOT = load_robot("basic")
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
