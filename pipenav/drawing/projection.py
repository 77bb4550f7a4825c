"""A route seen from a point far away, from above and aside: the tube with its shadow on the ground, as polygons."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.route import PipeRoute
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ELEVATION = math.radians(30.0)
"""Angle by which the viewer looks down [rad]."""

AZIMUTHS = np.deg2rad(np.arange(5.0, 360.0, 10.0))
"""Azimuths from which the viewer may look [rad]."""

HIDING = 0.2
"""Cost of two straights of which one hides the other, as the share of a straight's length that would cost as much."""

SAMPLES = 20
"""Points along a straight in the test whether it hides another one."""

AROUND, PIECE = 24, 0.05
"""Strips around the tube, and the longest piece of a strip [m]: with small pieces, near ones hide far ones rightly."""

WALL_RGB, BORE_RGB, SHADOW = (0.50, 0.57, 0.64), (0.30, 0.34, 0.38), "#e6e9ed"


class View(NamedTuple):
    """A parallel projection.

    Attributes:
        to_viewer: unit vector, (3,).
        right, up: unit vectors of the picture, (3,).
    """

    to_viewer: Floats
    right: Floats
    up: Floats

    @classmethod
    def towards(cls, azimuth: float) -> View:
        """The view from an azimuth, counted from x to y [rad]."""
        c, s, ce, se = math.cos(azimuth), math.sin(azimuth), math.cos(ELEVATION), math.sin(ELEVATION)
        return cls(np.array([ce * c, ce * s, se]), np.array([-s, c, 0.0]), np.array([-se * c, -se * s, ce]))

    @classmethod
    def of(cls, route: PipeRoute) -> View:
        """The best view of a route: few straights hide others, and none appears much shortened."""

        def worth(view: View) -> float:
            seen = float(np.linalg.norm(view.flat(route.legs.axes[:, :, 0]), axis=1).min())
            return seen - HIDING * view.hidden(route)

        return max((cls.towards(azimuth) for azimuth in AZIMUTHS), key=worth)

    def hidden(self, route: PipeRoute) -> int:
        """Number of pairs of straights that are no neighbours and lie over each other in the picture."""
        share = np.linspace(0, 1, SAMPLES)[:, None]
        line = self.flat(route.centre_line)
        points = line[:-1, None] + share * np.diff(line, axis=0)[:, None]  # (legs, SAMPLES, 2)
        pairs = [(i, j) for j in range(len(points)) for i in range(j - 1)]
        apart = [np.linalg.norm(points[i][:, None] - points[j], axis=-1).min() for i, j in pairs]
        return int(np.sum(np.array(apart) < 2 * (route.legs.radius.max() + route.wall)))

    def flat(self, points: Floats) -> Floats:
        """Points (..., 3) projected into the picture, (..., 2)."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)


def draw_tube(axes: Axes, route: PipeRoute, view: View) -> Floats:
    """Draw the tube and its shadow, in millimetres of the picture; return all their points, (k, 2) [mm]."""
    from matplotlib.collections import PolyCollection

    quads = wall_quads(route)  # (q, 4, 3)
    normal = np.cross(quads[:, 1] - quads[:, 0], quads[:, 3] - quads[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    light = view.to_viewer + view.up - 0.6 * view.right
    outside = normal @ view.to_viewer > 0
    shade = 0.72 + 0.4 * np.clip(normal @ light / np.linalg.norm(light), 0, 1)
    colours = np.where(outside[:, None], np.minimum(shade[:, None] * WALL_RGB, 1.0), BORE_RGB)
    order = np.argsort(quads.mean(axis=1) @ view.to_viewer)
    ground = quads.copy()
    ground[..., 2] = quads[..., 2].min() - route.diameter
    shadow, tube = (m_to_mm(1.0) * view.flat(part) for part in (ground, quads[order]))
    axes.add_collection(PolyCollection(list(shadow), facecolors=SHADOW, edgecolors=SHADOW, linewidths=0.3, zorder=0))
    axes.add_collection(
        PolyCollection(list(tube), facecolors=colours[order], edgecolors=colours[order], linewidths=0.3, zorder=2)
    )
    return np.concatenate([shadow, tube]).reshape(-1, 2)


def wall_quads(route: PipeRoute) -> Floats:
    """The outer surface in small pieces, corners in order, counter-clockwise seen from outside, (q, 4, 3) [m]."""
    around = np.arange(AROUND) * 2 * math.pi / AROUND
    lines = route.legs.lines((route.legs.radius + route.wall)[None], around)  # (AROUND, p, 3)
    pieces = []
    for start, end in pairwise(lines.swapaxes(0, 1)):
        length = np.linalg.norm((end - start).mean(axis=0))
        share = np.linspace(0, 1, math.ceil(length / PIECE) + 1)[:, None, None]
        rings = start + share * (end - start)  # (pieces + 1, AROUND, 3)
        beside = np.roll(rings, -1, axis=1)
        pieces.append(np.stack([rings[:-1], rings[1:], beside[1:], beside[:-1]], axis=2).reshape(-1, 4, 3))
    quads = np.concatenate(pieces)
    return quads[:, ::-1]
