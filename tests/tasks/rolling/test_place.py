"""The place of a robot in space: passages, and when they count as behind however much the wheels slip."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.rolling import ROBOT, clamped
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Reading
from pipenav.backends.spatial import SpaceReading
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_routes
from pipenav.tasks.rolling.clamp import forward_directions
from pipenav.tasks.rolling.drawings import Drawings
from pipenav.tasks.rolling.place import AHEAD, Place

ONE, CORNER = np.arange(1), np.zeros(1, np.intp)
STEP = 0.01
"""Distance of a control step [m]."""

MOTLEY = parse_routes(["working-range", "elbows", "s-bends", "reducers"])


def drawings(route: PipeRoute) -> Drawings:
    made = Drawings(ROBOT, 1)
    made.put(ONE, [route])
    return made


@pytest.mark.parametrize("name", ["runs-level", "runs-rolled", "s-bends", "reducers"])
def test_a_passage_holds_corners_of_one_plane_that_leave_no_room_to_clamp(name: str) -> None:
    for route in parse_routes([name]):
        drawn, corners = drawings(route), len(route.corners)
        for k in range(corners - 1):
            gap = drawn.begin[0, k + 1] - drawn.end[0, k]
            one_plane = abs(np.sin(route.legs.inside[k + 1] - route.legs.inside[k])) < 1e-6
            together = bool(drawn.last[0, k] > k)
            assert together == (drawn.first[0, k + 1] <= k) == bool(one_plane and gap < ROBOT.length)
        assert (drawn.first[0, :corners] <= np.arange(corners)).all()
        assert drawn.last[0, corners - 1] == corners - 1


def test_the_turn_of_a_passage_is_that_of_its_corners_to_either_side() -> None:
    for route in parse_routes(["s-bends"]):
        assert drawings(route).net_turn[0, :2] == pytest.approx([0.0, 0.0], abs=1e-9)
    for route in parse_routes(["elbows"]):
        assert drawings(route).net_turn[0, 0] == pytest.approx(route.legs.turn_angle[0])


def reading(bends: np.ndarray, rolled: float, turned: float) -> SpaceReading:
    """The reading of one robot after a control step in which it rolled [m] and turned [rad]."""
    speeds = rolled / (CONTROL_PERIOD * ROBOT.wheels[0].radius) / forward_directions(bends)
    body = Reading(bends, np.zeros((1, 6)), np.zeros((1, 10)), np.zeros(1), speeds, np.zeros((1, 12)))
    return SpaceReading(body, np.zeros(1), np.zeros((1, 2, 3)), np.full((1, 2, 3), turned))


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(MOTLEY), st.floats(0.8, 1.25), st.integers(0, 2**32 - 1))
def test_a_passage_is_behind_once_the_rear_half_is_through_however_much_the_wheels_slip(
    route: PipeRoute, slip: float, seed: int
) -> None:
    rng, drawn = np.random.default_rng(seed), drawings(route)
    place, bends, plane = Place(ROBOT, drawn, 1), clamped(0.045, 1.0)[None], np.array([route.legs.inside[0]])
    place.start(ONE)
    last, reach = len(route.corners) - 1, float(drawn.reach[0, 0])
    begin, end = drawn.begin[0, : last + 1], drawn.end[0, : last + 1]
    turns = route.legs.turn_angle * np.cos(route.legs.inside - route.legs.inside[0])
    middle, heading, corner, passed = -AHEAD - reach, 0.0, CORNER, 0
    length = ROBOT.lengths[:3].sum()  # of the rear half, with its end
    while not place.behind(corner, plane)[0]:
        middle += STEP
        rear = middle - reach
        through = np.clip((rear + length - begin) / (end - begin + length), 0.0, 1.0) @ turns
        place.move(
            reading(bends, STEP * slip, through - heading + 0.01 * rng.normal()), np.ones(1, bool), np.zeros(1, bool)
        )
        heading, corner = through, place.corner_in_passage(corner)
        passed = max(passed, int((middle >= end).sum()))
        assert rear < end[-1] + 0.5
    assert middle - reach > begin[-1] - 0.25
    assert drawn.last[0, 0] == corner[0] or passed < last


def test_the_laser_puts_the_place_right_at_a_corner_and_its_turn_does_behind_it() -> None:
    drawn = drawings(parse_routes(["runs-rolled:1"])[0])
    place, second = Place(ROBOT, drawn, 1), np.ones(1, np.intp)
    begin, end, reach = drawn.begin[0, 1], drawn.end[0, 1], drawn.reach[0, 1]
    for off in (-0.3, 0.1):
        place.middle[:] = begin - AHEAD - reach + off
        place.enter(ONE, second, np.ones(1, bool))
        assert place.middle == pytest.approx(begin - AHEAD - reach)
    place.middle[:] = begin - 1.0
    place.enter(ONE, second, np.zeros(1, bool))
    assert place.middle == begin - 1.0  # it stalled, and knows no better
    for off in (-1.0, 1.0):
        place.middle[:] = end + reach + off
        place.leave(ONE, second)
        assert begin <= place.middle[0] - reach <= end + 0.2


def test_the_wheels_say_that_a_corner_is_here_shortly_before_the_tip_reaches_it() -> None:
    for route in parse_routes(["reducers"]):
        drawn = drawings(route)
        place = Place(ROBOT, drawn, 1)
        for past, here in [(-0.2, False), (-0.05, True), (0.2, True)]:
            place.middle[:] = drawn.begin[0, 0] - drawn.reach[0, 0] + past
            assert place.reaches(CORNER) == here
