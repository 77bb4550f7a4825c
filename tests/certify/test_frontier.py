"""Frontiers: the shipped ones are of the robots as they are, and hold where they are computed again."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from pipenav.certify.frontier import (
    SHIPPED,
    Frontier,
    Wanted,
    bend_radius_of,
    read_frontier,
    shipped_frontier,
    write_frontier,
)
from pipenav.certify.model import Model
from pipenav.certify.verdict import passable, proof_of
from pipenav.errors import PipenavError
from pipenav.pipes import PipeCorner
from pipenav.robots import load_robot
from pipenav.units import deg_to_rad

EVERY = [read_frontier(path) for path in sorted(SHIPPED.glob("*.json"))]
KINDS = [(frontier.robot, frontier.bore, frontier.bend_radius_d) for frontier in EVERY]


def shipped(name: str, bore: str, bend: float) -> Frontier:
    found = shipped_frontier(load_robot(name), bore, bend)
    assert found is not None, "make it again: pipenav certify --robot ... --frontier --out pipenav/certify/frontiers"
    return found


@pytest.mark.parametrize(("name", "bore", "bend"), KINDS)
def test_shipped_frontiers_are_of_the_robots_as_they_are(name: str, bore: str, bend: float) -> None:
    for point in shipped(name, bore, bend).points:
        if point.impossible_mm is not None and point.passable_mm is not None:
            assert point.impossible_mm < point.passable_mm


def test_proofs_and_motions_lie_near_each_other_except_at_three_points() -> None:
    """Within 0.5 mm for the whole robot and 2.5 mm for arms; docs/guides/certify.md lists the others."""
    apart = {
        (frontier.robot, frontier.bore, frontier.bend_radius_d, point.angle_deg)
        for frontier in EVERY
        for point in frontier.points
        if point.passable_mm is not None and point.impossible_mm is not None
        if point.passable_mm - point.impossible_mm > (0.5 if frontier.robot == "pirate" else 2.5) + 1e-9
    }
    listed = {("high-fidelity", "plane", 80.0), ("real-setup", "plane", 80.0), ("real-setup", "round", 120.0)}
    assert apart == {(robot, bore, 1.5, angle) for robot, bore, angle in listed}


def model_at(name: str, bore: str, bend: float, angle: float, diameter: float) -> Model:
    return Model(load_robot(name), PipeCorner.of(diameter, angle, bend_radius_mm=bend * diameter), bore)


@pytest.mark.parametrize(("name", "bore", "bend"), KINDS)
def test_a_shipped_point_has_a_motion_above_and_a_proof_below(name: str, bore: str, bend: float) -> None:
    point = shipped(name, bore, bend).points[2]
    if point.passable_mm is not None:
        assert passable(model_at(name, bore, bend, point.angle_deg, point.passable_mm), None) is not None
    if point.impossible_mm is not None:
        below = model_at(name, bore, bend, point.angle_deg, point.impossible_mm)
        assert proof_of(below, None, math.radians(0.25)) is not None


def test_a_point_of_the_whole_robot_is_computed_again() -> None:
    wanted = Wanted(load_robot("pirate"), "plane", 0.0, deg_to_rad(0.25))
    again, before = wanted.point(80.0), shipped("pirate", "plane", 0.0).points[2]
    assert before.angle_deg == 80.0
    assert again.passable_mm == pytest.approx(before.passable_mm, abs=0.3)
    assert again.impossible_mm == pytest.approx(before.impossible_mm, abs=0.3)


def test_a_frontier_of_a_robot_that_changed_is_stale(tmp_path: Path) -> None:
    robot = load_robot("pirate")
    frontier = shipped("pirate", "plane", 0.0)
    assert read_frontier(write_frontier(tmp_path, frontier)) == frontier
    first, *others = robot.links
    wider = robot.model_copy(update={"links": (first.model_copy(update={"width": first.width + 1e-3}), *others)})
    heavier = robot.model_copy(update={"links": (first.model_copy(update={"mass": 1.0}), *others), "friction": 0.5})
    assert frontier.of(heavier) and not frontier.of(wider)
    assert shipped_frontier(wider, "plane", 0.0) is None


def test_between_points_the_bore_lies_between_theirs() -> None:
    frontier = shipped("pirate", "plane", 0.0)
    at = [frontier.passable(angle) for angle in (60.0, 70.0, 80.0)]
    assert at[0] is not None and at[1] is not None and at[2] is not None
    assert at[0] > at[1] > at[2]
    assert frontier.passable(20.0) is None


def test_unknown_bends_are_refused() -> None:
    assert bend_radius_of("mitre") == 0.0
    assert bend_radius_of("1.5D") == 1.5
    for text in ("1.5", "D", "0.1D", "round"):
        with pytest.raises(PipenavError, match="unknown"):
            bend_radius_of(text)
