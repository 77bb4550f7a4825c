"""Places for texts in a drawing where they cover neither pipes nor each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats

LETTER, LINE = 1.05, 2.2
"""Width of a letter and height of a line at most, in units of a drawing (`DimensionedDrawing`)."""

GAP = 1.2
"""Distance below which texts, or a text and a pipe, touch [units]."""

COVERING, LATER = 1.0, 0.35
"""Cost of each point of a text that touches something, and of each place that comes later in the list."""


class Place(NamedTuple):
    """A place for a text: a point (2,) [mm], the text's alignment there, and its tilt [deg]."""

    at: Floats
    ha: str = "center"
    va: str = "center"
    tilt: float = 0.0


class Labels:
    """Texts that were placed, and the pipes around which they are.

    Args:
        pipes: ends of the pipes' axes in the picture, (pipes, 2, 2) [mm].
        half: half of each pipe's width in the picture, (pipes,) [mm].
        unit: unit of the drawing [mm].
    """

    def __init__(self, pipes: Floats, half: Floats, unit: float) -> None:
        self.pipes, self.half, self.unit = pipes, half, unit
        self._taken = np.zeros((0, 2))

    def best(self, text: str, places: Sequence[Place]) -> Place:
        """The place at which a text covers least, early ones preferred; it is taken from now on."""
        costs = [COVERING * self.covered(text, place) + LATER * i for i, place in enumerate(places)]
        chosen = places[int(np.argmin(costs))]
        self.take(text, chosen)
        return chosen

    def take(self, text: str, place: Place) -> None:
        """Take a place for a text."""
        self._taken = np.concatenate([self._taken, self.points(text, place)])

    def covered(self, text: str, place: Place) -> int:
        """Number of points of a text that touch a pipe or another text."""
        points = self.points(text, place)
        return int((self._near_pipes(points) | self._near_texts(points)).sum())

    def points(self, text: str, place: Place) -> Floats:
        """Points all over a text, (k, 2) [mm]."""
        lines = text.splitlines()
        width, height = LETTER * max(map(len, lines)), LINE * len(lines)
        left = {"left": 0.0, "center": -width / 2, "right": -width}[place.ha]
        low = {"bottom": 0.0, "center": -height / 2, "top": -height}[place.va]
        x, y = np.meshgrid(
            left + np.linspace(0, width, math.ceil(width) + 1), low + np.linspace(0, height, math.ceil(height) + 1)
        )
        c, s = math.cos(math.radians(place.tilt)), math.sin(math.radians(place.tilt))
        turned = np.stack([c * x - s * y, s * x + c * y], axis=-1).reshape(-1, 2)
        return np.asarray(place.at + self.unit * turned)

    def distance(self, points: Floats) -> Floats:
        """Distance of points (k, 2) to the nearest pipe, negative in it, (k,) [mm]."""
        start, step = self.pipes[:, 0], self.pipes[:, 1] - self.pipes[:, 0]
        from_start = points[:, None] - start
        share = np.clip((from_start * step).sum(axis=2) / np.maximum((step**2).sum(axis=1), 1e-9), 0.0, 1.0)
        off = np.linalg.norm(from_start - share[..., None] * step, axis=2) - self.half
        return np.asarray(off.min(axis=1))

    def _near_pipes(self, points: Floats) -> Flags:
        return np.asarray(self.distance(points) < 0.4 * GAP * self.unit)

    def _near_texts(self, points: Floats) -> Flags:
        gap = GAP * self.unit
        low, high = points.min(axis=0) - gap, points.max(axis=0) + gap
        near = self._taken[((self._taken > low) & (self._taken < high)).all(axis=1)]
        if not len(near):
            return np.zeros(len(points), bool)
        return np.asarray(np.linalg.norm(points[:, None] - near, axis=2).min(axis=1) < gap)


def around(point: Floats, distance: float, first: Floats, count: int = 12) -> list[Place]:
    """Places in all directions around a point, the first one in a given direction, then ever further from it.

    Args:
        point: the point, (2,) [mm].
        distance: distance of the texts' edges from it [mm].
        first: unit vector, (2,).
        count: number of places.
    """
    begin = math.atan2(first[1], first[0])
    steps = [((i + 1) // 2) * (1 if i % 2 else -1) for i in range(count)]
    angles = [begin + step * 2 * math.pi / count for step in steps]
    return [beside(point, distance, np.array([math.cos(angle), math.sin(angle)])) for angle in angles]


def beside(point: Floats, distance: float, direction: Floats, tilt: float = 0.0) -> Place:
    """The place at a distance from a point [mm], for a text that leads away from it in a direction (2,)."""
    ha = "center" if abs(direction[0]) < 0.4 else "left" if direction[0] > 0 else "right"
    va = "center" if abs(direction[1]) < 0.4 else "bottom" if direction[1] > 0 else "top"
    return Place(point + distance * direction, ha, va, tilt)
