"""Overlap by geometry alone: exact where two shapes meet, and in agreement with the distances of certificates."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.certify.model import Model
from pipenav.certify.motion_check import clearances
from pipenav.certify.shapes import Boxes, Discs, Shapes, shapes_of
from pipenav.evaluation.overlap import overlaps
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import load_robot

HALF = np.array([0.03, 0.01])
RADIUS = 0.016
depths = st.floats(-0.008, 0.008).filter(lambda depth: abs(depth) > 1e-9)
angles = st.sampled_from([40.0, 63.0, 90.0, 118.0])


def one(part: str) -> Shapes:
    """A link with a single part about its joint."""
    no_box = Boxes(np.zeros(0, np.intp), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    no_disc = Discs(np.zeros(0, np.intp), np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    first, middle, height = np.zeros(1, np.intp), np.zeros((1, 2)), np.array([0.01])
    if part == "box":
        return Shapes(Boxes(first, middle, HALF[None], height), no_disc, np.array([0.06]))
    return Shapes(no_box, Discs(first, middle, np.array([RADIUS]), height), np.array([0.06]))


def overlap(part: str, pipe: PipeCorner, at: np.ndarray, heading: float) -> float:
    return float(overlaps(one(part), pipe.segments, np.asarray(at)[None, None], np.array([[heading]]))[0])


@given(depths, st.sampled_from(["left", "right"]), angles)
def test_a_part_that_is_pushed_into_a_straight_wall_overlaps_by_as_much(depth: float, turn: str, angle: float) -> None:
    pipe = PipeCorner.of(90, angle, turn)
    for part, size in (("box", HALF[1]), ("disc", RADIUS)):
        for side in (-1.0, 1.0):
            place = np.array([-0.3, side * (pipe.radius - size + depth)])
            assert overlap(part, pipe, place, 0.0) == pytest.approx(max(depth, 0.0), abs=1e-12)


@given(depths, st.sampled_from(["left", "right"]), angles)
def test_an_inner_edge_that_pokes_a_part_overlaps_by_as_much(depth: float, turn: str, angle: float) -> None:
    pipe = PipeCorner.of(120, angle, turn)
    edge = np.array([-pipe.radius / math.tan(pipe.angle / 2), pipe.turn_sign * pipe.radius])
    outwards = -(edge / np.hypot(*edge))  # along the bisector, from the inner edge to the corner
    across = math.atan2(outwards[1], outwards[0]) + math.pi / 2
    for part, size in (("box", HALF[1]), ("disc", RADIUS)):
        found = overlap(part, pipe, edge + outwards * (size - depth), across)
        assert found == pytest.approx(max(depth, 0.0), abs=1e-12)


@given(st.floats(0.001, 0.02))
def test_beyond_an_open_end_there_is_no_wall(past: float) -> None:
    pipe = PipeCorner.of(90, 75)
    assert overlap("box", pipe, np.array([-pipe.leg - HALF[0] - past, 0.2]), 0.0) == 0.0


@pytest.mark.parametrize("name", ["basic", "real-setup", "pirate"])
@given(data=st.data())
def test_a_pose_overlaps_exactly_where_certificates_see_no_clearance(name: str, data: st.DataObject) -> None:
    robot = load_robot(name)
    pipe = PipeCorner.of(
        data.draw(st.sampled_from([80.0, 120.0])), data.draw(angles), data.draw(st.sampled_from(["left", "right"]))
    )
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    joints = rng.uniform(0.4 * robot.lower, 0.4 * robot.upper, (8, len(robot.joints)))
    q = joints
    if robot.free:
        start = np.stack([rng.uniform(-0.9, 0.1, 8), rng.uniform(-0.02, 0.02, 8), rng.uniform(-0.3, 0.3, 8)], axis=1)
        q = np.concatenate([start, joints], axis=1)
    long, base = pipe.with_ends(3.0, 3.0), -robot.length
    pose = kinematics.forward(robot, q)
    found = overlaps(shapes_of(robot), long.segments, frames.robot_to_pipe(pose.joints, base), pose.headings)
    clear = clearances(Model(robot, pipe), q, base)
    sure = np.abs(clear) > 1e-9
    inside = found[sure] > 0
    assert (inside >= (clear[sure] <= 0)).all()  # walls that meet a part overlap with it
    whole = pipe_holds(long, pose, base)
    assert (~inside | (clear[sure] <= 0) | ~whole[sure]).all()


def pipe_holds(pipe: PipeCorner, pose: kinematics.ChainPose, base: float) -> np.ndarray:
    """Whether all joints lie in the pipe: a part that is wholly in a wall has a clearance too."""
    return np.asarray(pipe.contains(frames.robot_to_pipe(pose.joints, base)).all(axis=1))


@given(st.integers(0, 2**32 - 1), angles)
def test_parts_that_are_smaller_by_their_overlap_are_free(seed: int, angle: float) -> None:
    """The overlap of a success may be taken for the one that a proof allows."""
    pipe, rng = PipeCorner.of(100, angle), np.random.default_rng(seed)
    at = np.array([[rng.uniform(-0.3, 0.0), rng.uniform(-0.04, 0.04)]])
    heading = np.array([[rng.uniform(-math.pi, math.pi)]])
    for part in ("box", "disc"):
        deep = float(overlaps(one(part), pipe.segments, at[None], heading)[0])
        if deep < 0.9 * HALF[1]:
            assert overlaps(one(part).eroded(deep + 1e-9), pipe.segments, at[None], heading)[0] <= 1e-12
