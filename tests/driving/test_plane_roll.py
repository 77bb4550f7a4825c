"""The plane of a robot in a route in space, and what a picture of that plane shows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.driving.plane_roll import WAYS, PlaneRoll, down_words
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import BASE, load_robot
from pipenav.tasks.rolling.manoeuvre import FRONT
from pipenav.tasks.rolling.pilot import TOLERANCE
from pipenav.testing.kinematic_space import KinematicSpace

ROBOT = load_robot("pirate")
ANGLES = st.floats(-math.pi, math.pi)
TURNS = st.sampled_from(["left", "right"])


def route(roll_deg: float, turn: str = "left", slope_deg: float = 0.0) -> PipeRoute:
    corners = [(90, "left", 0), (75, turn, roll_deg)]
    level = PipeRoute.of(90, corners, straights_mm=[1000, 1100, 1000])
    return level.model_copy(update={"slope": math.radians(slope_deg)})


@settings(max_examples=60, deadline=None)
@given(roll=st.sampled_from([0, 45, 90, 135, 180, 270]), turn=TURNS, plane=ANGLES)
def test_a_turn_by_what_is_away_is_the_corners_plane(roll: float, turn: str, plane: float) -> None:
    one = PlaneRoll(ROBOT, route(roll, turn))
    one.plane = plane
    away = one.away(1)
    assert abs(away) <= math.pi / 2 + 1e-9
    assert one.fits(1) == (abs(away) <= TOLERANCE)
    one.plane += away
    assert one.fits(1)
    side = one.turn_sign(1)
    one.plane += math.pi
    assert one.fits(1)
    assert one.turn_sign(1) == -side


@settings(max_examples=40, deadline=None)
@given(roll=st.sampled_from([0, 90, 180, 270]), turn=TURNS, distance=st.floats(0.01, 0.4))
def test_the_straight_behind_a_corner_lies_in_the_picture_where_the_drawing_has_it(
    roll: float, turn: str, distance: float
) -> None:
    drawn = route(roll, turn)
    one = PlaneRoll(ROBOT, drawn)
    one.plane += one.away(1)
    along = drawn.legs.axes[2][:, 0]
    shown = one.projected((drawn.legs.start[2] + distance * along)[None], 1)[0]
    heading = one.turn_sign(1) * (math.pi - drawn.corners[1].angle)
    assert shown == pytest.approx(distance * np.array([math.cos(heading), math.sin(heading)]), abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(plane=ANGLES, slope=st.sampled_from([-90.0, -45.0, 0.0, 30.0]), roll=st.sampled_from([0, 90]))
def test_down_in_the_picture_is_what_the_robot_feels(plane: float, slope: float, roll: float) -> None:
    """A straight robot in the first leg feels its weight where the drawing has down."""
    drawn = route(roll, slope_deg=slope)
    one = PlaneRoll(ROBOT, drawn)
    one.plane = plane
    space = KinematicSpace(ROBOT, 1)
    space.incline(np.arange(1), 9.81 * np.array([drawn.down]))
    q = np.zeros((1, len(BASE) + len(ROBOT.joints)))
    felt = space.reset(np.arange(1), [drawn], q, np.zeros(1), np.array([plane])).down[0, FRONT]
    assert one.down(0) == pytest.approx(felt, abs=1e-9)
    assert np.linalg.norm(one.down(1)) == pytest.approx(1.0)


@given(angle=ANGLES)
def test_words_for_down_turn_with_it(angle: float) -> None:
    """An eighth of a turn to the left is the next word; towards the viewer and away from it are words of their own."""
    in_plane = np.array([math.cos(angle), math.sin(angle), 0.0])
    eighth = math.pi / 4
    later = np.array([math.cos(angle + eighth), math.sin(angle + eighth), 0.0])
    words = [down_words(one).removeprefix("down ") for one in (in_plane, later)]
    assert (WAYS.index(words[1]) - WAYS.index(words[0])) % len(WAYS) == 1
    assert {down_words(np.array([0.1, 0.0, side])) for side in (-1.0, 1.0)} == {
        "down points into the picture",
        "down points out of the picture",
    }


def test_a_corner_in_another_plane_has_no_walls_in_the_picture() -> None:
    one = PlaneRoll(ROBOT, route(90))
    straight = one.walls(1)
    assert straight.shape == (2, 2, 2)
    assert np.allclose(np.abs(straight[..., 1]), one._legs.radius[1])
    one.plane += one.away(1)
    assert len(one.walls(1)) > 2
