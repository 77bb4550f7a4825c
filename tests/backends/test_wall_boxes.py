"""Boxes stand for walls: each behind its face, as long as the face at least, and parked where a pipe needs none."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.random_routes import angles, diameters, turns
from hypothesis import given
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.backends.refusals import TooManyWalls
from pipenav.backends.wall_boxes import INNER_THICKNESS, OUTER_THICKNESS, PARKED, Edge, wall_boxes
from pipenav.pipes.corner import PipeCorner

BASE = -0.4


def in_boxes(points: Floats, pipe: PipeCorner) -> Floats:
    """Points (4, k, 2) in the frames of a corner's boxes: x along the face, y towards the free space [m]."""
    boxes = wall_boxes([pipe], 4, np.array([BASE]))
    yaw = 2 * np.arctan2(boxes.quaternion[0, :, 3], boxes.quaternion[0, :, 0])
    along = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    shifted = points - boxes.position[0, :, None, :2]
    return np.stack([(shifted * along[:, None]).sum(axis=2), (shifted * across[:, None]).sum(axis=2)], axis=2)


@given(diameters, angles, turns)
def test_every_box_lies_behind_its_face(diameter: float, angle: float, turn: str) -> None:
    pipe = PipeCorner.of(diameter, angle, turn)
    boxes = wall_boxes([pipe], 4, np.array([BASE]))
    faces = boxes.segments[0]
    assert faces == pytest.approx(pipe.segments - [BASE, 0.0], abs=1e-12)
    ends = in_boxes(faces, pipe)
    half = boxes.half_size[0]
    assert ends[..., 1] == pytest.approx(np.tile(half[:, 1:2], (1, 2)), abs=1e-9), "the face is the box's front"
    middle = (faces[:, 0] + faces[:, 1]) / 2 + [BASE, 0.0]
    normal = np.stack([-(faces[:, 1] - faces[:, 0])[:, 1], (faces[:, 1] - faces[:, 0])[:, 0]], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert pipe.contains(middle + 1e-6 * normal).all()
    behind = boxes.position[0, :, :2] - (middle - [BASE, 0.0])
    assert ((behind * normal).sum(axis=1) < 0).all(), "its centre is not in the free space"
    assert (np.abs(ends[..., 0]) <= half[:, :1] + 1e-9).all(), "the face is nowhere longer than the box"


@given(diameters, st.floats(60, 120), turns)
def test_boxes_at_a_convex_edge_are_thin_and_the_others_run_on_past_their_ends(
    diameter: float, angle: float, turn: str
) -> None:
    pipe = PipeCorner.of(diameter, angle, turn)
    boxes = wall_boxes([pipe], 4, np.zeros(1))
    at_edge = pipe.edges.any(axis=1)
    assert at_edge.sum() == 2
    assert 2 * boxes.half_size[0, :, 1] == pytest.approx(np.where(at_edge, INNER_THICKNESS, OUTER_THICKNESS))
    length = np.linalg.norm(pipe.segments[:, 1] - pipe.segments[:, 0], axis=1)
    ends_in_free_space = pipe.edges.sum(axis=1)  # 2 for the inner walls, which end at the edge and where the pipe ends
    expected = (2 - ends_in_free_space) * OUTER_THICKNESS
    assert 2 * boxes.half_size[0, :, 0] - length == pytest.approx(expected)


def test_a_gap_shortens_only_the_boxes_at_an_edge() -> None:
    pipe = PipeCorner.of(90, 75)
    sharp, rounded = (wall_boxes([pipe], 4, np.zeros(1), Edge(gap=gap)).half_size[0, :, 0] for gap in (0.0, 0.002))
    assert 2 * (sharp - rounded) == pytest.approx(0.002 * pipe.edges.sum(axis=1))


def test_slots_that_are_left_over_are_parked_and_too_few_are_refused() -> None:
    pipe = PipeCorner.of(90, 75, "right")
    boxes = wall_boxes([pipe], 6, np.zeros(1))
    assert boxes.position[0, :, 2].tolist() == [0.0] * 4 + [PARKED] * 2
    assert np.array_equal(boxes.segments[0, 4:], np.tile(pipe.segments[-1], (2, 1, 1)))
    with pytest.raises(TooManyWalls):
        wall_boxes([pipe], 3, np.zeros(1))
