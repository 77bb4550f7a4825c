"""A drawing of a route with its dimensions, in millimetres: from above where it is planar, else in space.

In space, and where there are many corners, a schedule below the picture shows every corner as it appears to a robot
that looks ahead and never rolls.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.corner import draw_walls
from pipenav.drawing.dimensions import (
    CENTRE,
    DIMENSION,
    EDGE,
    FREE,
    INK,
    ROBOT,
    TALLEST_IN,
    WIDTH_IN,
    DimensionedDrawing,
    frame_axes,
    number,
    save_figure,
    write_title,
)
from pipenav.drawing.projection import View, draw_tube
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_corner import Corner
from pipenav.units import m_to_mm, rad_to_deg

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELLED = 8
"""Corners of the longest route with dimensions in the picture; a longer one has them in its schedule alone."""

PER_ROW = 6
"""Corners in a row of the schedule."""

CELL, DIAL = 2.2, 0.45
"""Distance between two dials of the schedule, and their radius."""

ROW = 2.1
"""Distance between two rows of the schedule."""


STRAIGHT = 1e-6
"""Bend below which a corner counts as straight: reach of its mitre, and length of the two directions' difference."""


def draw_route(route: PipeRoute, name: str, path: Path) -> None:
    """Draw a route into a PNG file, under a name."""
    save_figure(route_figure(route, name), path)


