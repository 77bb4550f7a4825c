"""Approach II: mirroring and reversing undo themselves; what may be mirrored; the rear stage on physics."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.motions import mirror
from pipenav.motions.mirror import hand_over, is_out, join, plan_rear, rear_motion, reverse
from pipenav.motions.trajectory import Motion, Trajectory, TrajectoryHeader
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.baselines.wall_distance import wall_distance
from pipenav.robots.kinematics import forward
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import PassageStage

ROBOT = load_robot("basic")


@st.composite
def motions(draw: st.DrawFn) -> Motion:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    turn = draw(st.sampled_from(["left", "right"]))
    pipe = PipeCorner.of(draw(st.floats(60, 200)), draw(st.floats(40, 170)), turn, draw(st.sampled_from([0.0, 80.0])))
    q = rng.uniform(ROBOT.lower, ROBOT.upper, (draw(st.integers(2, 12)), 4))
    return Motion(pipe, draw(st.floats(-0.8, -0.4)), q)


def same(one: Motion, two: Motion) -> bool:
    return one.pipe == two.pipe and one.base == two.base and np.array_equal(one.q, two.q)


@given(motions())
def test_mirroring_twice_and_reversing_twice_are_nothing(motion: Motion) -> None:
    assert same(mirror.mirror(ROBOT, mirror.mirror(ROBOT, motion)), motion)
    assert same(reverse(reverse(motion)), motion)
    assert same(rear_motion(ROBOT, rear_motion(ROBOT, motion)), motion)
    assert same(reverse(mirror.mirror(ROBOT, motion)), mirror.mirror(ROBOT, reverse(motion)))


@given(motions())
def test_a_mirrored_motion_is_the_image_in_the_mirrored_pipe(motion: Motion) -> None:
    image = mirror.mirror(ROBOT, motion)
    assert forward(ROBOT, image.q).tip == pytest.approx(forward(ROBOT, motion.q).tip * [1, -1], abs=1e-12)
    assert image.pipe.walls.inner == pytest.approx(motion.pipe.walls.inner * [1, -1], abs=1e-12)
    room = [wall_distance(ROBOT, one.pipe, one.q, one.base) for one in (motion, image)]
    assert room[0] == pytest.approx(room[1], abs=1e-9)


@given(motions())
def test_the_hand_over_is_between_two_points_of_the_same_pipe(motion: Motion) -> None:
    jump, pipe = hand_over(ROBOT, motion), motion.pipe
    middle = motion.base + motion.q[-1, 0]  # the first link's rear end, on the first leg's axis
    assert jump.distance == pytest.approx(2 * -middle, abs=1e-9)
    assert jump.straight == pytest.approx(2 * -middle * math.sin(pipe.angle / 2), abs=1e-9)
    assert jump.turn_angle == pytest.approx(abs(pipe.heading_change), abs=1e-9)
    assert jump.joint_change == pytest.approx(2 * np.abs(motion.q[-1, 1:]).max())


@given(motions(), st.integers(1, 8))
def test_joining_undoes_a_cut(motion: Motion, cut: int) -> None:
    cut = min(cut, len(motion.q) - 1)
    parts = [motion._replace(q=motion.q[: cut + 1]), motion._replace(q=motion.q[cut:])]
    assert same(join(parts), motion)


def test_parts_that_do_not_follow_each_other_are_refused() -> None:
    one = Motion(PipeCorner.of(100, 90), -0.6, np.zeros((3, 4)))
    with pytest.raises(PipenavError, match=r"part 2 of the passage starts 0\.3 rad or m away"):
        join([one, one._replace(q=np.full((3, 4), 0.3))])
    with pytest.raises(PipenavError, match="part 2 of the passage is in another pipe"):
        join([one, one._replace(pipe=PipeCorner.of(100, 91))])
    with pytest.raises(PipenavError, match="or at another base"):
        join([one, one._replace(base=-0.5)])


@settings(max_examples=50)
@given(motions())
def test_out_of_the_corner_is_before_the_inner_edge_with_every_point(motion: Motion) -> None:
    out = is_out(ROBOT, motion.pipe, motion.base, motion.q)
    pose = forward(ROBOT, motion.q)
    along = np.stack([np.cos(pose.headings), np.sin(pose.headings)], axis=-1)
    lengths = np.array([link.length for link in ROBOT.links])
    for share in (0.0, 0.5, 1.0):
        points = pose.joints + share * lengths[:, None] * along
        beyond = (points[..., 0] + motion.base > -motion.pipe.inner_edge).any(axis=1)
        assert not (out & beyond).any()


def changed(front: Trajectory, **header: Any) -> Trajectory:
    return replace(front, header=front.header.model_copy(update=header))


def test_the_plan_of_a_front(front: Trajectory) -> None:
    plan = plan_rear([front])
    assert np.array_equal(plan.q, (front.q * [1, -1, -1, -1])[::-1])
    assert plan.header.pipe == PipeCorner.of(100, 75, "left")
    assert (plan.header.stage, plan.header.outcome, plan.header.goal_m) == ("rear", None, None)
    assert plan.header.base_m == front.header.base_m
    assert plan.contact_force is None
    assert plan.link_forces is None


def test_a_front_that_began_where_locating_ended_needs_the_locating_part(front: Trajectory) -> None:
    whole = front.q
    locate = replace(changed(front, stage=PassageStage.LOCATE), q=whole[:6])
    rest = replace(front, q=whole[5:])
    assert np.abs(rest.q[0, 1:]).max() > mirror.STRAIGHT
    with pytest.raises(PipenavError, match=r"does not start straight: theta\d is at .* deg, allowed are 5\.7 deg"):
        plan_rear([rest])
    assert np.array_equal(plan_rear([locate, rest]).q, plan_rear([front]).q)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ({"outcome": "timeout"}, r"the reach part of the passage did not succeed \(outcome: timeout\)"),
        ({"outcome": None}, r"\(outcome: not run\)"),
        ({"stage": PassageStage.REAR}, "a rear half's already"),
        ({"stage": PassageStage.LOCATE}, "ends with a part of stage 'locate'"),
        ({"base_m": -0.3}, "in the corner"),
    ],
)
def test_what_cannot_be_mirrored(front: Trajectory, header: dict[str, Any], message: str) -> None:
    with pytest.raises(PipenavError, match=message):
        plan_rear([changed(front, **header)])


def test_how_straight_a_start_must_be(front: Trajectory) -> None:
    def bent(angle: float) -> Trajectory:
        return replace(front, q=np.concatenate([[[0.0, 0.0, angle, 0.0]], front.q[1:]]))

    for angle in (-0.05, 0.0999):
        plan_rear([bent(angle)])
    with pytest.raises(PipenavError, match=r"theta2 is at 6\.3 deg"):
        plan_rear([bent(-0.11)])


def test_a_header_of_a_plan_is_of_the_mirrored_pipe() -> None:
    header = TrajectoryHeader(robot="basic", pipe=PipeCorner.of(100, 60), base_m=-0.7, stage="reach", outcome="reached")
    plan = plan_rear([Trajectory(header, ROBOT, np.zeros((3, 4)))])
    assert plan.header.pipe.name == "corner-d100-a60-right"
