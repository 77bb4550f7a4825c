"""Drawings of routes with tees, crosses, reducers and caps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.fittings import PLANE, SPACE, fitted
from helpers.pictures import overlapping, texts
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline
from matplotlib.text import Annotation

from pipenav.drawing.corner import draw_walls, free_outline
from pipenav.drawing.cut_open import TITLE as CUT_OPEN
from pipenav.drawing.down import WORD
from pipenav.drawing.route import route_figure
from pipenav.drawing.words import counts_of, words_of
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.route import PipeRoute, as_route
from pipenav.pipes.tee import TeePassage, tee
from pipenav.units import m_to_mm

TEES = [
    tee(100, angle, TeePassage(way, turn))
    for angle in (45, 90)
    for way in ("straight", "into", "out")
    for turn in ("left", "right")
]
CORNERS = [PipeCorner.of(90, 60, turn, bend) for turn in ("left", "right") for bend in (0, 60, 150)]


@pytest.mark.parametrize(
    "pipe", [PLANE, *TEES, *CORNERS, PipeRoute.of(100, [(90, "left", 0)])], ids=lambda pipe: pipe.name
)
def test_the_free_space_that_is_filled_is_where_the_pipe_contains_points(pipe: Pipe) -> None:
    outline = free_outline(pipe)
    low, high = outline.min(axis=0), outline.max(axis=0)
    points = np.random.default_rng(0).uniform(low, high, (4000, 2))
    filled = Outline(outline).contains_points(points)
    steps = np.roll(outline, -1, axis=0) - outline
    share = np.clip(((points[:, None] - outline) * steps).sum(axis=2) / np.maximum((steps**2).sum(axis=1), 1e-12), 0, 1)
    away = np.linalg.norm(points[:, None] - outline - share[..., None] * steps, axis=2).min(axis=1) > 1e-3
    assert (filled == pipe.contains(points))[away].all()
    assert filled.any()


@pytest.mark.parametrize("pipe", [PLANE, fitted(0, capped=False), *TEES], ids=lambda pipe: pipe.name)
def test_every_piece_of_wall_is_drawn_and_named_once(pipe: Pipe) -> None:
    axes = Figure().add_subplot()
    draw_walls(axes, pipe)
    walls = axes.patches[1:]  # after the free space
    assert len(walls) == len(pipe.wall_sides)
    assert [patch.get_label() for patch in walls].count("wall") == 1
    drawn = np.concatenate([patch.get_xy() for patch in walls])
    assert drawn.min() >= m_to_mm(free_outline(pipe).min() - pipe.wall) - 1e-6


@pytest.mark.parametrize("pipe", [as_route(pipe) for pipe in TEES], ids=lambda pipe: pipe.name)
def test_a_plan_of_a_tee_says_what_the_branch_is(pipe: PipeRoute) -> None:
    said = " ".join(texts(route_figure(pipe, "mine")))
    (branch,) = pipe.corners[0].branches
    assert "past a branch" in said
    assert "⌀ 100, 300 long" in said or "⌀ 100, 350 long" in said
    assert ("straight on" if branch.angle == math.pi else f"{math.degrees(branch.angle):g}° {branch.turn}") in said
    assert "mine: one tee, ⌀ 100 mm" in said


@pytest.mark.parametrize("route", [PLANE, SPACE, fitted(0, capped=False), *map(as_route, TEES)], ids=lambda r: r.name)
def test_no_text_of_a_drawing_lies_over_another(route: PipeRoute) -> None:
    figure = route_figure(route, "mine")
    for axes in figure.axes:
        assert overlapping(figure, axes) == []


@pytest.mark.parametrize("route", [PLANE, SPACE])
def test_the_title_counts_what_the_route_is_made_of(route: PipeRoute) -> None:
    assert counts_of(route) == "2 corners, one tee, one cross, one reducer, capped"
    said = " ".join(" ".join(texts(route_figure(route, "mine"))).split())
    assert "mine: 2 corners, one tee, one cross, one reducer, capped, ⌀ 100-80 mm, wall 3 mm" in said
    assert "cap" in said.split()


def test_a_capped_route_has_no_arrow_out_of_its_end() -> None:
    def arrows(route: PipeRoute) -> int:
        notes = route_figure(route, "mine").axes[0].findobj(Annotation)
        return sum(note.arrow_patch is not None for note in notes)

    assert arrows(fitted(0, capped=False)) == arrows(PLANE) + 1


def test_words_of_a_tee() -> None:
    tee_there, cross = PLANE.corners[1], SPACE.corners[3]
    assert words_of(tee_there) == "straight on\npast a branch"
    assert words_of(cross) == "90° right\nrolled 90°\npast 2 branches"
    assert words_of(tee_there, branches=True) == "straight on\npast ⌀ 60\n60° right"
    assert words_of(cross, branches=True).splitlines()[2:4] == ["past ⌀ 80", "straight on, capped"]


def test_a_picture_in_space_shows_the_pipe_cut_open_and_which_way_is_down() -> None:
    figure = route_figure(SPACE, "mine")
    assert [axes.get_title("left") for axes in figure.axes].count(CUT_OPEN) == 1
    assert WORD in texts(figure)
    planar = route_figure(PLANE, "mine")
    assert CUT_OPEN not in texts(planar) and WORD not in texts(planar)


@pytest.mark.parametrize("slope", [-30.0, 0.0, 30.0])
def test_a_plan_of_a_sloping_route_says_which_way_is_down(slope: float) -> None:
    route = fitted(0).model_copy(update={"slope": math.radians(slope)})
    figure = route_figure(route, "mine")
    said = " ".join(texts(figure))
    assert (WORD in said.split()) == (slope != 0)
    assert ("it begins up at 30°" in said) == (slope > 0)
    assert ("it begins down at 30°" in said) == (slope < 0)


def test_a_long_route_in_space_is_cut_open_corner_by_corner() -> None:
    corners = [(90, "left", 0, 150), (75, "right", 90), (110, "left", 180)]
    figure = route_figure(PipeRoute.of(100, corners, [2500, 2200, 2300, 2400]), "mine")
    numbered = [axes for axes in figure.axes if [text.get_text() for text in axes.texts] in (["1"], ["2"], ["3"])]
    assert len(numbered) == 3
    assert all(axes.collections[0].get_paths() for axes in numbered)
    assert f"{CUT_OPEN}, corner by corner" in texts(figure)


def test_dials_mark_the_sides_of_branches() -> None:
    """Rolled by 90 deg, a branch to the right leaves downwards: the robot looks ahead, its left is left in the dial."""
    schedule = route_figure(SPACE, "mine").axes[-1]
    marks = [line.get_xydata() for line in schedule.lines if line.get_linewidth() == pytest.approx(1.4)]
    directions = [(mark[1] - mark[0]) / np.linalg.norm(mark[1] - mark[0]) for mark in marks]
    real = [axes[:, 0] for axes in SPACE.branches.axes]
    before = SPACE.legs.axes[[1, 3]]
    for direction, at, branch in zip(directions, before, (real[0], real[2]), strict=True):
        _, left, up = branch @ at
        across = np.array([-left, up]) / math.hypot(left, up)
        np.testing.assert_allclose(direction, across, atol=1e-9)
