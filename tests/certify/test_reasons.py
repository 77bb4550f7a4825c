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


@pytest.mark.parametrize("diameter", [45, 110])
def test_a_narrow_pipe_is_soon_known_to_be_too_narrow_and_a_wide_one_never(diameter: float) -> None:
    model = Model(load_robot("basic"), PipeCorner.of(diameter, 60), "round")
    assert _too_narrow(model, Ends.of_task(model, ReachConfig())) == (diameter == 45)
    verdict = certify(model, None, math.radians(0.5))
    assert verdict.kind == ("impossible" if diameter == 45 else "passable")
    assert verdict.reason.startswith("width" if diameter == 45 else "a motion")


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
