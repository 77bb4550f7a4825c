"""A drawing of a pipe from above, with its dimensions, in millimetres.

Everything is laid out for a left turn and mirrored for a right one. The outside of the corner is always free, whatever
the angle, so what does not fit inside the pipe is written there.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipenav.pipe import Array, Pipe
from pipenav.units import m_to_mm, rad_to_deg

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WALL = "#4a5560"
FREE = "#eaf0f6"
CENTRE = "#8796a5"
DIMENSION = "#1b4f8a"
EDGE = "#c62828"
ROBOT = "#2e7d32"
INK = "#20262c"

WIDTH_IN = 8.6
TALLEST_IN = 10.0
DPI = 160


def draw_pipe(pipe: Pipe, path: Path) -> None:
    """Draw the pipe into a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = pipe_figure(pipe)
    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=DPI, bbox_inches="tight", pad_inches=0.2)


def pipe_figure(pipe: Pipe) -> Figure:
    """The drawing as a matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(facecolor="white", layout="constrained")
    axes = figure.add_subplot()
    sketch = _Sketch(pipe, axes)
    sketch.pipe_itself()
    sketch.dimensions()
    sketch.robot()
    low, high = sketch.frame()
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    axes.grid(color="#e3e7eb", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(color="#b4bec8", labelcolor=INK, labelsize=8)
    for spine in axes.spines.values():
        spine.set_color("#b4bec8")
    tall = (high[1] - low[1]) / (high[0] - low[0]) * WIDTH_IN
    shrink = min(1.0, TALLEST_IN / tall)
    figure.set_size_inches(max(WIDTH_IN * shrink, 6.5) + 0.6, tall * shrink + 1.4)
    axes.set_title(_title(pipe), loc="left", fontsize=14, fontweight="bold", color=INK, pad=26)
    axes.annotate(
        _facts(pipe), (0, 1), (0, 9), xycoords="axes fraction", textcoords="offset points", fontsize=9.5, color=INK
    )
    figure.legend(loc="outside lower center", ncols=4, fontsize=9, frameon=False, labelcolor=INK)
    return figure


def draw_walls(axes: Axes, pipe: Pipe) -> None:
    """Fill the free space and the walls of a pipe, in millimetres of the pipe's frame."""
    inner, outer = m_to_mm(1.0) * pipe.walls.inner, m_to_mm(1.0) * pipe.walls.outer
    axes.fill(*np.concatenate([outer, inner[::-1]]).T, color=FREE, zorder=1)
    for near, offset in ((inner, pipe.radius + pipe.wall), (outer, -pipe.radius - pipe.wall)):
        far = m_to_mm(1.0) * pipe.line(offset)
        outline = np.concatenate([near, far[::-1]])
        label = "wall" if near is inner else None
        axes.fill(*outline.T, facecolor=WALL, edgecolor=WALL, linewidth=0.8, zorder=3, label=label)