def route_figure(route: PipeRoute, name: str) -> Figure:
    """The drawing of a route as a matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(facecolor="white", layout="constrained")
    few = len(route.corners) <= LABELLED
    axes, schedule = (figure.add_subplot(), None) if route.planar and few else figure.subplots(2, 1)
    tall = _plan(route, axes) if route.planar else _in_space(route, axes)
    shrink = min(1.0, TALLEST_IN / tall)
    below = 1.4
    if schedule is not None:
        below = _schedule(route, schedule)
        schedule.get_gridspec().set_height_ratios([tall * shrink, below])
        below += 1.0
    figure.set_size_inches(max(WIDTH_IN * shrink, 6.5) + 0.6, tall * shrink + below)
    reducers = sum(corner.to_diameter is not None for corner in route.corners)
    counts = (len(route.corners) - reducers, "corner"), (reducers, "reducer")
    many = ", ".join(f"{count if count > 1 else 'one'} {word}{'s' * (count > 1)}" for count, word in counts if count)
    bores = "-".join(number(m_to_mm(2 * radius)) for radius in dict.fromkeys(route.legs.radius.tolist()))
    bore = f"⌀ {bores} mm, wall {number(m_to_mm(route.wall))} mm"
    length = f"{sum(route.straights):.2f} m along the centre line, lengths from corner to corner"
    write_title(axes, f"{name}: {many}, {bore}", f"{length}; all lengths in mm")
    if route.planar:
        figure.legend(loc="outside lower center", ncols=4, fontsize=9, frameon=False, labelcolor=INK)
    return figure


def _plan(route: PipeRoute, axes: Axes) -> float:
    """Draw the route from above; return the height of the drawing at full width [in]."""
    draw_walls(axes, route)
    line = m_to_mm(1.0) * route.centre_line[:, :2]
    rounded = m_to_mm(1.0) * route.legs.line(0.0, 0.0)[:, :2]
    axes.plot(*rounded.T, color=CENTRE, linewidth=0.9, dashes=(12, 3, 2, 3), zorder=2, label="centre line")
    sketch = _Sketch(route, axes, line)
    sharp = (route.legs.reach > STRAIGHT) & (route.legs.bend <= route.legs.radius[:-1])
    inwards = np.diff(route.legs.axes[:, :2, 0], axis=0)[sharp] / np.sin(route.legs.turn_angle[sharp, None])
    edges = route.legs.start[1:, :2][sharp] + route.legs.radius[:-1][sharp, None] * inwards
    if len(edges):
        axes.plot(*m_to_mm(1.0) * edges.T, "o", color=EDGE, markersize=4, zorder=6, label="inner edge")
    if len(route.corners) <= LABELLED:
        sketch.lengths()
        sketch.angles()
    sketch.robot()
    sketch.corners()
    return frame_axes(axes, *sketch.frame())


def _in_space(route: PipeRoute, axes: Axes) -> float:
    """Draw the route in space; return the height of the drawing at full width [in]."""
    view = View.of(route)
    drawn = draw_tube(axes, route, view)
    sketch = _Sketch(route, axes, m_to_mm(1.0) * view.flat(route.centre_line))
    sketch.drawn.append(drawn)
    if len(route.corners) <= LABELLED:
        sketch.lengths()
    sketch.robot()
    sketch.corners()
    sketch.directions(view)
    tall = frame_axes(axes, *sketch.frame())
    axes.set_axis_off()
    return tall


class _Sketch(DimensionedDrawing):
    """Dimensions along the centre line as it lies in the picture, (corners + 2, 2) [mm]."""

    def __init__(self, route: PipeRoute, axes: Axes, line: Floats) -> None:
        self.route, self.centre = route, line
        self.outside = m_to_mm(float(route.legs.radius.max()) + route.wall)
        super().__init__(axes, np.concatenate([line - self.outside, line + self.outside]))
        steps = np.diff(line, axis=0)
        self.seen = np.linalg.norm(steps, axis=1)  # (legs,) lengths in the picture [mm]
        self.along = steps / self.seen[:, None]

    def lengths(self) -> None:
        """Lengths of the straights: in the pipe where there is room, else beside it."""
        for i, length in enumerate(self.route.straights):
            middle, along = self.centre[i : i + 2].mean(axis=0), self.along[i]
            tilt = (math.degrees(math.atan2(along[1], along[0])) + 90.0) % 180.0 - 90.0
            within = self.route.planar and self.outside > 1.5 * self.unit
            at = middle if within else self._beside(middle, along)
            self.text(at, number(m_to_mm(length)), box=FREE if within else "white", tilt=tilt)

    def robot(self) -> None:
        """Arrows along which the robot comes and goes."""
        inside, outside = 2 * self.unit, 6 * self.unit
        first, last = self.along[0], self.along[-1]
        self.arrow(self.centre[0] - outside * first, self.centre[0] + inside * first, ROBOT, 2.4)
        self.arrow(self.centre[-1] - inside * last, self.centre[-1] + outside * last, ROBOT, 2.4)

    def corners(self) -> None:
        """Numbers of the corners, at the corners."""
        frame = {"boxstyle": "circle,pad=0.25", "facecolor": "white", "edgecolor": INK, "linewidth": 0.8}
        for i, (x, y) in enumerate(self.centre[1:-1], 1):
            self.axes.text(x, y, str(i), color=INK, fontsize=8, ha="center", va="center", bbox=frame, zorder=8)

    def angles(self) -> None:
        """Angle, turn and bend radius of every corner, outside of it or, where no room is left, inside."""
        for i, corner in enumerate(self.route.corners):
            away = self.along[i] - self.along[i + 1]
            size = float(np.linalg.norm(away))
            away = away / size if size > STRAIGHT else np.array([-self.along[i, 1], self.along[i, 0]])
            off = self.outside / math.sin(corner.angle / 2) + 3 * self.unit
            points = [self.centre[i + 1] + off * direction for direction in (away, -away)]
            at = max(points, key=lambda point: min(self._pipe_distance(point), 3.5 * self.unit))
            direction = (at - self.centre[i + 1]) / off
            ha = "center" if abs(direction[0]) < 0.4 else "left" if direction[0] > 0 else "right"
            self.text(at - 1.5 * self.unit * direction, _words(corner), ha=ha)
            self.to_axes(at + np.array([9 * self.unit * np.sign(direction[0]), 0.0]))  # room for the text

    def directions(self, view: View) -> None:
        """Axes of the route's frame, below the picture's left end."""
        length = 7 * self.unit
        origin = self.frame().low + np.array([length, -0.4 * length])
        for name, axis in zip("xyz", np.eye(3), strict=True):
            tip = origin + length * view.flat(axis)
            self.arrow(origin, tip, INK, 1.0)
            self.text(tip + 1.8 * self.unit * view.flat(axis), name)

    def _beside(self, middle: Floats, along: Floats) -> Floats:
        """A point beside a leg's middle, on the side with more room."""
        across = (self.outside + 2 * self.unit) * np.array([-along[1], along[0]])
        return max((middle + across, middle - across), key=lambda point: min(self._pipe_distance(point), 3 * self.unit))

    def _pipe_distance(self, point: Floats) -> float:
        """Distance of a point to the nearest pipe in the picture [mm]."""
        from_start = point - self.centre[:-1]
        share = np.clip((from_start * self.along).sum(axis=1), 0.0, self.seen)
        return float(np.linalg.norm(from_start - share[:, None] * self.along, axis=1).min()) - self.outside


