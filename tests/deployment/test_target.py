"""A target is accepted where the arm's tip can come to, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pipenav.deployment.target import ROUNDING, parse_target, require_reachable
from pipenav.errors import PipenavError
from pipenav.robots import kinematics
from pipenav.robots.robot import load_robot

ROBOT = load_robot("real-setup")
LIMITS = np.array([[joint.lower, joint.upper] for joint in ROBOT.joints])


@example(slide=0.343, hinges=[0.328125, 0.0, 0.0])  # stretched, at the end of its slide
@given(st.floats(*LIMITS[0]), st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3))
def test_every_place_of_the_tip_in_a_pipe_is_accepted(slide: float, hinges: list[float]) -> None:
    tip = kinematics.forward(ROBOT, np.array([[slide, *hinges]])).tip[0]
    require_reachable(ROBOT, tip, LIMITS)


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_what_is_farther_than_the_stretched_arm_is_refused(x: float, y: float) -> None:
    hinged = ROBOT.lengths[1:].sum()
    off = np.hypot(x - np.clip(x, *(ROBOT.lengths[0] + LIMITS[0])), y)
    if off <= hinged + ROUNDING:
        return
    with pytest.raises(PipenavError, match="out of the arm's reach"):
        require_reachable(ROBOT, np.array([x, y]), LIMITS)


@pytest.mark.parametrize(
    ("text", "hint"), [("10000,0", False), ("0.42,0.08", True), ("-300,0", False), ("420,900", False)]
)
def test_a_target_in_another_unit_or_place_is_refused(text: str, hint: bool) -> None:
    with pytest.raises(PipenavError, match=f"target {text} mm is out of the arm's reach") as refused:
        require_reachable(ROBOT, parse_target(text), LIMITS)
    assert ("is it in metres?" in str(refused.value)) == hint


def test_an_arm_with_a_shorter_slide_reaches_less() -> None:
    target = np.array([0.72, 0.0])
    require_reachable(ROBOT, target, LIMITS)
    shorter = LIMITS.copy()
    shorter[0, 1] = 0.1
    with pytest.raises(PipenavError, match="out of the arm's reach"):
        require_reachable(ROBOT, target, shorter)


@pytest.mark.parametrize("text", ["somewhere", "1", "1,2,3", "nan,1", "1,inf", ""])
def test_what_is_no_pair_of_numbers_is_refused(text: str) -> None:
    with pytest.raises(PipenavError, match=r"is not X,Y: give two numbers in mm"):
        parse_target(text)
