"""Walls of systems as convex pieces: convex, clear of the bore, without gaps, and as large as the wall."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from helpers.pipe_oracle import PipeOracle
from helpers.random_networks import random_network, random_routes
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.arrays import Floats
from pipenav.pipes.pipe_system import PipeSystem, Polygon, network_system, system_of
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_solids import BEND_DEVIATION, FACETS, route_boards_mesh
from pipenav.pipes.system_solids import ConvexPiece, system_wall_pieces

THICKNESS = 0.006
"""Wall that the pieces are asked for [m]."""


def faces_of(piece: ConvexPiece) -> tuple[Floats, Floats]:
    """Outward normals and offsets of a piece's faces: n x <= d inside, (f, 3) and (f,)."""
    a, b, c = np.moveaxis(piece.vertices[piece.faces], 1, 0)
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    normal = normal[size > 1e-14] / size[size > 1e-14, None]
    return normal, (normal * a[size > 1e-14]).sum(axis=1)


def deepest(pieces: list[ConvexPiece], points: Floats) -> Floats:
    """Depth of points (n, 3) in the piece that holds them deepest, negative outside of all: (n,) [m]."""
    best = np.full(len(points), -np.inf)
    for piece in pieces:
        low, high = piece.vertices.min(axis=0) - 1e-3, piece.vertices.max(axis=0) + 1e-3
        near = np.flatnonzero(((points > low) & (points < high)).all(axis=1))
        if len(near):
            normal, offset = faces_of(piece)
            best[near] = np.maximum(best[near], (offset - points[near] @ normal.T).min(axis=1))
    return best


def polygon(system: PipeSystem) -> float:
    """Distance by which the polygon's corners and a bend's chords lie off the round bore at most [m]."""
    radius = max(float(strand.legs.radius.max()) for strand in system.strands)
    return radius * (1 / math.cos(math.pi / FACETS) - 1 + BEND_DEVIATION)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_pieces_are_convex_clear_of_the_bore_and_without_gaps(seed: int) -> None:
    network = random_network(seed, 2)
    system, oracle = network_system(network), PipeOracle.of_network(network)
    pieces = system_wall_pieces(system, Polygon(FACETS), THICKNESS, BEND_DEVIATION)
    for piece in pieces:
        normal, offset = faces_of(piece)
        assert (piece.vertices @ normal.T - offset).max() < 1e-7
        body = trimesh.Trimesh(piece.vertices, piece.faces, process=False)
        assert body.is_watertight and body.volume > 0
    oracle.wall = THICKNESS
    points = oracle.around(6000, np.random.default_rng(seed))
    distance, outside = oracle.bore(points), oracle.outside(points)
    bends = BEND_DEVIATION * max(pipe.radius for pipe in oracle.pipes)
    free = deepest(pieces, points[distance < -bends - 1e-4])
    assert len(free) > 500 and free.max() < 0
    behind = (distance > polygon(system)) & (outside < -bends - 1e-4)
    steps = [name for name, node in oracle.nodes.items() if len(network.pipes_at(name)) == 2 and not node.reducer]
    for name in steps:  # a step's wall is as short as the step
        behind &= np.linalg.norm(points - oracle.nodes[name].position, axis=1) > 0.12
    wall = deepest(pieces, points[behind])
    assert len(wall) > 100 and wall.min() > -1e-6


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_the_volumes_of_the_pieces_are_about_the_walls(seed: int) -> None:
    network = random_network(seed, 2)
    pieces = system_wall_pieces(network_system(network), Polygon(FACETS), network.wall, BEND_DEVIATION)
    total = sum(trimesh.Trimesh(piece.vertices, piece.faces, process=False).volume for piece in pieces)
    section = FACETS / math.pi * math.tan(math.pi / FACETS)  # the polygon around a circle, in circles
    wall = section * PipeOracle.of_network(network).wall_volume(np.random.default_rng(seed))
    assert total >= 0.97 * wall
    assert total <= 1.25 * wall  # walls of a fitting's pipes overlap


@given(st.integers(0, 2**31 - 1))
@settings(max_examples=10, deadline=None)
def test_boards_of_planar_routes_are_watertight_and_stand_on_the_walls(seed: int) -> None:
    for route in random_routes(seed, level=True)[:2]:
        if any(corner.reducer and not corner.length for corner in route.corners):
            continue  # a step's wall is as short as the step
        mesh = route_boards_mesh(route)
        body = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
        assert body.is_watertight and body.is_winding_consistent
        area = sum(_area(np.concatenate([face, back[::-1]])) for face, back in route.wall_sides)
        assert 1e-9 * body.volume == pytest.approx(route.diameter * area, rel=1e-3)


def _area(outline: Floats) -> float:
    x, y = outline.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2


def test_a_cap_closes_the_far_end() -> None:
    route = PipeRoute.of(100, [(90, "left", 0)]).model_copy(update={"capped": True})
    pieces = system_wall_pieces(system_of(route), Polygon(FACETS), route.wall, BEND_DEVIATION)
    end, along = route.centre_line[-1], route.legs.axes[-1, :, 0]
    sideways = 0.9 * route.radius * route.legs.axes[-1, :, 1]
    points = np.array([end + 1e-3 * along, end + 1e-3 * along + sideways, end - 1e-3 * along])
    assert (deepest(pieces, points) > 0).tolist() == [True, True, False]
