"""Approach I: the printed equations by hand, the two traps they fall into, and what the default variant promises."""

from __future__ import annotations

import math
from contextlib import closing
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.backends.messages import Reading
from pipenav.errors import PipenavError
from pipenav.evaluation.locate_stage import LocateStage, inside_second_leg
from pipenav.evaluation.passage import Passages
from pipenav.locating.locator import LocateConfig, PrintedLocator, Variant, point_on_beam, robot_for
from pipenav.pipes.corner import PipeCorner
from pipenav.recording.record import RecordingSettings, record_locate
from pipenav.robots import kinematics, laser
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.testing import KinematicBackend, KinematicOptions

ROBOTS = ("basic", "high-fidelity", "real-setup")
FAST = RecordingSettings("mujoco", {"timestep": 0.005, "threads": 1})
ONE = np.arange(1)


def reading(robot: RobotSpec, q: Floats, ranges: Floats) -> Reading:
    return Reading(q[None], np.zeros((1, len(robot.joints))), ranges[None], np.zeros(1))


def printed(robot: RobotSpec, first: Reading, turn_sign: float) -> PrintedLocator:
    locator = PrintedLocator(robot, LocateConfig(), 1)
    locator.start(ONE, first, np.array([turn_sign]))
    return locator


@pytest.mark.parametrize(
    ("name", "beta_deg"),
    [
        ("basic", [0, 18, 36, 54, 72, 90, 108, 126, 144, 162]),  # (180 - 180) / 2 + 180 / 10 (i - 1)
        ("real-setup", [47, 55.6, 64.2, 72.8, 81.4, 90, 98.6, 107.2, 115.8, 124.4]),  # (180 - 86) / 2 + 8.6 (i - 1)
    ],
)
def test_eq_3_16_beams_from_the_heads_right(name: str, beta_deg: list[float]) -> None:
    angles = robot_for(load_robot(name), "thesis").laser.angles
    assert np.degrees(angles) + 90 == pytest.approx(beta_deg)


@pytest.mark.parametrize(
    ("theta", "beam", "ahead", "left"),
    [
        (0.0, 5, 0.2, 0.0),  # beta = 90 deg: straight ahead
        (0.0, 0, 0.0, -0.2),  # beta = 0: to the right
        (0.0, 9, 0.2 * math.cos(math.radians(72)), 0.2 * math.sin(math.radians(72))),  # beta = 162 deg
        (math.pi / 2, 5, 0.0, 0.2),  # the head looks left
        (-math.pi / 2, 0, -0.2, 0.0),  # the head looks right, its right is behind
    ],
)
def test_eq_3_17_the_target_on_a_beam(theta: float, beam: int, ahead: float, left: float) -> None:
    robot = robot_for(load_robot("basic"), "thesis")
    q = np.array([[0.03, 0.0, 0.0, theta]])
    tip = kinematics.forward(robot, q).tip[0]
    assert point_on_beam(robot, q, np.array([beam]), 0.2)[0] - tip == pytest.approx([ahead, left], abs=1e-12)


def test_eq_3_18_the_advance_and_the_turn() -> None:
    robot = robot_for(load_robot("basic"), "thesis")
    q, clear, near = np.array([0.1, 0.02, -0.03, 0.2]), np.full(10, 0.3), np.full(10, 0.3)
    near[5] = 0.05  # no more than delta, straight ahead
    locator = printed(robot, reading(robot, q, clear), 1.0)
    advances = []
    for ranges in (clear, near, near, clear):
        set_points = locator.act(reading(robot, q, ranges)).set_points[0]
        advances.append(set_points[0] - 0.1)
        assert set_points[1:] == pytest.approx([0.02, -0.03, 0.35])  # theta1, theta2 hold, theta3 turns by 0.15 rad
    assert advances == pytest.approx([0.02, 0.02 / 8, 0.02 / 64, 0.02])
    right = printed(robot, reading(robot, q, clear), -1.0)
    assert right.act(reading(robot, q, clear)).set_points[0, 3] == pytest.approx(0.05)


