"""Pictures of what cannot be passed: every kind of proof has one."""

from __future__ import annotations

import json
import math

import pytest
from matplotlib.text import Text

from pipenav.certify.arm import Ends
from pipenav.certify.certificate import Certified
from pipenav.certify.figure import impossible_figure
from pipenav.certify.model import Model
from pipenav.certify.verdict import certify
from pipenav.drawing.style import png
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import RobotSpec, load_robot
from pipenav.tasks.reach.config import ReachConfig

RESOLUTION = math.radians(0.25)


def words(name: str, pipe: PipeCorner) -> str:
    """All that a picture says, in one line."""
    model = Model(load_robot(name), pipe)
    ends = None if model.robot.free else Ends.of_task(model, ReachConfig())
    figure = impossible_figure(Certified(model, ends, RESOLUTION, certify(model, ends, RESOLUTION)))
    assert figure is not None
    assert png(figure)[:4] == b"\x89PNG"
    return " ".join(text.get_text() for text in figure.findobj(Text))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "pipe", "says"),
    [
        ("pirate", PipeCorner.of(60, 60), "lacks"),
        ("pirate", PipeCorner.of(44, 60, bend_radius_mm=66), "overlaps here by"),
        ("pirate", PipeCorner.of(64, 40), "overlaps here by"),
        ("basic", PipeCorner.of(56, 60, "right"), "overlaps here by"),
        ("high-fidelity", PipeCorner.of(46, 60, bend_radius_mm=69), "overlaps here by"),
    ],
)
def test_a_pipe_that_is_too_narrow_shows_where(name: str, pipe: PipeCorner, says: str) -> None:
    text = words(name, pipe)
    assert says in text and "impossible" in text
    assert " 0.0 mm" not in text


@pytest.mark.slow
def test_a_slide_that_is_too_short_shows_how_far_it_would_have_to_go() -> None:
    description = load_robot("basic").model_dump(mode="json")
    slide = next(link["joint"] for link in description["links"] if link["joint"] and link["joint"]["type"] == "slide")
    slide["upper"] = 0.1
    model = Model(RobotSpec.model_validate_json(json.dumps(description)), PipeCorner.of(100, 90))
    ends = Ends.of_task(model, ReachConfig())
    verdict = certify(model, ends, RESOLUTION)
    assert verdict.kind == "impossible" and verdict.reason.startswith("reach")
    figure = impossible_figure(Certified(model, ends, RESOLUTION, verdict))
    assert figure is not None
    assert any("its limit is 0.10" in text.get_text() for text in figure.findobj(Text))


def test_what_is_not_impossible_has_no_such_picture() -> None:
    model = Model(load_robot("pirate"), PipeCorner.of(90, 90))
    assert impossible_figure(Certified(model, None, RESOLUTION, certify(model, None, RESOLUTION))) is None