class _Sketch:
    """The parts of one drawing. Coordinates are those of a left turn [mm]; `unit` is about a hundredth of its width."""

    def __init__(self, pipe: Pipe, axes: Axes) -> None:
        self.pipe, self.axes = pipe, axes
        self.radius, self.wall, self.leg = m_to_mm(pipe.radius), m_to_mm(pipe.wall), m_to_mm(pipe.leg)
        self.outside = self.radius + self.wall
        self.half = pipe.angle / 2
        self.along = np.array([-math.cos(pipe.angle), math.sin(pipe.angle)])  # the second leg
        self.inwards = np.array([-math.sin(pipe.angle), -math.cos(pipe.angle)])  # its side inside the turn
        self.bisector = np.array([-math.cos(self.half), math.sin(self.half)])  # from the corner into the inside
        outside = pipe.radius + pipe.wall
        outline = m_to_mm(1.0) * np.concatenate([pipe.line(offset) for offset in (-outside, outside)])
        self.unit = float(np.ptp(outline, axis=0).max()) / 75
        self.drawn = [outline]

    def frame(self) -> tuple[Array, Array]:
        """The corners of all that was drawn, with a margin [mm]."""
        points = np.concatenate(self.drawn)
        return points.min(axis=0) - 4 * self.unit, points.max(axis=0) + 4 * self.unit

    def pipe_itself(self) -> None:
        """Free space, walls, centre line and the inner edge."""
        draw_walls(self.axes, self.pipe)
        centre = m_to_mm(1.0) * self.pipe.line(0.0)
        self.axes.plot(*centre.T, color=CENTRE, linewidth=0.9, dashes=(12, 3, 2, 3), zorder=2, label="centre line")
        if self.pipe.angle < math.pi:
            edge = self._place(m_to_mm(self.pipe.apex(self.pipe.radius)) * self.bisector)
            self.axes.plot(*edge, "o", color=EDGE, markersize=7, markeredgecolor="white", zorder=6, label="inner edge")

    def dimensions(self) -> None:
        """Angle, diameter, leg, wall and, where there is one, the bend."""
        arc = self._angle()
        self._diameter(arc)
        below = -self.outside - 7 * self.unit
        for end, start in ((-self.leg, -self.outside), (0.0, 0.0)):
            self._line((end, start - self.unit), (end, below - self.unit))
        self._double_arrow((-self.leg, below), (0.0, below))
        self._text((-self.leg / 2, below), f"leg {_number(self.leg)}", box="white")
        straight = m_to_mm(self.pipe.tangent_length(-self.pipe.radius))  # the outer wall's
        tip = (0.4 * max(straight, 0) + 0.6 * self.leg) * self.along - (self.radius + self.wall / 2) * self.inwards
        self._callout(tip, tip - 6 * self.unit * self.inwards, f"wall {_number(self.wall)}")
        if self.pipe.bend_radius:
            self._bend()

    def robot(self) -> None:
        """Where the robot comes from and where it goes."""
        into, out = np.array([1.0, 0.0]), self.along
        inside, outside = 3 * self.unit, 9 * self.unit
        self._arrow(-(self.leg + outside) * into, -(self.leg - inside) * into, ROBOT, 2.4)
        self._arrow((self.leg - inside) * out, (self.leg + outside) * out, ROBOT, 2.4)
        self.axes.plot([], [], color=ROBOT, linewidth=2.4, label="way of the robot")

    def _angle(self) -> float:
        """The interior angle, as an arc where its text fits between the legs; returns the arc's radius."""
        behind_bend = m_to_mm(self.pipe.apex(-self.pipe.radius - self.pipe.wall))
        if behind_bend > 30 * self.unit:  # a wide bend leaves the corner of the centre lines free
            radius = behind_bend / 2
        else:
            before_wall = m_to_mm(self.pipe.apex(self.pipe.radius + self.pipe.wall)) + 5 * self.unit
            radius = max((self.outside + 2 * self.unit) / math.sin(self.half), before_wall)
            radius = min(radius, 0.93 * self.leg)
        phi = np.linspace(math.pi - self.pipe.angle, math.pi, 91)
        arc = radius * np.stack([np.cos(phi), np.sin(phi)], axis=1)
        self.axes.plot(*self._place(arc).T, color=DIMENSION, linewidth=1.0, zorder=5)
        for tip, before in ((0, 4), (-1, -5)):
            self._arrow(arc[before], arc[tip], DIMENSION, 1.0)
        self._text((radius + 3.5 * self.unit) * self.bisector, f"{rad_to_deg(self.pipe.angle):g}°", box="white")
        return radius

    def _diameter(self, arc: float) -> None:
        """The diameter, on the straight part of the first leg and away from the angle's arc."""
        bend = max(m_to_mm(self.pipe.inner_edge), 0.0)
        places = [bend + share * (self.leg - bend) for share in (0.7, 0.5, 0.8, 0.35)]
        x = -max(places, key=lambda place: min(abs(place - 4 * self.unit - arc), 9 * self.unit))
        self._double_arrow((x, -self.radius), (x, self.radius))
        text = f"⌀ {_number(2 * self.radius)}"
        if self.radius > 3 * self.unit:
            self._text((x + 1.2 * self.unit, -0.45 * self.radius), text, ha="left", box=FREE)
        else:  # too narrow for text inside
            wall = np.array([x, self.outside])
            self._callout(wall, wall + np.array([0.0, 6 * self.unit]), text)

    def _bend(self) -> None:
        """The centre line's radius, and the crossing of the centre lines from which legs are measured."""
        start = m_to_mm(self.pipe.tangent_length(0.0))
        for end in ((-start, 0.0), start * self.along):
            self._line(end, (0.0, 0.0))
        crown = m_to_mm(self.pipe.apex(0.0)) * self.bisector
        outside = (m_to_mm(self.pipe.apex(-self.pipe.radius - self.pipe.wall)) - 6 * self.unit) * self.bisector
        self._callout(crown, outside, f"bend radius {_number(m_to_mm(self.pipe.bend_radius))}")

    def _place(self, points: Any) -> Array:
        """Points of a left turn, where this pipe has them."""
        placed: Array = np.asarray(points, float) * np.array([1.0, self.pipe.side])
        self.drawn.append(np.atleast_2d(placed))
        return placed

    def _line(self, start: Any, end: Any) -> None:
        self.axes.plot(*self._place([start, end]).T, color=DIMENSION, linewidth=0.6, zorder=4)

    def _double_arrow(self, start: Any, end: Any) -> None:
        self._arrow(start, end, DIMENSION, 1.0, style="<|-|>")

    def _arrow(self, start: Any, end: Any, colour: str, width: float, style: str = "-|>") -> None:
        arrow = {"arrowstyle": style, "color": colour, "linewidth": width, "mutation_scale": 8 + 4 * width}
        head, tail = tuple(self._place(end)), tuple(self._place(start))
        self.axes.annotate("", head, tail, arrowprops={**arrow, "shrinkA": 0, "shrinkB": 0}, zorder=5)

    def _callout(self, tip: Array, foot: Array, text: str) -> None:
        """An arrow to `tip`, with text at its foot, on the side that leads away from the tip."""
        self._arrow(foot, tip, DIMENSION, 0.9)
        away, up = (foot - tip) * [1.0, self.pipe.side] / float(np.linalg.norm(foot - tip))
        ha = "center" if abs(away) < 0.3 else "left" if away > 0 else "right"
        va = "center" if abs(up) < 0.3 else "bottom" if up > 0 else "top"
        self._text(foot, f" {text} ", ha=ha, va=va, box="white")
        self._place(foot + np.array([math.copysign(10 * self.unit, away), 0.0]))  # room for the text

    def _text(self, at: Any, text: str, ha: str = "center", va: str = "center", box: str | None = None) -> None:
        frame = {"boxstyle": "round,pad=0.2", "facecolor": box, "edgecolor": "none"} if box else None
        x, y = self._place(at)
        self.axes.text(x, y, text, color=DIMENSION, fontsize=10, ha=ha, va=va, bbox=frame, zorder=6)


def _title(pipe: Pipe) -> str:
    if pipe.angle == math.pi:
        return f"Straight pipe, {_number(m_to_mm(pipe.diameter))} mm"
    bend = f"bend radius {_number(m_to_mm(pipe.bend_radius))} mm" if pipe.bend_radius else "mitre"
    return f"Pipe corner, {_number(m_to_mm(pipe.diameter))} mm, {rad_to_deg(pipe.angle):g}°, {pipe.turn} turn, {bend}"


def _facts(pipe: Pipe) -> str:
    if pipe.angle == math.pi:
        return "all lengths in mm"
    gap, edge = m_to_mm(pipe.gap), m_to_mm(pipe.inner_edge)
    return f"gap across the corner {gap:.1f}, inner wall turns {edge:.1f} before the corner; all lengths in mm"


def _number(mm: float) -> str:
    return f"{round(mm, 1):g}"