def test_a_near_wall_beside_the_head_does_not_slow_the_advance() -> None:
    robot = robot_for(load_robot("basic"), "thesis")
    q, ranges = np.zeros(4), np.full(10, 0.3)
    ranges[[0, 1, 8, 9]] = 0.01
    assert printed(robot, reading(robot, q, ranges), 1.0).act(reading(robot, q, ranges)).set_points[0, 0] == 0.02


def test_eq_3_19_only_a_beam_beyond_0_3_m_is_open() -> None:
    robot = robot_for(load_robot("basic"), "thesis")
    q, ranges = np.array([0.05, 0.0, 0.0, 0.1]), np.full(10, 0.3)
    locator = printed(robot, reading(robot, q, ranges), 1.0)
    shut = locator.act(reading(robot, q, ranges))
    assert not shut.done[0]
    assert shut.beam[0] == -1
    assert np.isnan(shut.target).all()
    ranges[7] = 0.305
    open_ = locator.act(reading(robot, q, ranges))
    assert open_.done[0]
    assert open_.beam[0] == 7
    assert open_.target[0] == pytest.approx(point_on_beam(robot, q[None], np.array([7]), 0.2)[0])
    assert open_.set_points[0] == pytest.approx(q)  # it stays


def test_the_printed_method_takes_a_straight_pipe_ahead_for_an_open_space() -> None:
    robot, pipe, base = robot_for(load_robot("basic"), "thesis"), PipeCorner.of(120, 90), -0.9
    tip = np.array([[base + robot.length, 0.0]])
    ranges = laser.measure(robot.laser, laser.cast(tip, robot.laser.angles[None], pipe.segments[None]))[0]
    first = reading(robot, np.zeros(4), ranges)
    decision = printed(robot, first, 1.0).act(first)
    assert decision.done[0]
    target = decision.target[0] + [base, 0.0]
    assert pipe.contains(target)
    assert not inside_second_leg(pipe, target)


def test_the_printed_method_turns_its_head_past_the_opening_of_a_narrow_pipe() -> None:
    located = record_locate(load_robot("basic"), "thesis", PipeCorner.of(80, 120), 0, 0, FAST)
    force = located.trajectory.contact_force
    assert force is not None
    assert located.trajectory.header.outcome == "timeout"
    assert located.found is None
    assert force.max() > 5.0
    better = record_locate(load_robot("basic"), "map", PipeCorner.of(80, 120), 0, 0, FAST)
    assert better.trajectory.succeeded


class Search(NamedTuple):
    """How one search ended: verdict, target in the pipe's frame (2,), all poses (rows, joints)."""

    outcome: Outcome
    target: Floats
    q: Floats


def search(name: str, pipe: PipeCorner, gap: float, bend: Floats, variant: Variant = "map") -> Search:
    """A search on a backend without physics, from a start so far before the bend, so much off straight."""
    robot = robot_for(load_robot(name), variant)
    base = np.array([-pipe.inner_edge - gap - robot.length])
    q = np.concatenate([[0.0], bend])[None]
    start = ReachEpisodes((pipe,), q, base, np.array([pipe.turn_sign]), np.zeros((1, 2)), np.zeros((1, 2)))
    backend, rows, outcome = KinematicBackend(robot, 1, KinematicOptions()), [q[0]], Outcome.RUNNING
    with closing(LocateStage(robot, LocateConfig(), variant, ReachConfig(), backend, 1, lambda _: start)) as stage:
        stage.start(ONE)
        while outcome is Outcome.RUNNING:
            step = stage.step()
            outcome = Outcome(step.outcome[0])
            rows.append(step.q[0].copy())
    return Search(outcome, stage.target[0] * [1.0, pipe.turn_sign] + [base[0], 0.0], np.array(rows))


STARTS = {
    "d": st.floats(70, 120),
    "angle": st.floats(55, 125),
    "gap": st.floats(0.06, 0.1),
    "bend": st.lists(st.floats(-0.02, 0.02), min_size=3, max_size=3),
}


@pytest.mark.parametrize("name", ROBOTS)
@settings(max_examples=20, deadline=None)
@given(**STARTS)
def test_the_default_finds_a_target_inside_the_second_leg(
    name: str, d: float, angle: float, gap: float, bend: list[float]
) -> None:
    pipe = PipeCorner.of(d, angle, "right")
    found = search(name, pipe, gap, np.array(bend))
    assert found.outcome is Outcome.REACHED
    along, off = pipe.along_second_leg(found.target)
    assert along - pipe.inner_edge == pytest.approx(0.1, abs=0.03)
    assert abs(off) < 0.03
    assert found.q[-1, 0] <= 0.002 + 1e-9  # back where it began, straight
    assert found.q[-1, 1:] == pytest.approx(np.zeros(3), abs=0.01)


