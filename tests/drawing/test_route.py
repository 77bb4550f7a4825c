"""Drawings of routes say every dimension, and show the pipe from where it can be seen."""

from __future__ import annotations

import math

import matplotlib.text
import numpy as np
import pytest
from matplotlib.figure import Figure

from pipenav.drawing.projection import AZIMUTHS, View
from pipenav.drawing.route import LABELLED, route_figure
from pipenav.pipes.pipe_system import system_of
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_routes

ROLLED = PipeRoute.of(100, [(90, "left", 0), (75, "right", 90), (110, "left", 180)], [810, 520, 430, 640])


def texts(figure: Figure) -> list[str]:
    figure.draw_without_rendering()
    return [text.get_text() for text in figure.findobj(matplotlib.text.Text)]


def test_a_plan_says_every_length_and_angle() -> None:
    route = PipeRoute.of(100, [(90, "left", 0), (75, "right", 0), (112.5, "left", 180)], [810, 520, 430, 640])
    said = texts(route_figure(route, "mine"))
    for text in ("810", "520", "430", "640", "90° left", "75° right", "112.5° left\nrolled 180°", "1", "2", "3"):
        assert text in said
    assert "mine: 3 corners, ⌀ 100 mm, wall 3 mm" in said


def test_a_picture_in_space_says_every_length_twice_and_its_schedule_every_corner() -> None:
    said = texts(route_figure(ROLLED, "mine"))
    for text in ("810", "520", "430", "640", "1", "2", "3"):
        assert said.count(text) >= 2
    for text in ("90° left", "75° right\nrolled 90°", "110° left\nrolled 180°", "x", "y", "z"):
        assert text in said


@pytest.mark.slow
@pytest.mark.parametrize("roll", [0, 90])
def test_a_long_route_keeps_its_lengths_to_the_schedule(roll: int) -> None:
    count = LABELLED + 2
    route = PipeRoute.of(
        60, [(135, "left", 0), (135, "right", roll)] * (count // 2), [601 + i for i in range(count + 1)]
    )
    said = texts(route_figure(route, "mine"))
    assert all(said.count(str(601 + i)) == 1 for i in range(count + 1))
    assert said.count("135° left") == count // 2


def test_the_dials_point_to_where_the_pipe_bends() -> None:
    """Left of a robot that looks ahead is left in the dial, up is up."""
    schedule = route_figure(ROLLED, "mine").axes[-1]
    arrows = [note for note in schedule.texts if note.get_text() == "" and note.arrow_patch is not None]
    directions = np.array([np.subtract(note.xy, note.xyann) for note in arrows])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    # To the left; rolled by 90 deg a right turn goes down; rolled by 180 deg more, a left one goes down too.
    np.testing.assert_allclose(directions, [[-1, 0], [0, -1], [0, -1]], atol=1e-9)
    first, second = ROLLED.centre_line[2] - ROLLED.centre_line[1], ROLLED.frames.rotation[2][:, 0]
    assert first[1] > 0 and second[2] < 0


@pytest.mark.parametrize("azimuth", [0.0, 1.0, 4.0])
def test_views_are_right_handed(azimuth: float) -> None:
    view = View.towards(azimuth)
    np.testing.assert_allclose(np.cross(view.right, view.up), view.to_viewer, atol=1e-12)
    assert view.up[2] > 0 and view.to_viewer[2] > 0


@pytest.mark.parametrize("route", [ROLLED, *parse_routes(["runs-rolled"])[::6]], ids=lambda route: route.name)
def test_the_chosen_view_shows_every_straight(route: PipeRoute) -> None:
    view = View.of(system_of(route))
    assert np.linalg.norm(view.flat(route.legs.axes[:, :, 0]), axis=1).min() > 0.4
    assert view.hidden(system_of(route)) <= np.median(
        [View.towards(azimuth).hidden(system_of(route)) for azimuth in AZIMUTHS]
    )


def test_what_lies_over_each_other_in_a_picture_is_counted() -> None:
    over = [(90, "left", 90), (90, "right", 0), (90, "left", -90), (90, "left", 0), (90, "left", 0)]
    route = PipeRoute.of(100, over, [1000, 300, 400, 400, 800, 1000])
    assert View.from_above().hidden(system_of(route)) >= 1
    assert View.towards(math.pi / 4).hidden(system_of(PipeRoute.of(100, [(90, "left", 90)]))) == 0