def _words(corner: Corner) -> str:
    """`65° left`, and on lines of their own the bend radius and the roll where there are such; a reducer's bore."""
    if corner.to_diameter is not None:
        shape = f"over {number(m_to_mm(corner.length))}" if corner.length else "in a step"
        return f"to ⌀ {number(m_to_mm(corner.to_diameter))}\n{shape}"
    bend = f"\nR {number(m_to_mm(corner.bend_radius))}" if corner.bend_radius else ""
    rolled = f"\nrolled {rad_to_deg(corner.roll):g}°" if corner.roll else ""
    return f"{rad_to_deg(corner.angle):g}° {corner.turn}{bend}{rolled}"


def _schedule(route: PipeRoute, axes: Axes) -> float:
    """Draw every corner as a dial that shows to which side the pipe bends; return the height of all [in]."""
    phi = np.linspace(0, 2 * math.pi, 60)
    rows = math.ceil(len(route.corners) / PER_ROW)
    axes.set(xlim=(-1.7, CELL * PER_ROW - 0.5), ylim=(-ROW * rows + 0.8, 1.3), aspect="equal")
    axes.set_axis_off()
    axes.text(-1.7, 1.05, "Corners as seen by a robot that looks ahead and never rolls", fontsize=10, color=INK)
    style: dict[str, Any] = {"ha": "center", "fontsize": 9, "color": DIMENSION}
    for i, (corner, inside) in enumerate(zip(route.corners, route.legs.inside, strict=True)):
        x, y = CELL * (i % PER_ROW), -ROW * (i // PER_ROW)
        axes.fill(x + DIAL * np.cos(phi), y + DIAL * np.sin(phi), facecolor=FREE, edgecolor=INK, linewidth=1)
        tip = np.array([-math.cos(inside), math.sin(inside)]) * 0.85 * DIAL  # left of the robot is left in the dial
        arrow = {"arrowstyle": "-|>", "color": EDGE, "linewidth": 2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (x + tip[0], y + tip[1]), (x - tip[0], y - tip[1]), arrowprops=arrow)
        axes.text(x - DIAL, y + DIAL, f"{i + 1}", ha="center", va="center", fontsize=10, color=INK, fontweight="bold")
        axes.text(x, y - DIAL - 0.12, _words(corner), va="top", **style)
        for at, straight in ((x - CELL / 2, i), (x + CELL / 2, i + 1)):
            if at < x or i + 1 == len(route.corners):
                axes.plot([at - CELL / 2 + DIAL, at + CELL / 2 - DIAL], [y, y], color=CENTRE, linewidth=1)
                axes.text(at, y + 0.1, number(m_to_mm(route.straights[straight])), **style)
    return 0.62 * (ROW * rows + 0.5)
