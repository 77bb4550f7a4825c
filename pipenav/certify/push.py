"""The push lemma: in a mitre, a chain with fixed headings fits exactly if it fits pushed into the outer corner.

Heights over the two legs' outer walls, s over the first and t over the second, are linear in a point. The corner's free
space is where -r <= min(s, t) <= r. Whatever part sees less width than another has a smaller r of its own. Proof:
docs/guides/certify.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.certify.corner_walls import width_seen
from pipenav.certify.model import Model
from pipenav.certify.shapes import Shapes


class Pushed(NamedTuple):
    """A chain with given headings, pushed into the outer corner of a mitre.

    Attributes:
        gap: distance that is left between the chain and the inner edge, over either leg's wall; negative where the
            chain does not fit at all, (n,) [m].
        leg_gap: room that the chain has across the second leg; negative where it does not fit, (n,) [m].
        origin: place of the first link's rear end, (n, 2) [m] in the canonical frame.
    """

    gap: Floats
    leg_gap: Floats
    origin: Floats


class _Heights(NamedTuple):
    """Heights over the walls of both legs, s in the first row, t in the second; each (2, n)."""

    least: Floats
    most: Floats


def pushed(model: Model, shapes: Shapes, headings: Floats) -> Pushed:
    """The chain pushed into the corner.

    Args:
        model: what is certified; its bend radius is taken for 0.
        shapes: parts of the chain.
        headings: headings of its links, (n, links) [rad].
    """
    turn = model.turn
    half_boxes = width_seen(model.pipe.diameter, shapes.boxes.height, model.bore) / 2
    half_discs = width_seen(model.pipe.diameter, shapes.discs.height, model.bore) / 2
    steps = shapes.lengths[:, None, None] * np.stack([np.cos(headings), np.sin(headings)], -1).swapaxes(0, 1)
    rear = np.concatenate([np.zeros((1, len(headings), 2)), np.cumsum(steps, axis=0)[:-1]])  # (links, n, 2)
    normals = np.array([[0.0, 1.0], [-math.sin(turn), math.cos(turn)]])
    boxes = [_box(shapes, i, rear, headings, normals) for i in range(len(half_boxes))]
    discs = [_disc(shapes, i, rear, headings, normals) for i in range(len(half_discs))]
    extents = [
        (_Heights(corners.min(axis=1), corners.max(axis=1)), r) for corners, r in zip(boxes, half_boxes, strict=True)
    ]
    for i, (middle, r) in enumerate(zip(discs, half_discs, strict=True)):
        radius = float(shapes.discs.radius[i])
        extents.append((_Heights(middle - radius, middle + radius), r))
    shift = np.max([-r - heights.least for heights, r in extents], axis=0)  # (2, n)
    room = np.min([r - heights.most for heights, r in extents], axis=0) - shift
    gap = np.full(len(headings), np.inf)
    for corners, r in zip(boxes, half_boxes, strict=True):
        gap = np.minimum(gap, r - _highest_of_box(corners + shift[:, None]))
    for i, (middle, r) in enumerate(zip(discs, half_discs, strict=True)):
        gap = np.minimum(gap, r - _highest_of_disc(middle + shift, float(shapes.discs.radius[i]), turn))
    origin = np.linalg.solve(normals, shift).T
    return Pushed(gap, room[1], origin)


def _box(shapes: Shapes, i: int, rear: Floats, headings: Floats, normals: Floats) -> Floats:
    """Heights of a box's corners in order around it, (2, 4, n) [m]."""
    link, half = shapes.boxes.link[i], shapes.boxes.half[i]
    corners = shapes.boxes.centre[i] + half * [[1, 1], [-1, 1], [-1, -1], [1, -1]]  # (4, 2)
    cos, sin = np.cos(headings[:, link]), np.sin(headings[:, link])
    x, y = corners.T[:, :, None]
    points = np.array([x * cos - y * sin, x * sin + y * cos]) + rear[link].T[:, None]  # (2, 4, n)
    return np.asarray(np.einsum("ab,bcn->acn", normals, points))


def _disc(shapes: Shapes, i: int, rear: Floats, headings: Floats, normals: Floats) -> Floats:
    """Heights of a disc's middle, (2, n) [m]."""
    link, (x, y) = shapes.discs.link[i], shapes.discs.centre[i]
    cos, sin = np.cos(headings[:, link]), np.sin(headings[:, link])
    return np.asarray(normals @ (rear[link].T + np.array([x * cos - y * sin, x * sin + y * cos])))


def _highest_of_box(corners: Floats) -> Floats:
    """Largest min(s, t) of a box's points, (n,): at a corner, or where a side crosses s = t."""
    best = corners.min(axis=0).max(axis=0)
    difference = corners[0] - corners[1]  # (4, n)
    for one, other in ((0, 1), (1, 2), (2, 3), (3, 0)):
        span = difference[one] - difference[other]
        share = difference[one] / np.where(span == 0.0, np.inf, span)
        at = corners[0, one] + share * (corners[0, other] - corners[0, one])
        best = np.where((share > 0) & (share < 1), np.maximum(best, at), best)
    return np.asarray(best)


def _highest_of_disc(middle: Floats, radius: float, turn: float) -> Floats:
    """Largest min(s, t) of a disc's points, (n,): its top over one leg, or the far point where s = t."""
    s, t = middle
    away = (s - t) / (2 * math.sin(turn / 2))
    crossing = (s + t) / 2 + math.cos(turn / 2) * np.sqrt(np.maximum(radius**2 - away**2, 0.0))
    lower = np.minimum(s, t)  # the smaller height counts all over the disc where it does so at its own top
    return np.asarray(np.where(np.abs(s - t) >= radius * (1 - math.cos(turn)), lower + radius, crossing))
