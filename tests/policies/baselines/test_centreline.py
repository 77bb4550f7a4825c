"""The controller that follows the centre line."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.controllers import first_outcomes, reach_batch

from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.centreline import CentrelineController
from pipenav.policies.named import open_controller
from pipenav.robots.robot import load_robot

ROBOT = load_robot("basic")


@pytest.mark.parametrize("turn", ["left", "right"])
@pytest.mark.parametrize(("diameter", "angle", "bend"), [(100, 90, 0), (80, 70, 0), (120, 125, 0), (100, 90, 75)])
def test_centreline_passes(diameter: float, angle: float, bend: float, turn: str) -> None:
    pipe = PipeCorner.of(diameter, angle, turn, bend)
    assert first_outcomes(open_controller("baseline:centreline"), [pipe], 4) == ["reached"] * 4


def test_centreline_does_not_depend_on_the_other_robots() -> None:
    pipes = [PipeCorner.of(90, angle, turn) for angle in (60, 100) for turn in ("left", "right")]
    controller = CentrelineController(ROBOT)
    batch = reach_batch(controller, pipes, 6)
    actions = [controller.act(batch.reset(), batch) for _ in range(2)][1]
    again = CentrelineController(ROBOT)  # it has not seen the episodes before these
    np.testing.assert_array_equal(again.act(np.zeros((6, 1)), batch), actions)
    batch.close()


def test_centreline_needs_a_slide_and_hinges() -> None:
    hinges = ROBOT.model_copy(update={"links": ROBOT.links[1:]})
    with pytest.raises(PipenavError, match="robot 'basic' has hinge, hinge, hinge"):
        CentrelineController(hinges)
