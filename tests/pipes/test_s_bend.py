"""S-bends: two corners that undo each other's turn, as near to each other as a route allows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.random_routes import angles, turns
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.errors import OutOfRange, PipenavError
from pipenav.pipes.bend_radius import bend_radius_mm
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import parse_corners
from pipenav.pipes.route_sets import parse_pipes, parse_routes
from pipenav.pipes.s_bend import s_bend


@given(st.floats(40, 300), angles, turns, st.one_of(st.just(0.0), st.floats(0.75, 5)))
@settings(max_examples=50)
def test_an_s_bend_goes_on_in_the_direction_in_which_it_came(
    diameter: float, angle: float, turn: str, times: float
) -> None:
    corner = PipeCorner.of(diameter, angle, turn, times * diameter)
    try:
        route = s_bend(corner)
    except PipenavError as error:  # two sharp mitres in a row
        assert "crosses itself" in str(error)
        return
    np.testing.assert_allclose(route.leg_frames.axes[-1], np.eye(3), atol=1e-9)
    assert (route.diameter, route.wall) == (corner.diameter, corner.wall)
    assert route.straights[0] == route.straights[-1] == corner.leg
    aside = route.centre_line[-1, 1]
    assert aside == pytest.approx(corner.turn_sign * math.sin(math.pi - corner.angle) * route.straights[1], abs=1e-9)
    between = 1e3 * route.straights[1]
    assert between == pytest.approx(round(between), abs=1e-6)
    with pytest.raises(OutOfRange, match="length of straight 2"):
        s_bend(corner, between - 1)


def test_shipped_bends_are_those_that_their_descriptions_name() -> None:
    elbows, s_bends = parse_corners(["elbows"]), parse_routes(["s-bends"])
    assert len(elbows) == 6 * 3 * 3 * 2 and len(s_bends) == 6 * 3 * 2 * 2
    assert {round(pipe.bend_radius / pipe.diameter, 9) for pipe in elbows} == {1.0, 1.5, 3.0}
    assert {round(math.degrees(math.pi - pipe.angle)) for pipe in elbows} == {45, 60, 90}
    assert parse_pipes(["s-bends:5"]) == [s_bends[4]]


@pytest.mark.parametrize("name", ["elbows", "s-bends"])
def test_training_sets_of_bends_have_no_diameter_angle_or_radius_of_the_evaluated_ones(name: str) -> None:
    def numbers(which: str) -> list[set[float]]:
        corners = [
            (pipe.diameter, corner.angle, corner.bend_radius / pipe.diameter)
            for pipe in parse_routes([which])
            for corner in pipe.corners
        ]
        return [{round(value, 9) for value in values} for values in zip(*corners, strict=True)]

    for evaluated, trained in zip(numbers(name), numbers(f"{name}-train"), strict=True):
        assert not evaluated & trained


@pytest.mark.parametrize(("text", "millimetres"), [("150", 150.0), ("1.5D", 150.0), (" 1.5 d ", 150.0), ("0", 0.0)])
def test_a_bend_radius_is_read_in_mm_or_diameters(text: str, millimetres: float) -> None:
    assert bend_radius_mm(text, 100.0) == millimetres


@pytest.mark.parametrize("text", ["", "D", "1.5 x D", "mm"])
def test_a_bend_radius_that_is_no_number_is_refused(text: str) -> None:
    with pytest.raises(PipenavError, match=r"is no number: write mm, for example 150, or diameters, for example 1\.5D"):
        bend_radius_mm(text, 100.0)
