"""Proofs lose no free pose: poses near the bottleneck lie in their cells, and mistakes in the model are noticed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipenav.arrays import Flags, Floats
from pipenav.certify.model import Model
from pipenav.certify.motion_check import clearances
from pipenav.certify.push import pushed
from pipenav.certify.slide_interval import SeenWalls, slide_interval
from pipenav.certify.whole_proof import PairSpans
from pipenav.pipes import PipeCorner
from pipenav.robots import load_robot

WIDTH = math.radians(2.0)
"""Half width of the cells that are tried [rad]."""

ARMS = ("basic", "real-setup", "high-fidelity")
CORNERS = (
    PipeCorner.of(62, 60),
    PipeCorner.of(56, 90),
    PipeCorner.of(50, 120),
    PipeCorner.of(60, 60, bend_radius_mm=90),
)


def free_poses(model: Model, rng: np.random.Generator, n: int) -> tuple[Floats, Floats]:
    """Headings, (k, hinges), and slides, (k,), of poses at the corner that touch no wall, by distances alone.

    They are drawn around the corner without any of the formulas that are tested.
    """
    turn = model.turn
    headings = np.stack(
        [rng.uniform(-0.4, 0.6, n), rng.uniform(-0.2, turn, n), rng.uniform(0.2, turn + 0.4, n)], axis=1
    )
    poses = np.concatenate([(-model.pipe.inner_edge + rng.uniform(-0.32, -0.02, n))[:, None], headings], axis=1)
    found = poses[clear_of_walls(model, poses)]
    for _ in range(2):  # more of them, around those that were found
        near = np.repeat(found, 10, axis=0) + rng.normal(0.0, [0.003, 0.03, 0.03, 0.03], (10 * len(found), 4))
        found = np.concatenate([found, near[clear_of_walls(model, near)]])[:5000]
    return found[:, 1:], found[:, 0]


def clear_of_walls(model: Model, poses: Floats) -> Flags:
    """Poses, slides and headings (n, links), that shapely finds inside of the pipe."""
    import shapely

    from pipenav.robots.outline import link_outlines

    pipe = model.pipe.model_copy(update={"leg": 3.0})
    q = np.concatenate([poses[:, :2], np.diff(poses[:, 1:], axis=1)], axis=1)
    region = shapely.Polygon(np.concatenate([pipe.walls.outer, pipe.walls.inner[::-1]]))
    shapely.prepare(region)
    held = np.ones(len(q), bool)
    for polygon in (polygon for link in link_outlines(model.robot, q) for polygon in link):
        held &= shapely.covers(region, shapely.polygons(polygon))
    # A disc's polygon lies within it: poses of which it alone is free, by some hundredths of a millimetre, are not.
    held[held] = clearances(model, q[held], 0.0) > 0
    return held


def lost(model: Model, walls_of: Model, spread: float, n: int, seed: int) -> tuple[int, int]:
    """Number of free poses that no cell holds, and of all that were drawn.

    Args:
        model: what is true.
        walls_of: what the cells are computed for.
        spread: half width that the cells claim, where they are `WIDTH` [rad].
        n: poses to draw.
        seed: seed.
    """
    rng = np.random.default_rng(seed)
    headings, slides = free_poses(model, rng, n)
    centres = headings + rng.choice([-WIDTH, WIDTH], headings.shape)  # poses lie in corners of their cells
    every = np.concatenate([np.zeros((len(centres), 1)), centres], axis=1)
    shapes = walls_of.shapes(proof=True)
    cell = slide_interval(shapes, walls_of.walls(shapes, True), every, spread)
    outside = (slides < cell.low - 1e-6) | (slides > cell.high + 1e-6)
    return int(outside.sum()), len(slides)


@pytest.mark.parametrize("pipe", CORNERS, ids=lambda pipe: pipe.name)
@pytest.mark.parametrize("name", ARMS)
def test_no_free_pose_is_lost_from_its_cell(name: str, pipe: PipeCorner) -> None:
    model = Model(load_robot(name), pipe)
    missing, drawn = lost(model, model, WIDTH, 20_000, 1)
    assert drawn > 100
    assert missing == 0


def disagreements(model: Model, walls: SeenWalls) -> int:
    """Number of drawn poses on which the free slides for some walls and the distances to the true ones disagree."""
    rng = np.random.default_rng(11)
    headings = np.stack([rng.uniform(*ends, 20_000) for ends in ((-0.4, 0.6), (-0.2, 1.6), (0.2, 2.0))], axis=1)
    slides = -model.pipe.inner_edge + rng.uniform(-0.32, -0.02, len(headings))
    every = np.concatenate([np.zeros((len(headings), 1)), headings], axis=1)
    free = slide_interval(model.shapes(proof=True), walls, every)
    q = np.concatenate([slides[:, None], headings[:, :1], np.diff(headings, axis=1)], axis=1)
    away = np.minimum(np.abs(slides - free.low), np.abs(slides - free.high)) > 3e-3  # walls of bends have chords
    inside = (slides >= free.low) & (slides <= free.high)
    return int((away & (inside != (clearances(model, q, 0.0) > 0))).sum())


@pytest.mark.parametrize("pipe", [CORNERS[1], CORNERS[3]], ids=lambda pipe: pipe.name)
def test_a_forgotten_wall_is_noticed(pipe: PipeCorner) -> None:
    model = Model(load_robot("basic"), pipe.model_copy(update={"diameter": pipe.diameter + 0.02}))
    seen = model.walls(model.shapes(proof=True), False)
    assert disagreements(model, seen) == 0
    boxes = seen.boxes
    no_inner = boxes._replace(inner=boxes.inner._replace(y=boxes.inner.y + 10.0))
    no_outer = boxes._replace(outer=boxes.outer._replace(radius=boxes.outer.radius + 10.0))
    for forgotten in (no_inner, no_outer):
        assert disagreements(model, seen._replace(boxes=forgotten)) > 0


def test_half_the_erosion_is_noticed() -> None:
    model = Model(load_robot("basic"), CORNERS[0])
    assert lost(model, model, WIDTH / 2, 60_000, 2)[0] > 0


def test_a_wrong_width_is_noticed() -> None:
    model = Model(load_robot("basic"), CORNERS[0])
    narrow = model._replace(pipe=PipeCorner.of(58, 60))
    assert lost(model, narrow, 1e-6, 60_000, 3)[0] > 0


def test_a_forgotten_wall_is_noticed_by_the_closed_form() -> None:
    """In one leg alone, without the other's walls, a link would always find a heading at which it fits."""
    model = Model(load_robot("pirate"), PipeCorner.of(60, 60))
    link = model.shapes(proof=True).stretch(1, 1)
    headings = np.linspace(0.0, model.turn, 200)[:, None]
    assert pushed(model, link, headings).gap.min() < 0
    straight = Model(load_robot("pirate"), PipeCorner.of(60, 179))
    assert pushed(straight, link, np.zeros((1, 1))).gap.min() > 0


