"""Starts and targets of an arm: proofs are about all that the task draws, and tips within their tolerance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.certify.arm import ArmSpans, Ends
from pipenav.certify.model import Model
from pipenav.certify.verdict import certify
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import load_robot
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import sample

ARMS = ("basic", "real-setup", "high-fidelity")


def in_second_leg(turn: float, points: Floats) -> Floats:
    """Distances along the second leg and to its left."""
    cos, sin = math.cos(turn), math.sin(turn)
    return np.asarray(np.stack([points @ [cos, sin], points @ [-sin, cos]], axis=-1))


@settings(deadline=None, max_examples=12)
@given(st.sampled_from(ARMS), st.floats(55, 130), st.floats(40, 140), st.sampled_from([0.0, 0.7, 1.0, 1.5, 3.0]))
def test_every_drawn_target_and_start_is_among_those_of_a_proof(name: str, d: float, angle: float, bend: float) -> None:
    model, config = Model(load_robot(name), PipeCorner.of(d, angle, bend_radius_mm=bend * d)), ReachConfig()
    ends = Ends.of_task(model, config)
    drawn = sample(model.robot, config, [model.pipe] * 100, np.random.default_rng(1))
    at = in_second_leg(model.turn, drawn.target + np.stack([drawn.base, np.zeros(100)], axis=1))
    for which, (low, high) in enumerate((ends.along, ends.left)):
        assert low - 1e-9 <= at[:, which].min() and at[:, which].max() <= high + 1e-9
    assert ends.start_slide[0] - 1e-9 <= drawn.base.min() and drawn.base.max() <= ends.start_slide[1] + 1e-9
    for aimed in (ends, *ends.further):
        assert ends.along[0] - 1e-9 <= aimed.aim_along[0] <= aimed.aim_along[1] <= ends.along[1] + 1e-9
        assert ends.left[0] - 1e-9 <= aimed.aim_left[0] <= aimed.aim_left[1] <= ends.left[1] + 1e-9
        assert ends.start_slide[0] - 1e-9 <= aimed.base <= ends.start_slide[1] + 1e-9


@settings(deadline=None, max_examples=20)
@given(
    st.floats(40, 140),
    st.tuples(st.floats(-0.03, 0.03), st.floats(-0.03, 0.03)),
    st.tuples(st.floats(0, 0.04), st.floats(0, 0.03)),
    st.floats(0.001, 0.03),
    st.integers(0, 9),
)
def test_slides_to_a_target_are_those_at_which_the_tip_is_within_the_tolerance(
    angle: float, corner: tuple[float, float], size: tuple[float, float], tolerance: float, seed: int
) -> None:
    """Against distances to the rectangle of targets, over slides 0.1 mm apart."""
    model = Model(load_robot("basic"), PipeCorner.of(80, angle))
    along, left = ((corner[i], corner[i] + size[i]) for i in (0, 1))
    ends = Ends.of_task(model, ReachConfig())._replace(aim_along=along, aim_left=left, tolerance=tolerance)
    headings = np.random.default_rng(seed).uniform(-0.5, 2.5, (20, 3))
    found = ArmSpans(model, ends, 0.0).target_slides(headings)
    lengths = np.array(model.robot.lengths)
    reach = np.cos(headings) @ lengths[1:] + lengths[0], np.sin(headings) @ lengths[1:]
    slides = np.arange(-0.6, 0.6, 1e-4)
    for x, y, low, high in zip(*reach, *found, strict=True):
        at = in_second_leg(model.turn, np.stack([x + slides, np.full(len(slides), y)], axis=1))
        away = np.hypot(*(at - np.clip(at, [along[0], left[0]], [along[1], left[1]])).T)
        inside = (slides >= low) & (slides <= high)
        assert (away[inside] <= tolerance + 1e-9).all()
        assert (away[~inside] >= 0.99 * tolerance - 1e-9).all()


@pytest.mark.parametrize("name", ARMS)
def test_a_bend_that_one_target_of_the_task_needs_is_passable_by_that_one(name: str) -> None:
    """The verdict names the episode whose target the motion reaches, which a certificate of it takes up."""
    model = Model(load_robot(name), PipeCorner.of(64, 60, bend_radius_mm=96))
    found = certify(model, None, math.radians(0.25))
    assert found.kind == "passable" and found.ends is not None and found.base == found.ends.base
    assert found.motion is not None
    again = certify(model, found.ends._replace(further=()), math.radians(0.25))
    assert again.kind == "passable"
