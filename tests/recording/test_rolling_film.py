"""Pictures of a robot in several planes."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.rolling import ROBOT
from matplotlib.figure import Figure

from pipenav.drawing.down import WEIGHTLESS
from pipenav.drawing.projection import CutOpen, View
from pipenav.pipes.pipe_system import system_of
from pipenav.pipes.route import PipeRoute
from pipenav.recording.record_rolling import SpaceRecording
from pipenav.recording.rolling_film import SIDES, _caption, _overview, faces

ROUTE = PipeRoute.of(100, [(110, "left", 90), (95, "right", 90)], [900, 700, 900])


def recording(gravity: float | None) -> SpaceRecording:
    """A straight robot that moves along the first straight."""
    points = np.zeros((9, len(ROBOT.links) + 1, 3))
    points[..., 0] = np.concatenate([[0.0], np.cumsum(ROBOT.lengths)]) - 0.85 + np.linspace(0, 0.3, 9)[:, None]
    normals = np.tile([[0.0, 0, 1], [0, -1, 0]], (9, 1, 1))
    pull = None if gravity is None else np.array([0.0, 0.0, -gravity])
    return SpaceRecording(
        ROUTE, ROBOT, "mine", "mujoco", "reached", points, normals, np.zeros(9), ("rolling",) * 9, gravity=pull
    )


def test_the_overview_holds_the_whole_route_and_the_numbered_poses() -> None:
    pipe = CutOpen.of(system_of(ROUTE), View.of(system_of(ROUTE)))
    axes = Figure().add_subplot()
    _overview(axes, recording(9.81), pipe, 8, np.array([0, 4, 8]))
    assert {text.get_text() for text in axes.texts} >= {"1", "2", "3"}
    route = 1e3 * pipe.view.flat(pipe.polygons).reshape(-1, 2)
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    assert (route >= [left, bottom]).all() and (route <= [right, top]).all()
    assert axes.get_title("left") == "reached after 0.8 s"


@pytest.mark.parametrize("gravity", [None, 0.0, 9.81])
def test_the_caption_says_which_way_is_down_or_that_nothing_weighs(gravity: float | None) -> None:
    view = View.towards(1.0)
    caption = _caption(recording(gravity), 9.6, view)
    assert (WEIGHTLESS in " ".join(caption.details)) == (gravity == 0)
    if gravity:
        np.testing.assert_allclose(caption.down, view.seen(np.array([0.0, 0.0, -1.0])), atol=1e-12)
    else:
        assert caption.down is None


def test_a_robot_is_drawn_in_its_halves_planes() -> None:
    """Every face of a straight robot lies around it at the links' width and height, turned with the half's plane."""
    points = np.zeros((len(ROBOT.links) + 1, 3))
    points[1:, 0] = np.cumsum(ROBOT.lengths)
    links, wheels, half = faces(ROBOT, points, np.array([[0.0, 0, 1], [0, -1, 0]]))
    pieces = len(ROBOT.links) + 1  # the roll joint divides one
    assert links.shape == (6 * pieces, 4, 3) and len(wheels) == len(ROBOT.wheels)
    assert list(half) == [0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1]
    width, height = ROBOT.links[0].width, ROBOT.links[0].height
    sizes = np.ptp(links.reshape(pieces, -1, 3), axis=1)[:, 1:]
    np.testing.assert_allclose(sizes, [[width, height]] * 4 + [[height, width]] * 4)
    for disc, of in zip(wheels, half[pieces:], strict=True):
        assert disc.shape == (SIDES, 3)
        np.testing.assert_allclose(disc[:, 2 if of == 0 else 1], 0.0, atol=1e-12)
