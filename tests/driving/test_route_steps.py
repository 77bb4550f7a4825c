"""Steps (a) to (e) on every corner of a route in one plane."""

from __future__ import annotations

import contextlib
from pathlib import Path

import numpy as np
import pytest

from pipenav.deployment.telemetry import read_telemetry
from pipenav.driving.plans import make_plan
from pipenav.driving.route_steps import NEAR, corner_row, least_spacing, order_after, require_room, roll_room
from pipenav.driving.scripted import script_for
from pipenav.driving.sessions import Session
from pipenav.driving.steps import STEPS
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import parse_corners
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import load_robot
from pipenav.units import mm_to_m

ROBOT = load_robot("pirate-strong")
ROUTE = PipeRoute.of(90, [(90, "left", 0), (75, "left", 0), (100, "right", 0)], straights_mm=[1000, 800, 900, 1000])

ROUTE_FILE = """schema = 1
diameter_mm = 90
first_straight_mm = 1000
[[corners]]
angle_deg = 90
turn = "left"
straight_mm = 800
[[corners]]
angle_deg = 100
turn = "right"
straight_mm = 1000
"""


def test_the_corners_of_a_route_are_those_of_its_drawing() -> None:
    row = corner_row(ROUTE)
    assert row is not None
    assert [corner.turn for corner in row.corners] == ["left", "left", "right"]
    assert np.allclose([corner.angle for corner in row.corners], ROUTE.interior_angles)
    assert np.allclose([corner.inner_edge for corner in row.corners], ROUTE.inner_edges)
    assert np.allclose(np.cumsum(row.spacing), ROUTE.distances[2:-1])


@pytest.mark.parametrize("turn", ["left", "right"])
def test_a_single_corner_is_a_row_of_one(turn: str) -> None:
    pipe = PipeCorner.of(90, 90, turn)
    row = corner_row(pipe)
    assert row is not None
    assert row.corners == (pipe,)
    assert row.spacing == ()
    require_room(ROBOT, pipe)


def test_a_half_turn_of_a_plane_is_a_turn_to_the_other_side() -> None:
    flipped = PipeRoute.of(90, [(90, "left", 0), (90, "left", 180)], straights_mm=[1000, 900, 1000])
    row = corner_row(flipped)
    assert row is not None
    assert [corner.turn for corner in row.corners] == ["left", "right"]


def test_pipes_with_other_fittings_than_corners_have_no_steps() -> None:
    tee = parse_corners(["d=100,tee=90"])[0]
    assert corner_row(tee) is None
    assert corner_row(None) is None
    with pytest.raises(PipenavError, match="other fittings than corners"):
        require_room(ROBOT, tee)


def test_a_roll_takes_more_room_than_the_steps_alone() -> None:
    """The least straight between two corners grows by what a robot rolls on and stretches before it may roll."""
    corners = [(90, "left", 0), (90, "left", 90)]
    row = corner_row(PipeRoute.of(90, corners, straights_mm=[1000, 900, 1000]))
    assert row is not None
    assert row.spacing == (pytest.approx(mm_to_m(900)),)
    least = least_spacing(ROBOT, *row.corners) + ROBOT.lengths[0] + roll_room(ROBOT, row.corners[0]) + NEAR
    for away, fits in ((0.001, True), (-0.001, False)):
        route = PipeRoute.of(90, corners, straights_mm=[1000, 1e3 * (least + away), 1000])
        with contextlib.nullcontext() if fits else pytest.raises(PipenavError, match="steps take at least"):
            require_room(ROBOT, route)


def test_corners_without_room_between_them_are_refused() -> None:
    """The least distance that is said is the least that is accepted."""
    row = corner_row(ROUTE)
    assert row is not None
    least = least_spacing(ROBOT, row.corners[0], row.corners[1])
    for away, fits in ((0.001, True), (-0.001, False)):
        corners = [(90, "left", 0), (75, "left", 0)]
        route = PipeRoute.of(90, corners, straights_mm=[1000, 1e3 * (least + away), 1000])
        if fits:
            require_room(ROBOT, route)
        else:
            with pytest.raises(PipenavError, match="between its corners 1 and 2"):
                require_room(ROBOT, route)


def test_steps_come_in_a_circle() -> None:
    step, seen = "a", []
    for _ in STEPS:
        seen.append(step)
        step = order_after(step)
    assert seen == list(STEPS)
    assert step == "a"


@pytest.mark.slow
def test_a_script_goes_through_every_corner_of_a_route_by_steps(tmp_path: Path) -> None:
    file = tmp_path / "route.toml"
    file.write_text(ROUTE_FILE)
    plan = make_plan(None, "pirate-strong", [str(file)], 2, 0).on("mujoco", {}, None, tmp_path)
    session = Session(plan, lambda _: script_for(plan.robot, 0, False))
    session.run()
    assert [record.outcome for record in session.records] == ["reached"] * 2
    for path in tmp_path.glob("*.jsonl"):
        ticks = read_telemetry(path).ticks
        steps = [tick["step"] for tick in ticks if tick["step"]]
        changes = [one for one, before in zip(steps, ["", *steps], strict=False) if one != before]
        assert "".join(changes) == "abcde" * 2
    assert max(record.largest_jump for record in session.records) <= 1 + 1e-6
