"""Reducers: a route that goes straight on to another bore, in a cone or in a step."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from helpers.prisms import depth_in_any, faces_of
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.errors import PipenavError
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.reducer import reducer
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import corner_of, reducer_corner
from pipenav.pipes.route_legs import STEP
from pipenav.pipes.route_sets import parse_pipes, parse_routes
from pipenav.pipes.route_solids import route_boards_mesh, route_tube_mesh, wall_prisms

diameters = st.floats(40, 300)
lengths = st.one_of(st.just(0.0), st.floats(1.0, 500.0))

MIXED = PipeRoute.with_default_straights(
    0.11,
    (corner_of(90, "left", 0, 165), reducer_corner(80, 110), corner_of(75, "right", 90), reducer_corner(100, 0)),
    [None] * 5,
    0.003,
)

TIGHT = PipeRoute.with_default_straights(
    0.2, (corner_of(90, "left"), reducer_corner(40, 150), corner_of(90, "right", 0, 30)), [None] * 4, 0.003
)
"""A wide pipe that becomes narrow before a bend whose radius is smaller than the wide bore's."""


def radius_at(route: PipeRoute, x: np.ndarray) -> np.ndarray:
    """Radius of a straight route's bore at positions along it, 0 at the middle of its reducer [m]."""
    before, behind = route.legs.radius
    half = route.legs.taper[0] / 2
    return np.interp(x, [-half, half], [before, behind])


@given(diameters, diameters, lengths, st.integers(0, 9))
@settings(max_examples=50)
def test_the_bore_is_a_cone_between_two_cylinders(before: float, behind: float, length: float, seed: int) -> None:
    route = reducer(before, behind, length, 800)
    rng = np.random.default_rng(seed)
    x, around = rng.uniform(-0.79, 0.79, 200), rng.uniform(0, 2 * math.pi, 200)
    for factor, inside in ((0.999, True), (1.001, False)):
        away = factor * radius_at(route, x)
        points = np.stack([x, away * np.cos(around), away * np.sin(around)], axis=1)
        near_step = np.abs(x) < STEP
        assert ((route.contains(points) == inside) | near_step).all()


@given(diameters, diameters, lengths)
@settings(max_examples=50)
def test_walls_in_the_plane_follow_the_bore_and_edges_are_where_it_widens(
    before: float, behind: float, length: float
) -> None:
    route = reducer(before, behind, length, 800)
    for (wall, _), side in zip(route.wall_sides, (1, -1), strict=True):
        np.testing.assert_allclose(side * wall[:, 1], radius_at(route, wall[:, 0]), atol=1e-9)
    assert len(route.segments) == 6
    bends = np.abs(before - behind) > 1e-6
    edges = {round(float(x), 9) for x in route.segments[route.edges][:, 0] if abs(x) < 0.7} if bends else set()
    half = float(route.legs.taper[0]) / 2
    assert edges <= {round(half if behind < before else -half, 9)}
    assert len(edges) == bends


@pytest.mark.parametrize("length", [0, 50, 120])
def test_solids_are_watertight_and_as_large_as_cones_and_cylinders(length: float) -> None:
    route = reducer(120, 80, length, 700)
    tube, boards = (
        trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
        for mesh in (route_tube_mesh(route), route_boards_mesh(route))
    )
    assert tube.is_watertight and tube.is_winding_consistent and boards.is_watertight
    cone = 1e-3 * max(length, 0.1)

    def volume(a: float, b: float) -> float:
        straight = (0.7 - cone / 2) * (a**2 + b**2)
        return math.pi * (straight + cone / 3 * (a**2 + a * b + b**2))  # of a frustum

    assert 1e-9 * tube.volume == pytest.approx(volume(0.063, 0.043) - volume(0.06, 0.04), rel=5e-3)


@pytest.mark.parametrize(
    "route", [MIXED, TIGHT, reducer(120, 80, 0), reducer(70, 110, 55)], ids=lambda route: route.name
)
@pytest.mark.parametrize("thickness", [None, 0.02])
def test_prisms_are_convex_and_leave_the_bore_free(route: PipeRoute, thickness: float | None) -> None:
    prisms = wall_prisms(route, thickness=thickness)
    normal, offset = faces_of(prisms)
    assert (np.einsum("...fi,...vi->...fv", normal, prisms) - offset[..., None]).max() < 1e-9
    rng = np.random.default_rng(0)
    around, share = rng.uniform(0, 2 * math.pi, 60), rng.uniform(size=(60, 1, 1))
    for factor, inside in ((0.98, False), (1.03, True)):
        lines = route.legs.lines(factor * route.legs.radius[None], around)
        points = (lines[:, :-1] + share * np.diff(lines, axis=1)).reshape(-1, 3)
        assert ((depth_in_any(prisms, points) > 0) == inside).all()


def test_shipped_reducers_go_one_size_up_and_down() -> None:
    routes = parse_routes(["reducers"])
    sizes = {tuple(np.round(2e3 * route.legs.radius).tolist()) for route in routes}
    assert sizes == {(d, d - 10) for d in range(80, 121, 10)} | {(d - 10, d) for d in range(80, 121, 10)}
    assert len(routes) == 3 * len(sizes)
    trained = {tuple(np.round(2e3 * route.legs.radius).tolist()) for route in parse_routes(["reducers-train"])}
    assert not trained & sizes


def test_the_narrowest_bore_decides_what_fits() -> None:
    assert MIXED.narrowest == pytest.approx(0.08)
    pipes: list[Pipe] = parse_pipes(["d=90,angle=60"])
    assert pipes[0].narrowest == pytest.approx(0.09)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((100, 30), "diameter behind reducer 1, 30 mm, is out of range: choose 40 to 300 mm."),
        ((100, 80, -1), "length of reducer 1, -1 mm, is out of range: choose 0 to 2000 mm."),
        ((100, 80, 400, 150), "length of straight 1, 150 mm, is out of range: choose 210"),
    ],
)
def test_messages_name_what_is_allowed(arguments: tuple[float, ...], message: str) -> None:
    with pytest.raises(PipenavError) as caught:
        reducer(*arguments)
    assert message in str(caught.value)


def test_names_and_labels_say_the_bores() -> None:
    assert MIXED.name == "run-d110-L90r165-D80l110-R75roll90-D100"
    words = [
        "110 mm",
        "90 deg left in 165 mm",
        "to 80 mm over 110 mm",
        "75 deg right rolled 90 deg",
        "to 100 mm over 0 mm",
    ]
    assert MIXED.label == ", ".join(words)
