"""Proofs that a whole robot cannot pass: one of its links, or two neighbours, cannot even do it alone.

A link's heading goes from 0 to the second leg's direction, or the other way round to its opposite, tail first. Where
it is at a heading for which the corner has no room on either way, it cannot pass. In sharp corners a single link can
turn round in three points; then two links are asked, with the joint between them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.certify.cell_search import search
from pipenav.certify.cells import ROUNDING, Span
from pipenav.certify.model import Model
from pipenav.certify.push import pushed
from pipenav.certify.shapes import Shapes
from pipenav.certify.slide_interval import Height, slide_interval

HEADINGS = 721
"""Headings at which a link is tried, over a whole turn: every half degree."""

IN_BENDS = (0.4, 0.45, 0.5, 0.55, 0.6)
"""Headings at which a link is tried in a bend, as shares of the way: it has least room in the middle."""

PLACES = (5e-4, 1e-4, 2e-5)
"""Distances of the places at which a link is tried in a bend, each around those that the one before left open [m]."""


MOST_WORK = 150_000
"""Most cells of two headings that a search looks at: five times what the tightest proofs take."""


class LinkProof(NamedTuple):
    """A stretch of links that cannot pass.

    Attributes:
        first: index of its first link.
        last: index of its last link.
        headings: headings that have no room, one on each way round [rad]; empty where cells were searched.
        finest: width of the smallest cells that were searched, 0 where none were [rad].
        lacking: bore that is missing at least, as far as it is known [m].
    """

    first: int
    last: int
    headings: tuple[float, ...]
    finest: float
    lacking: float


def prove_by_link(model: Model) -> LinkProof | None:
    """A proof that a single link cannot pass; None where none was found.

    Args:
        model: what is certified; its robot stands free.
    """
    shapes = model.shapes(proof=True)
    alike: dict[bytes, LinkProof | None] = {}
    for link in range(len(shapes.lengths)):
        key = _key(shapes.stretch(link, link))
        if key not in alike:
            alike[key] = _link_proof(model, shapes, link)
    found = alike.values()
    return max((proof for proof in found if proof is not None), key=lambda proof: proof.lacking, default=None)


def prove(model: Model, resolution: float) -> LinkProof | None:
    """A proof that two neighbouring links cannot pass a mitre; None where none was found.

    Args:
        model: what is certified; its robot stands free.
        resolution: width of the smallest cells [rad].
    """
    if model.pipe.bend_radius:
        return None
    shapes = model.shapes(proof=True)
    links = len(shapes.lengths)
    # Only links that cannot turn directly are worth a search; it costs a second.
    tight = [link for link in range(links - 1) if _blocked(model, shapes.stretch(link, link), direct=True) is not None]
    seen: set[bytes] = set()
    for first in tight:
        pair = shapes.stretch(first, first + 1)
        if (key := _key(pair)) in seen:
            continue
        seen.add(key)
        spans = PairSpans(model, pair, first)
        result = search(spans, 2, resolution, MOST_WORK)
        if result.proven:
            return LinkProof(first, first + 1, (), result.finest, 0.0)
    return None


def _key(shapes: Shapes) -> bytes:
    """Equal for stretches of links that are alike."""
    return b"".join(np.round(part, 9).tobytes() for part in (*shapes.boxes, *shapes.discs, shapes.lengths))


def _link_proof(model: Model, shapes: Shapes, link: int) -> LinkProof | None:
    alone, ways = shapes.stretch(link, link), []
    for direct in (True, False):
        if (way := _blocked(model, alone, direct)) is None:
            return None
        ways.append(way)
    return LinkProof(link, link, tuple(way.heading for way in ways), 0.0, min(-way.room for way in ways))


class _Blocked(NamedTuple):
    """Heading at which a link has least room on its way [rad], and that room, which is negative [m]."""

    heading: float
    room: float


def _blocked(model: Model, shapes: Shapes, direct: bool) -> _Blocked | None:
    """Heading at which a link has no room on its way; None if it has room everywhere.

    Args:
        model: what is certified.
        shapes: parts of the link.
        direct: whether it turns to the second leg's direction, or the other way round to the opposite one.
    """
    end = model.turn if direct else model.turn - math.pi
    headings = end * (np.linspace(0.0, 1.0, HEADINGS)[1:-1] if not model.pipe.bend_radius else np.array(IN_BENDS))
    room = room_at(model, shapes, headings)
    least = int(room.argmin())
    if room[least] >= -ROUNDING:
        return None
    # The link must still be on its way there: at no heading up to that one does it fit into the second leg.
    before = np.linspace(0.0, headings[least], HEADINGS)
    step = abs(before[1]) * (float(shapes.lengths[0]) + model.robot.width)
    away = (_leg_room(model, shapes, before) < -step).all()
    return _Blocked(float(headings[least]), float(room[least])) if away else None


def _leg_room(model: Model, shapes: Shapes, headings: Floats) -> Floats:
    """Room of a link across the second leg, (n,) [m]."""
    return pushed(model, shapes, headings[:, None]).leg_gap


def room_at(model: Model, shapes: Shapes, headings: Floats) -> Floats:
    """Bore that a link has to spare at some headings, wherever it is in the corner, (n,) [m]; at most 0 counts.

    A value below zero is a proof that the link fits nowhere in the pipe at that heading.
    """
    if model.pipe.bend_radius:
        return np.array([_room_in_bend(model, shapes, float(heading)) for heading in headings])
    return pushed(model, shapes, headings[:, None]).gap


def _room_in_bend(model: Model, shapes: Shapes, heading: float) -> float:
    """Length of the free slides of a link in a bend, the largest of all heights of its rear end [m].

    Heights are tried so near to each other that a link at any other height is free only where one of these is; where
    one may be, but none is known to be, they are tried nearer to each other.
    """
    pipe, reach, walls = model.pipe, float(shapes.lengths.sum()) + model.robot.width, model.walls(shapes, True)
    top = pipe.tangent_length(-pipe.radius) * math.sin(model.turn) + 2 * reach + pipe.diameter
    y, room = np.arange(-pipe.radius - reach, top, PLACES[0]), -np.inf
    for apart, next_ in zip(PLACES, (*PLACES[1:], 0.0), strict=True):
        at = np.full((len(y), 1), heading)
        free = slide_interval(shapes, walls, at, 0.0, Height(y, apart / 2))
        length = np.where(free.high > -np.inf, free.high, -np.inf) - np.where(free.high > -np.inf, free.low, 0.0)
        room, y = float(length.max(initial=-np.inf)), y[length >= -ROUNDING]
        if not len(y) or not next_:
            break
        exact = slide_interval(shapes, walls, at[: len(y)], 0.0, Height(y, 0.0))
        if (exact.low <= exact.high).any():
            break
        parts = round(apart / next_)
        y = (y[:, None] + (np.arange(parts) + 0.5 - parts / 2) * next_).ravel()
    return room


FINE = 24 << 9
"""Headings of a whole turn at which the room of a single link is known, in the middle of as many cells."""


def _most_room(model: Model, shapes: Shapes) -> Floats:
    """Most room that a single link has in a mitre in each of `FINE` cells of its heading, (FINE,) [m]."""
    half = math.pi / FINE
    centres = np.asarray(-math.pi + (2 * np.arange(FINE) + 1) * half, float)
    middle = np.array([shapes.lengths[0] / 2, 0.0])  # translations are free, so the link may turn about its middle
    corners = np.hypot(*(np.abs(shapes.boxes.centre - middle) + shapes.boxes.half).T)
    furthest = max(corners.max(initial=0.0), np.hypot(*(shapes.discs.centre - middle).T).max(initial=0.0))
    return np.asarray(pushed(model, shapes, centres[:, None]).gap + 2 * furthest * half)


def _largest(most: Floats, centres: Floats, half: float) -> Floats:
    """Largest value in cells of a torus, which hold a whole number of fine ones or lie in one, (n,)."""
    cells = max(1, min(FINE, round(math.pi / half)))
    every = most.reshape(cells, -1).max(axis=1)
    return np.asarray(every[np.floor((centres + math.pi) / (2 * math.pi) * cells).astype(int) % cells])


class PairSpans:
    """Free headings of two neighbouring links in a mitre, for `search`; the further coordinate is not needed.

    Args:
        model: what is certified.
        shapes: parts of the two links.
        first: index of the first one.
    """

    def __init__(self, model: Model, shapes: Shapes, first: int) -> None:
        self._model, self._shapes = model, shapes
        lower, upper = model.limits
        joint = first  # a free robot's first link has no joint, so that joint i is the one after link i
        self._lower, self._upper = float(lower[joint]), float(upper[joint])
        boxes, discs, rear = shapes.boxes, shapes.discs, float(shapes.lengths[0])
        # The joint between the two stands still: parts of the first link are as far from it as from its front end.
        joint_at = np.array([[rear, 0.0], [0.0, 0.0]])
        corner = np.hypot(*(np.abs(boxes.centre - joint_at[boxes.link]) + boxes.half).T)
        middle = np.hypot(*(discs.centre - joint_at[discs.link]).T)
        self._furthest = float(max(corner.max(initial=0.0), middle.max(initial=0.0)))
        self._alone = [_most_room(model, shapes.stretch(link, link)) for link in range(2)]

    def __call__(self, centres: Floats, half: float) -> tuple[Span, Span]:
        """Spans of cells, see `pipenav.certify.cells.Evaluate`."""
        at = pushed(self._model, self._shapes, centres)
        bends = np.remainder(centres[:, 1] - centres[:, 0] + math.pi, 2 * math.pi) - math.pi
        within = (bends >= self._lower - 2 * half) & (bends <= self._upper + 2 * half)
        # A point moves by at most this; the push changes by as much again.
        moved = 2 * self._furthest * half + ROUNDING
        free = within & (at.gap >= -moved)
        for most, heading in zip(self._alone, centres.T, strict=True):
            free &= _largest(most, heading, half) >= -ROUNDING
        start = free & (np.abs(centres) <= half + 1e-9).all(axis=1)
        goal = free & (at.leg_gap >= -moved)
        sure = within & (at.gap >= 0)
        return _span(free, start, goal), _span(sure, start & sure, sure & (at.leg_gap >= 0))


def _span(free: Flags, start: Flags, goal: Flags) -> Span:
    """Spans of cells that need no further coordinate."""
    return Span(np.where(free, 0.0, np.inf), np.where(free, 0.0, -np.inf), start, goal)
