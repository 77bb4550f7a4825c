"""The solids of a pipe: meshes that are watertight, boxes that stay in the walls and fill them."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_solids import EDGE_TOLERANCE, Box, Mesh, boards_mesh, corner_boxes, tube_mesh

diameters = st.floats(40, 300)
angles = st.one_of(st.floats(30, 180), st.sampled_from([30.0, 90.0, 179.999, 180.0]))
bends = st.one_of(st.floats(0, 500), st.sampled_from([0.0, 0.01, 1.0, 20.0]))
turns = st.sampled_from(["left", "right"])
walls = st.sampled_from([0.5, 3.0, 50.0])
pipes = st.builds(lambda d, a, t, r, w: PipeCorner.of(d, a, t, r, wall_mm=w), diameters, angles, turns, bends, walls)


def solid(mesh: Mesh) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(pipes)
@example(PipeCorner.of(40, 30, "left", 20.5))
@example(PipeCorner.of(300, 30, "right", 3000))
def test_meshes_are_watertight_solids(pipe: PipeCorner) -> None:
    for mesh in (boards_mesh(pipe), tube_mesh(pipe)):
        body = solid(mesh)
        assert body.is_watertight and body.is_winding_consistent and body.volume > 0


@settings(max_examples=25, deadline=None)
@given(diameters, angles, turns)
def test_volumes_of_a_mitred_pipe(diameter: float, angle: float, turn: str) -> None:
    pipe = PipeCorner.of(diameter, angle, turn)
    length = 2 * pipe.leg  # shear along a mitre keeps volumes: both solids are as large as those of a straight pipe
    boards = 2 * length * pipe.wall * pipe.diameter
    tube = math.pi * ((pipe.radius + pipe.wall) ** 2 - pipe.radius**2) * length
    assert solid(boards_mesh(pipe)).volume == pytest.approx(1e9 * boards, rel=1e-3)
    assert solid(tube_mesh(pipe)).volume == pytest.approx(1e9 * tube, rel=5e-3)


@settings(max_examples=60, deadline=None)
@given(pipes)
@example(PipeCorner.of(40, 30, "right", 1, wall_mm=50))
def test_no_box_reaches_into_free_space(pipe: PipeCorner) -> None:
    points = np.stack([inside_box(box, shrink=1e-7) for box in corner_boxes(pipe)])
    assert not pipe.contains(points).any()


@settings(max_examples=60, deadline=None)
@given(pipes)
@example(PipeCorner.of(40, 30, "right", 1, wall_mm=50))
def test_boxes_cover_every_wall_face(pipe: PipeCorner) -> None:
    boxes = corner_boxes(pipe)
    step = pipe.segments[:, 1] - pipe.segments[:, 0]
    length = np.linalg.norm(step, axis=1, keepdims=True)
    right = np.stack([step[:, 1], -step[:, 0]], axis=1) / length
    share = np.clip(np.array([0.5, EDGE_TOLERANCE, -EDGE_TOLERANCE]) / length, -0.5, 0.5) % 1.0  # (s, 3)
    points = pipe.segments[:, :1] + share[..., None] * step[:, None] + 1e-8 * right[:, None]  # (s, 3, 2)
    covered = np.zeros(points.shape[:2], bool)
    for box in boxes:
        local = to_box(box, points)
        covered |= (np.abs(local) <= np.array([box.length, box.thickness]) / 2 + 1e-9).all(axis=-1)
    assert covered[(length > 4 * EDGE_TOLERANCE)[:, 0]].all()


def to_box(box: Box, points: Floats) -> Floats:
    c, s = math.cos(box.yaw), math.sin(box.yaw)
    return (points - [box.x, box.y]) @ np.array([[c, -s], [s, c]])


def inside_box(box: Box, shrink: float) -> Floats:
    c, s = math.cos(box.yaw), math.sin(box.yaw)
    share = np.linspace(-0.5, 0.5, 5)
    grid = np.stack(np.meshgrid(share * (box.length - 2 * shrink), share * (box.thickness - 2 * shrink)), axis=-1)
    return grid @ np.array([[c, s], [-s, c]]) + [box.x, box.y]
