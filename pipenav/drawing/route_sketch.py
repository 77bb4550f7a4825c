"""Dimensions of a route as it lies in a picture: lengths, corners, branches, the robot's way."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.dimensions import FREE, INK, ROBOT, DimensionedDrawing, number
from pipenav.drawing.labels import Labels, Place, around, beside
from pipenav.drawing.projection import View
from pipenav.drawing.words import side_of, size_of, words_of
from pipenav.pipes.route import PipeRoute
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHORT = 1e-6
"""Length in the picture below which a pipe points at the viewer [mm]."""


class RouteSketch(DimensionedDrawing):
    """Dimensions along the centre lines of a route and of its branches.

    Args:
        route: the route.
        axes: axes to draw on.
        view: projection of the picture.
    """

    def __init__(self, route: PipeRoute, axes: Axes, view: View) -> None:
        mm = m_to_mm(1.0)
        self.route, self.view, self.centre = route, view, mm * view.flat(route.centre_line)  # (corners + 2, 2)
        branches = route.branches
        ends = branches.start + branches.length[:, None] * branches.axes[:, :, 0]
        self.branches = mm * view.flat(np.stack([branches.start, ends], axis=1))  # (branches, 2, 2)
        half = mm * (np.concatenate([route.legs.radius, branches.radius]) + route.wall)
        pipes = np.concatenate([np.stack([self.centre[:-1], self.centre[1:]], axis=1), self.branches])
        around_pipes = [pipes + sign * half[:, None, None] for sign in (-1, 1)]
        super().__init__(axes, np.concatenate(around_pipes).reshape(-1, 2))
        self.half, self.along = half, _directions(pipes)
        self.labels = Labels(pipes, half, self.unit)
        for at in self.centre[1:-1]:
            self.labels.take("00", Place(at))

    def lengths(self) -> None:
        """Lengths of the straights: in the pipe where there is room, else beside it."""
        for i, length in enumerate(self.route.straights):
            start, end = self.centre[i : i + 2]
            middle, text = (start + end) / 2, number(m_to_mm(length))
            tilt = (math.degrees(math.atan2(self.along[i, 1], self.along[i, 0])) + 90.0) % 180.0 - 90.0
            if self.route.planar and self.half[i] > 1.5 * self.unit:
                place = Place(middle, tilt=tilt)
                self.labels.take(text, place)
                self.put(text, place, FREE)
            else:
                self.write(text, self._beside(start, end, i, tilt))

    def corners(self) -> None:
        """Numbers of the corners, at the corners."""
        frame = {"boxstyle": "circle,pad=0.25", "facecolor": "white", "edgecolor": INK, "linewidth": 0.8}
        for i, (x, y) in enumerate(self.centre[1:-1], 1):
            self.axes.text(x, y, str(i), color=INK, fontsize=8, ha="center", va="center", bbox=frame, zorder=8)

    def angles(self) -> None:
        """Angle, turn and bend radius of every corner, outside of it or where there is more room."""
        for i, corner in enumerate(self.route.corners):
            away = self.along[i] - self.along[i + 1]
            size = float(np.linalg.norm(away))
            away = away / size if size > SHORT else np.array([-self.along[i, 1], self.along[i, 0]])
            widest = float(self.half[i : i + 2].max())
            off = widest / max(math.sin(corner.angle / 2), 0.3) + 2 * self.unit
            nearer = around(self.centre[i + 1], off, away)
            self.write(words_of(corner), [*nearer, *around(self.centre[i + 1], off + 5 * self.unit, away)])

    def branch_sizes(self, angles: bool) -> None:
        """Bore and length of every branch, with its angle and side if asked, beyond its end or beside it."""
        legs = len(self.route.straights)
        found = [branch for corner in self.route.corners for branch in corner.branches]
        for i, branch in enumerate(found):
            (start, end), along = self.branches[i], self.along[legs + i]
            text = "\n".join(["branch", *side_of(branch)[:1], size_of(branch).replace(", capped", "")])
            text = text if angles else size_of(branch)
            near, far = (beside(end, gap * self.unit, along) for gap in (2.0, 6.0))
            sides = self._beside(start, end, legs + i)
            self.write(text, [near, *sides, *around(end, 3 * self.unit, along), far])

    def robot(self) -> None:
        """Arrows along which the robot comes and goes, or comes alone where a cap closes the end."""
        inside, outside = 2 * self.unit, 6 * self.unit
        first, last = self.along[0], self.along[len(self.route.straights) - 1]
        self.arrow(self.centre[0] - outside * first, self.centre[0] + inside * first, ROBOT, 2.4)
        if not self.route.capped:
            self.arrow(self.centre[-1] - inside * last, self.centre[-1] + outside * last, ROBOT, 2.4)
        else:
            self.write("cap", [beside(self.centre[-1], 2 * self.unit, last)])

    def directions(self) -> None:
        """Axes of the route's frame, below the picture's left end."""
        length = 7 * self.unit
        origin = self.frame().low + np.array([length, -0.4 * length])
        for name, axis in zip("xyz", np.eye(3), strict=True):
            tip = origin + length * self.view.flat(axis)
            self.arrow(origin, tip, INK, 1.0)
            self.text(tip + 1.8 * self.unit * self.view.flat(axis), name)

    def write(self, text: str, places: list[Place]) -> None:
        """Write a text at the place at which it covers least."""
        self.put(text, self.labels.best(text, places), "white")

    def put(self, text: str, place: Place, box: str) -> None:
        """Write a text at a place, in a box of a colour."""
        self.text(place.at, text, ha=place.ha, va=place.va, box=box, tilt=place.tilt)
        self.to_axes(self.labels.points(text, place))

    def _beside(self, start: Floats, end: Floats, pipe: int, tilt: float = 0.0) -> list[Place]:
        """Places on either side of a pipe of the picture, along its length."""
        across = np.array([-self.along[pipe, 1], self.along[pipe, 0]])
        off = self.half[pipe] + 2 * self.unit
        places = []
        for share in (0.5, 0.35, 0.65, 0.8):
            at = start + share * (end - start)
            for side in (off * across, -off * across):
                places.append(Place(at + side, tilt=tilt) if tilt else beside(at, off, side / off))
        return places


def _directions(pipes: Floats) -> Floats:
    """Unit vectors along pipes (k, 2, 2) in the picture, (k, 2); x for those that point at the viewer."""
    steps = pipes[:, 1] - pipes[:, 0]
    size = np.linalg.norm(steps, axis=1, keepdims=True)
    return np.where(size > SHORT, steps / np.maximum(size, SHORT), [1.0, 0.0])
