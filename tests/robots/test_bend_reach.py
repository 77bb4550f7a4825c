"""The reach of an arm along a bend: its poses are real ones, and nothing much farther can be reached by any."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.bend_reach import RESERVE, Bends, reach_along
from pipenav.robots.robot import RobotSpec, load_robot

ARMS = ("basic", "high-fidelity", "real-setup")
BENDS = {"d": st.floats(70, 120), "angle": st.floats(50, 150), "times": st.floats(0.5, 5)}
GAPS = st.floats(0.06, 0.1)


def bends_of(pipe: PipeCorner) -> Bends:
    return Bends(np.array([pipe.radius]), np.array([pipe.bend_radius]), np.array([math.pi - pipe.angle]))


def in_pipe(pipe: PipeCorner, points: Floats) -> Floats:
    """Points of a left bend's own frame in the pipe's."""
    return np.asarray(points - np.array([pipe.inner_edge, 0.0]))


@settings(max_examples=60, deadline=None)
@given(**BENDS, share=st.floats(-0.3, 1.3), aside=st.floats(-0.9, 0.9))
def test_points_lie_where_they_are_asked_for(d: float, angle: float, times: float, share: float, aside: float) -> None:
    pipe = PipeCorner.of(d, angle, "left", times * d)
    bends = bends_of(pipe)
    straight = 0.99 * (pipe.leg - pipe.inner_edge)  # so much of each leg lies before and after the bend
    distance = np.clip(share * bends.end, -straight, bends.end + straight)
    off = np.array([aside * pipe.radius])
    point = bends.points(distance, off)
    assert bends.distance(point) == pytest.approx(distance, abs=1e-9)
    assert pipe.contains(in_pipe(pipe, point))[0]


@settings(max_examples=30, deadline=None)
@given(**BENDS)
def test_the_middle_line_of_a_bend_is_the_pipes_centre_line(d: float, angle: float, times: float) -> None:
    pipe = PipeCorner.of(d, angle, "left", max(times, 0.5001) * d)
    bends = bends_of(pipe)
    along = np.linspace(0.0, bends.end[0], 30)
    many = Bends(*(np.repeat(column, 30) for column in bends))
    mine = in_pipe(pipe, many.points(along, np.zeros(30)))
    assert mine == pytest.approx(pipe.line(0.0, arc_segments=29)[1:-1], abs=1e-9)


def shortest_path(bends: Bends, start: Floats, end: Floats, keep_off: float) -> float:
    """Length of a string from one point to another, (2,) each, pulled taut around the inner wall [m]."""
    turning, radius = np.array([0.0, bends.middle_radius[0]]), bends.middle_radius[0] - bends.radius[0] + keep_off
    a, b = start - turning, end - turning
    far_a, far_b = np.linalg.norm(a), np.linalg.norm(b)
    between = math.remainder(math.atan2(b[1], b[0]) - math.atan2(a[1], a[0]), 2 * math.pi) % (2 * math.pi)
    touching = between - math.acos(min(radius / far_a, 1.0)) - math.acos(min(radius / far_b, 1.0))
    if touching <= 0:
        return float(np.linalg.norm(end - start))
    tangents = math.sqrt(max(far_a**2 - radius**2, 0.0)) + math.sqrt(max(far_b**2 - radius**2, 0.0))
    return float(tangents + radius * touching)


def farthest_by_string(robot: RobotSpec, bends: Bends, base: float) -> float:
    """Distance along the middle line beyond which the taut string from the first hinge is longer than the links [m]."""
    travel = RESERVE * (robot.upper - robot.lower)[0]
    hinge, links = np.array([base + robot.lengths[0] + robot.upper[0] - travel, 0.0]), robot.lengths[1:].sum()
    thinnest = min(link.width for link in robot.links) / 2
    tried = np.linspace(0.0, 1.0, 500)
    many = Bends(*(np.repeat(column, len(tried)) for column in bends))
    points = many.points(tried, np.zeros_like(tried))
    within = [shortest_path(bends, hinge, point, thinnest) <= links for point in points]
    return float(tried[int(np.argmin(within)) - 1])


@pytest.mark.parametrize("name", ARMS)
@settings(max_examples=25, deadline=None)
@given(**BENDS, gap=GAPS)
def test_no_tip_is_said_to_be_farther_than_the_links_are_long(
    name: str, d: float, angle: float, times: float, gap: float
) -> None:
    robot, bends = load_robot(name), bends_of(PipeCorner.of(d, angle, "left", times * d))
    base = -gap - robot.length
    reach = reach_along(robot, bends, np.array([base]))[0]
    assert reach <= farthest_by_string(robot, bends, base) + 0.003 or np.isinf(reach)


@pytest.mark.parametrize("name", ARMS)
@settings(max_examples=25, deadline=None)
@given(d=st.floats(70, 120), angle=st.floats(90, 150), times=st.floats(1, 5), gap=GAPS)
def test_through_elbows_no_controller_could_reach_much_farther(
    name: str, d: float, angle: float, times: float, gap: float
) -> None:
    robot, bends = load_robot(name), bends_of(PipeCorner.of(d, angle, "left", times * d))
    base = -gap - robot.length
    reach = reach_along(robot, bends, np.array([base]))[0]
    assert reach >= farthest_by_string(robot, bends, base) - 0.05


@settings(max_examples=25, deadline=None)
@given(**BENDS, gap=GAPS)
def test_bends_do_not_change_each_others_reach(d: float, angle: float, times: float, gap: float) -> None:
    robot, pipes = (
        load_robot("basic"),
        [PipeCorner.of(100, 90, "left", 150), PipeCorner.of(d, angle, "left", times * d)],
    )
    bases = np.array([-0.1, -gap]) - robot.length
    together = reach_along(robot, Bends(*map(np.concatenate, zip(*map(bends_of, pipes), strict=True))), bases)
    alone = [reach_along(robot, bends_of(pipe), bases[i : i + 1])[0] for i, pipe in enumerate(pipes)]
    assert together.tolist() == alone


def test_of_a_bend_too_narrow_for_the_links_nothing_is_known() -> None:
    robot = load_robot("high-fidelity")
    assert np.isinf(reach_along(robot, bends_of(PipeCorner.of(42, 60, "left", 21)), np.array([-0.1 - robot.length])))
