"""Reasons why an arm cannot pass: the walls alone, or the limits of a joint; and motions that end off every target."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.certify.arm import ArmSpans, Ends
from pipenav.certify.arm_path import _motion
from pipenav.certify.model import Model
from pipenav.certify.verdict import MARGIN, _too_narrow, certify, freed_joint, passable
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import load_robot
from pipenav.tasks.reach.config import ReachConfig

ARMS = ("basic", "real-setup", "high-fidelity")


@pytest.mark.slow
@settings(deadline=None, max_examples=12)
@given(st.sampled_from(ARMS), st.floats(40, 75), st.floats(40, 140), st.sampled_from([0.0, 1.5]), st.booleans())
def test_where_the_walls_alone_are_the_reason_no_joint_is(
    name: str, d: float, angle: float, bend: float, round_: bool
) -> None:
    model = Model(load_robot(name), PipeCorner.of(d, angle, bend_radius_mm=bend * d), "round" if round_ else "plane")
    ends = Ends.of_task(model, ReachConfig())
    if _too_narrow(model, ends):
        joints = range(len(model.robot.joints))
        assert all(passable(model._replace(freed=(joint,)), ends) is None for joint in joints)
        assert freed_joint(model, ends) is None


def test_narrow_pipes_are_soon_told_from_those_that_a_limit_closes() -> None:
    """The walls close 45 mm to the arm; its slide is too short for 110 mm and 140 deg, which would be wide enough."""
    narrow = Model(load_robot("basic"), PipeCorner.of(45, 60), "round")
    assert _too_narrow(narrow, Ends.of_task(narrow, ReachConfig()))
    assert certify(narrow, None, math.radians(0.5)).reason.startswith("width")


@pytest.mark.parametrize("name", ARMS)
def test_a_way_that_ends_off_every_target_is_no_motion_and_no_warning(name: str) -> None:
    model = Model(load_robot(name), PipeCorner.of(110, 90))
    spans = ArmSpans(model, Ends.of_task(model, ReachConfig()), MARGIN)
    straight = np.zeros((1, spans.axes))  # in the first leg
    at = spans.target_slides(straight)
    assert at.low[0] == np.inf and at.high[0] == -np.inf
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert _motion(spans, straight) is None
