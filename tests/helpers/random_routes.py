"""Routes drawn at random, and points in them."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from pipenav.arrays import Floats, Ints
from pipenav.pipes.centre_lines import CentreLines
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_checks import CrossesItself

diameters = st.floats(40, 300)


angles = st.one_of(st.floats(30, 180), st.sampled_from([30.0, 55.0, 90.0, 180.0]))


turns = st.sampled_from(["left", "right"])


rolls = st.one_of(st.sampled_from([0.0, 90.0, 180.0, 270.0]), st.floats(-360, 360))


flat_rolls = st.sampled_from([0.0, 0.0, 180.0, -180.0, 360.0])


extras = st.one_of(st.integers(0, 100), st.integers(300, 2500))


mitres = st.just(0.0)


bends = st.one_of(mitres, st.floats(0.75, 5.0), st.sampled_from([0.75, 1.0, 1.5]))


@st.composite
def routes(
    draw: st.DrawFn,
    rolls: st.SearchStrategy[float] = rolls,
    extras: st.SearchStrategy[int] = extras,
    bends: st.SearchStrategy[float] = mitres,
    most: int = 5,
) -> PipeRoute:
    """Routes whose straights are as long as their corners need, and some more [mm]; bend radii in diameters."""
    diameter = draw(st.floats(40, 150))
    drawn = draw(st.lists(st.tuples(angles, turns, rolls, bends), min_size=1, max_size=most))
    corners = [(angle, turn, roll, bend * diameter) for angle, turn, roll, bend in drawn]
    outside = diameter / 2 + 3
    reach = [0.0, *(max(outside, bend) / math.tan(math.radians(angle) / 2) for angle, _, _, bend in corners), 0.0]
    needed = [math.ceil(a + b + 0.1 * diameter) for a, b in pairwise(reach)]
    straights = [least + draw(extras) for least in needed]
    try:
        return PipeRoute.of(diameter, corners, straights)
    except CrossesItself:
        assume(False)
        raise


planar_routes = routes(flat_rolls)


bent_routes = routes(bends=bends)


planar_bent_routes = routes(flat_rolls, bends=bends)


def rounded_length(route: PipeRoute) -> float:
    """Length of the rounded centre line [m]."""
    legs = route.legs
    return float(sum(route.straights) - (legs.bend * (2 * legs.reach - legs.turn_angle)).sum())


def along_centre(route: PipeRoute, count: int, margin: float = 0.0) -> Floats:
    """Points along the rounded centre line, away from the open ends by a margin [m], (count, 3)."""
    line = route.legs.line(0.0, 0.0)
    lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    at = np.linspace(margin, lengths[-1] - margin, count)
    return np.stack([np.interp(at, lengths, x) for x in line.T], axis=1)


def inside(route: PipeRoute, seed: int = 0, count: int = 40) -> Floats:
    """Points in the bore of every leg, between its mitres, (legs, count, 3)."""
    rng = np.random.default_rng(seed)
    around, (off, share) = rng.uniform(0, 2 * math.pi, count), rng.uniform(0.001, 0.999, (2, count))
    lines = route.legs.lines(off * route.radius, around)
    return np.moveaxis(lines[:, :-1] + share[:, None, None] * np.diff(lines, axis=1), 1, 0)


def leg_of(route: PipeRoute, points: Floats) -> Ints:
    """The leg that each of the points (..., 2) or (..., 3) belongs to, counted from 0: (...)."""
    dimensions = points.shape[-1]
    located = CentreLines.of([route], dimensions).locate(points.reshape(1, -1, dimensions))
    return located.leg.reshape(points.shape[:-1])