@settings(max_examples=15, deadline=None)
@given(**STARTS)
def test_a_mirrored_pipe_gives_the_mirrored_target(d: float, angle: float, gap: float, bend: list[float]) -> None:
    left = search("basic", PipeCorner.of(d, angle, "left"), gap, np.array(bend))
    right = search("basic", PipeCorner.of(d, angle, "right"), gap, -np.array(bend))
    assert left.outcome is right.outcome
    # The simulated laser rounds to 5 mm, where the last bit of a distance may tip a reading.
    assert right.target * [1.0, -1.0] == pytest.approx(left.target, abs=2e-3)
    assert right.q[: len(left.q), 0] == pytest.approx(left.q[: len(right.q), 0], abs=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_on_physics_nothing_is_touched(name: str) -> None:
    rng = np.random.default_rng(7)
    turns = ["left", "right"]
    random = [PipeCorner.of(d, a, turns[i % 2]) for i, (d, a) in enumerate(rng.uniform((70, 55), (120, 125), (10, 2)))]
    pipes = [*random, *(PipeCorner.of(70, angle, turn) for angle in (55, 85, 120, 125) for turn in turns)]
    part = Passages(load_robot(name), ReachConfig(), pipes, 2, 3, options=dict(FAST.options)).locate()
    assert part.passed.all()
    assert part.results.force.max() == 0.0
    assert part.results.penetration.max() == 0.0


def test_a_recorded_search_is_the_one_that_an_evaluation_runs() -> None:
    robot, pipe = load_robot("high-fidelity"), PipeCorner.of(85, 70, "right")
    part = Passages(robot, ReachConfig(), [pipe], 3, 5, options=dict(FAST.options)).locate()
    for number in range(3):
        located = record_locate(robot, "map", pipe, 5, number, FAST)
        np.testing.assert_array_equal(located.trajectory.q, part.motions[number])
        base, set_points = located.trajectory.header.base_m, located.trajectory.header.goal_m
        assert set_points == pytest.approx(part.targets[number] * [1.0, -1.0] + [base, 0.0])
        assert located.found is not None
        assert located.ranges.shape == (len(located.trajectory.q), robot.laser.beams)


def test_the_recorded_scan_is_the_one_that_gave_the_printed_target() -> None:
    located = record_locate(load_robot("basic"), "thesis", PipeCorner.of(120, 120), 0, 0, FAST)
    trajectory, found, beam = located.trajectory, located.found, located.beam
    assert found is not None
    assert beam == located.ranges[found].argmax()
    assert located.ranges[found, beam] > 0.3 >= located.ranges[:found].max(initial=0.0)
    target = point_on_beam(trajectory.robot, trajectory.q[found][None], np.array([beam]), 0.2)[0]
    assert trajectory.header.goal_m == pytest.approx((target[0] + trajectory.header.base_m, target[1]))


def test_inside_the_second_leg_begins_past_the_bend() -> None:
    pipe = PipeCorner.of(100, 90)
    for along, inside in ((0.049, False), (0.051, True), (0.59, True), (0.61, False)):
        assert inside_second_leg(pipe, np.array([0.0, along])) is inside
    assert not inside_second_leg(pipe, np.array([0.06, 0.2]))  # in the wall
    assert not inside_second_leg(pipe, np.array([-0.2, 0.0]))  # in the first leg


def test_a_robot_of_other_joints_is_refused() -> None:
    robot = load_robot("basic")
    hinges = robot.model_copy(update={"links": robot.links[1:]})
    with pytest.raises(PipenavError, match="drives a slide followed by hinges; robot 'basic' has hinge, hinge, hinge"):
        LocateStage(
            hinges,
            LocateConfig(),
            "map",
            ReachConfig(),
            KinematicBackend(robot, 1, KinematicOptions()),
            1,
            lambda _: pytest.fail("no episode is drawn"),
        )
