"""A round bore that is smaller than a part is high: nothing fits, which is a proof and no fault."""

from __future__ import annotations

import math

import pytest

from pipenav.certify.model import Model
from pipenav.certify.verdict import certify
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import load_robot


@pytest.mark.parametrize("diameter", [42.0, 45.9, 46.1])
@pytest.mark.parametrize("bend_mm", [0.0, 100.0])
def test_a_round_bore_lower_than_a_part_is_impossible(diameter: float, bend_mm: float) -> None:
    robot = load_robot("real-setup")  # its brackets are 46 mm high
    pipe = PipeCorner.of(diameter, 120, bend_radius_mm=bend_mm)
    assert certify(Model(robot, pipe, "round"), None, math.radians(0.25)).kind == "impossible"