@pytest.mark.parametrize("angle", [40, 60, 120])
def test_cells_of_two_links_hold_every_free_heading(angle: float) -> None:
    model = Model(load_robot("pirate"), PipeCorner.of(66, angle))
    pair = model.shapes(proof=True).stretch(1, 2)
    rng = np.random.default_rng(13)
    headings = rng.uniform(-math.pi, math.pi, (100_000, 2))
    bend = np.remainder(headings[:, 1] - headings[:, 0] + math.pi, 2 * math.pi) - math.pi
    free = (pushed(model, pair, headings).gap >= 0) & (np.abs(bend) < 2.2)
    assert free.sum() > 500
    for cells in (24, 192, 1536):
        half = math.pi / cells
        centres = (np.floor((headings[free] + math.pi) / (2 * half)) + 0.5) * 2 * half - math.pi
        assert PairSpans(model, pair, 1)(centres, half)[0].free.all()


@pytest.mark.parametrize(("angle", "bore"), [(60, 63.80), (90, 57.72), (120, 48.79)])
def test_the_closed_form_is_that_of_a_single_link(angle: float, bore: float) -> None:
    """A link with discs of radius r at its ends, body width w and length L needs r + w/2 sin(a/2) + L/2 cos(a/2)."""
    half = math.radians(angle) / 2
    assert 1e3 * (0.016 + 0.009 * math.sin(half) + 0.05 * math.cos(half)) == pytest.approx(bore, abs=0.01)
    for diameter, fits in ((bore + 0.02, True), (bore - 0.02, False)):
        model = Model(load_robot("pirate"), PipeCorner.of(diameter, angle))
        link = model.shapes(proof=True).stretch(1, 1)
        gap = pushed(model, link, np.linspace(0.0, model.turn, 2001)[:, None]).gap.min()
        assert (gap >= 0) == fits


def test_the_push_lemma_holds_against_distances() -> None:
    """Pushed chains are free where distances to the walls say so too, and only there."""
    rng = np.random.default_rng(5)
    for angle in (45, 60, 90, 130):
        model = Model(load_robot("pirate"), PipeCorner.of(75, angle))
        shapes = model.shapes(proof=True)
        headings = np.sort(rng.uniform(0.0, model.turn, (300, 7)), axis=1)
        at = pushed(model, shapes, headings)
        clear = np.abs(at.gap) > 1e-4
        q = np.concatenate([at.origin, headings[:, :1], np.diff(headings, axis=1)], axis=1)
        # Pushed chains touch the outer walls, so their parts are taken a little smaller.
        near = clearances(model._replace(overlap=2e-5), q, 0.0)
        assert ((at.gap > 0) == (near > 0))[clear].all()
