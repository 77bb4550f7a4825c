"""Surfaces of pipes with branches: whole, without what lies in another pipe, and opened to the viewer."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.fittings import PLANE, SPACE, network

from pipenav.drawing.projection import CutOpen, View
from pipenav.drawing.surface import PIECE, surface
from pipenav.pipes.pipe_system import PipeSystem, network_system, system_of
from pipenav.pipes.route import PipeRoute, as_route
from pipenav.pipes.tee import TeePassage, tee

DOWN = np.array([0.0, 0.0, -1.0])

SYSTEMS = {
    "plane": system_of(PLANE),
    "space": system_of(SPACE),
    "tee": system_of(as_route(tee(100, 45, TeePassage("into", "left")))),
    "network": network_system(network(0.8)),
    "plain": system_of(PipeRoute.of(100, [(90, "left", 0, 150), (75, "right", 90)])),
}


def areas(quads: np.ndarray) -> np.ndarray:
    return np.linalg.norm(np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]), axis=1) / 2


@pytest.mark.parametrize("route", [PLANE, SPACE])
def test_pieces_of_the_bore_lie_on_it_with_their_normals_outwards(route: PipeRoute) -> None:
    bore = surface(system_of(route), 0.0)
    middle = bore.quads.mean(axis=1)
    large = areas(bore.quads) > 1e-6
    step = 2e-3  # more than the polygon's sagitta
    inside = route.contains(middle - step * bore.normals)
    outside = ~route.contains(middle + step * bore.normals)
    assert inside[large].mean() > 0.995 and outside[large].mean() > 0.98


@pytest.mark.parametrize("name", SYSTEMS)
def test_pieces_are_small_and_their_vectors_are_unit_ones(name: str) -> None:
    system = SYSTEMS[name]
    whole = surface(system, system.wall)
    assert (np.linalg.norm(whole.quads[:, 3] - whole.quads[:, 0], axis=1) < 1.5 * PIECE).all()
    for vectors in (whole.normals, whole.outwards):
        np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1.0, atol=1e-9)
    assert len(whole.seams) == len(whole.seams_outwards)


def test_a_straight_tubes_surface_has_its_area() -> None:
    leg = SYSTEMS["plain"].strands[0].legs.part(0, 0)
    strand = SYSTEMS["plain"].strands[0]._replace(legs=leg)
    whole = surface(PipeSystem([strand], [], 0.003), 0.003)
    assert areas(whole.quads).sum() == pytest.approx(2 * math.pi * 0.053 * leg.length[0], rel=0.01)


@pytest.mark.parametrize("name", SYSTEMS)
def test_what_is_cut_open_shows_no_outside(name: str) -> None:
    """Every piece of the bore that is left lies on the far side of its own axis."""
    system = SYSTEMS[name]
    view = View.towards(0.7)
    bore = surface(system, 0.0)
    far, _ = bore.facing(-view.to_viewer)
    assert (bore.outwards[far] @ view.to_viewer < 0).all()
    opened = CutOpen.of(system, view)
    assert len(opened.polygons) == len(opened.colours) == len(opened.widths)
    near = opened.near(opened.polygons[0].mean(axis=0), 0.2)
    assert 0 < len(near.polygons) < len(opened.polygons)


@pytest.mark.parametrize("height", [0.0, 0.8])
def test_what_lies_in_a_level_plane_is_seen_from_above(height: float) -> None:
    view = View.of(network_system(network(height)))
    assert (view.to_viewer[2] == 1.0) == (height == 0.0)
    np.testing.assert_allclose(view.seen(DOWN) @ view.seen(DOWN), 1.0)
    assert view.seen(DOWN)[1] < 0 or height == 0.0
