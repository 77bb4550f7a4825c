"""Fittings, their angles and errors, and classes that can be tried."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.surveys import map_of
from hypothesis import given
from hypothesis import strategies as st

from pipenav.networks.draft import LineFacts, MapDraft
from pipenav.pipes.route_file import read_route
from pipenav.survey.classes import ANGLE_STEP_DEG, FittingClass, angles_within, nominal_bore
from pipenav.survey.features import Geometry, angle_error, fittings_of
from pipenav.survey.graph import LEAST_LEG, mains_graph

CLASSES = [
    FittingClass("bend", 100, 90),
    FittingClass("bend", 100, 135, radius=1.5),
    FittingClass("reducer", 100, to_mm=80),
    *(
        FittingClass("tee", 100, a, to_mm=b, way=w)
        for a in (45, 90, 135)
        for b in (80, 100)
        for w in ("straight", "into", "out")
    ),
    *(
        FittingClass("cross", 100, a, to_mm=b, way=w)
        for a in (60, 90)
        for b in (80, 100)
        for w in ("straight", "into", "out")
    ),
]


@given(st.floats(5, 150), st.floats(0, 360), st.floats(5, 80), st.floats(5, 80))
def test_a_bend_has_the_angle_between_its_pipes(turn: float, heading: float, one: float, other: float) -> None:
    before, after = math.radians(heading), math.radians(heading + turn)
    points = [
        (-one * math.cos(before), -one * math.sin(before), 0.0),
        (0.0, 0.0, 0.0),
        (other * math.cos(after), other * math.sin(after), 0.0),
    ]
    fittings = fittings_of(mains_graph(map_of(points, [(0, 1), (1, 2)])), Geometry())
    feature = next(feature for feature in fittings.features if feature.kind != "end")
    assert feature.kind == "bend"
    assert feature.angle_deg == pytest.approx(180 - turn, abs=1e-6)
    assert sorted(feature.legs) == pytest.approx(sorted([one, other]))
    assert all(movement.turn == pytest.approx(math.radians(turn), abs=1e-9) for movement in fittings.movements)


@pytest.mark.parametrize(("one", "other"), [(10.0, 10.0), (4.0, 30.0), (25.0, 60.0)])
def test_the_error_of_an_angle_is_that_of_points_that_are_off(one: float, other: float) -> None:
    """A hundred thousand maps whose points are off by 0.25 m on each axis: their turns scatter as much."""
    rng = np.random.default_rng(0)
    off = rng.normal(0, 0.25, (100_000, 3, 2))
    before = off[:, 1] - off[:, 0] + [one, 0]
    after = off[:, 2] - off[:, 1] + [other, 0]
    turn = np.arctan2(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], np.einsum("ij,ij->i", before, after))
    assert angle_error(one, other, 0.25) == pytest.approx(np.degrees(turn.std()), rel=0.05)


@given(st.floats(30, 180), st.floats(0, 60), st.booleans())
def test_classes_within_an_error_are_those_that_the_true_angle_can_belong_to(
    angle: float, error: float, tee: bool
) -> None:
    angles = angles_within(angle, error, tee)
    step = 15.0 if tee else ANGLE_STEP_DEG
    assert abs(angles[0] - min(max(angle, 30), 150 if tee else 180)) <= step / 2 + 1e-9, "the likeliest comes first"
    assert len(set(angles)) == len(angles)
    assert all(abs(a - angle) <= error + step / 2 + 1e-9 or len(angles) == 1 for a in angles)
    assert set(angles_within(angle, error / 2, tee)) <= set(angles) | set(angles_within(angle, 0, tee))


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.name)
@pytest.mark.parametrize("turn", ["left", "right"])
def test_every_class_is_a_route_that_can_be_made(kind: FittingClass, turn: str, tmp_path: Path) -> None:
    (tmp_path / "class.toml").write_text(kind.toml(turn))
    route = read_route(tmp_path / "class.toml")
    corner = route.corners[0]
    bores = {kind.bore_mm, kind.to_mm or kind.bore_mm}
    entered = kind.to_mm if kind.way == "out" else kind.bore_mm
    assert route.diameter * 1e3 == pytest.approx(entered)
    assert {round(branch.diameter * 1e3, 6) for branch in corner.branches} <= bores
    assert len(corner.branches) == {"tee": 1, "cross": 2}.get(kind.kind, 0)
    if kind.way == "straight":
        assert corner.straight_on
    elif kind.kind != "reducer":
        assert math.degrees(corner.angle) == pytest.approx(kind.angle_deg)


@given(st.floats(0.02, 0.9))
def test_nominal_bores_are_near(bore: float) -> None:
    assert abs(nominal_bore(bore) - 1e3 * bore) <= 2.5 + 1e-9


@given(st.lists(st.floats(0.6, 30), min_size=2, max_size=30), st.floats(0, 6.28))
def test_vertices_of_a_straight_line_are_no_fittings(steps: list[float], heading: float) -> None:
    """They go, and the line keeps its length."""
    along = np.cumsum([0.0, *steps])
    draft = MapDraft("a map", "test")
    points = [(float(a * math.cos(heading)), float(a * math.sin(heading)), 0.0) for a in along]
    ends = draft.node("A", points[0], ""), draft.node("B", points[-1], "")
    draft.line("P", ends, LineFacts(diameter=0.1), points[1:-1])
    graph = mains_graph(draft.finish())
    assert len(graph.length) == 1
    assert graph.length.sum() == pytest.approx(sum(steps))


@given(st.floats(0.05, LEAST_LEG - 0.01), st.floats(20, 160))
def test_a_tiny_leg_makes_no_sharp_corner(tiny: float, turn: float) -> None:
    """Two long pipes in line, joined by a leg of some centimetres across: a drawing error."""
    side = (tiny * math.cos(math.radians(turn)), tiny * math.sin(math.radians(turn)))
    points = [(-40.0, 0.0, 0.0), (0.0, 0.0, 0.0), (*side, 0.0), (40 + side[0], side[1], 0.0)]
    graph = mains_graph(map_of(points, [(0, 1), (1, 2), (2, 3)]))
    angles = [f.angle_deg for f in fittings_of(graph, Geometry()).features if f.kind in ("bend", "joint")]
    assert angles and min(angles) > 178
    assert graph.length.sum() == pytest.approx(80 + tiny)


def test_services_are_taps_and_no_crossings() -> None:
    """Fifty services at a node of a main leave it a joint, with fifty taps."""
    draft = MapDraft("a map", "test")
    for i, x in enumerate((0.0, 50.0, 100.0)):
        draft.node(f"N{i}", (x, 0.0, 0.0), "")
    draft.line("A", (0, 1), LineFacts(diameter=0.1))
    draft.line("B", (1, 2), LineFacts(diameter=0.1))
    for i in range(50):
        draft.node(f"H{i}", (50.0, 5.0 + i, 0.0), "")
        draft.line(f"S{i}", (1, 3 + i), LineFacts(diameter=0.05, service=True))
    features = fittings_of(mains_graph(draft.finish()), Geometry()).features
    assert sorted(feature.kind for feature in features) == ["end", "end", "joint"]
    assert max(feature.taps for feature in features) == 50
