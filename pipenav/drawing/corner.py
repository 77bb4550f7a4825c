"""A drawing of a corner from above, with its dimensions, in millimetres.

Everything is laid out for a left turn and mirrored for a right one. The outside of the corner is always free, whatever
the angle, so what does not fit inside the pipe is written there.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.dimensions import (
    CENTRE,
    DIMENSION,
    EDGE,
    FREE,
    INK,
    ROBOT,
    TALLEST_IN,
    WALL,
    WIDTH_IN,
    DimensionedDrawing,
    frame_axes,
    number,
    save_figure,
    write_title,
)
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.units import m_to_mm, rad_to_deg

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_pipe(pipe: PipeCorner, path: Path) -> None:
    """Draw a corner into a PNG file."""
    save_figure(pipe_figure(pipe), path)


def pipe_figure(pipe: PipeCorner) -> Figure:
    """The drawing of a corner as a matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(facecolor="white", layout="constrained")
    axes = figure.add_subplot()
    sketch = _Sketch(pipe, axes)
    sketch.pipe_itself()
    sketch.dimensions()
    sketch.robot()
    low, high = sketch.frame()
    tall = frame_axes(axes, low, high)
    shrink = min(1.0, TALLEST_IN / tall)
    figure.set_size_inches(max(WIDTH_IN * shrink, 6.5) + 0.6, tall * shrink + 1.4)
    write_title(axes, _title(pipe), _facts(pipe))
    figure.legend(loc="outside lower center", ncols=4, fontsize=9, frameon=False, labelcolor=INK)
    return figure


def draw_walls(axes: Axes, pipe: Pipe) -> None:
    """Fill the free space and the walls of a planar pipe, in millimetres of its frame."""
    axes.fill(*m_to_mm(1.0) * free_outline(pipe).T, color=FREE, zorder=1)
    for i, side in enumerate(pipe.wall_sides):
        outline = m_to_mm(1.0) * np.concatenate([side.face, side.back[::-1]])
        label = None if i else "wall"
        axes.fill(*outline.T, facecolor=WALL, edgecolor=WALL, linewidth=0.8, zorder=3, label=label)


def free_outline(pipe: Pipe) -> Floats:
    """Outline of a planar pipe's free space, open ends closed by straight lines, (k, 2) [m]."""
    segments = pipe.segments
    joined = (segments[:-1, 1] == segments[1:, 0]).all(axis=1)
    if not joined.any():  # those of a corner to the right are told from the last one on
        segments = segments[::-1]
    return segments.reshape(-1, 2)


class _Sketch(DimensionedDrawing):
    """The parts of one drawing, in the coordinates of a left turn [mm]."""

    def __init__(self, pipe: PipeCorner, axes: Axes) -> None:
        outside = pipe.radius + pipe.wall
        outline = m_to_mm(1.0) * np.concatenate([pipe.line(offset) for offset in (-outside, outside)])
        super().__init__(axes, outline, pipe.turn_sign)
        self.pipe = pipe
        self.radius, self.wall, self.leg = m_to_mm(pipe.radius), m_to_mm(pipe.wall), m_to_mm(pipe.leg)
        self.outside = self.radius + self.wall
        self.half = pipe.angle / 2
        self.along = np.array([-math.cos(pipe.angle), math.sin(pipe.angle)])  # along the second leg
        self.inwards = np.array([-math.sin(pipe.angle), -math.cos(pipe.angle)])  # from the second leg into the turn
        self.bisector = np.array([-math.cos(self.half), math.sin(self.half)])  # from the corner into the inside

    def pipe_itself(self) -> None:
        """Free space, walls, centre line and the inner edge."""
        draw_walls(self.axes, self.pipe)
        centre = m_to_mm(1.0) * self.pipe.line(0.0)
        self.axes.plot(*centre.T, color=CENTRE, linewidth=0.9, dashes=(12, 3, 2, 3), zorder=2, label="centre line")
        if self.pipe.angle < math.pi:
            edge = self.to_axes(m_to_mm(self.pipe.apex(self.pipe.radius)) * self.bisector)
            self.axes.plot(*edge, "o", color=EDGE, markersize=7, markeredgecolor="white", zorder=6, label="inner edge")

    def dimensions(self) -> None:
        """Dimensions: angle, diameter, leg, wall and, where there is one, the bend."""
        arc = self._angle()
        self._diameter(arc)
        below = -self.outside - 7 * self.unit
        for end, start in ((-self.leg, -self.outside), (0.0, 0.0)):
            self.line((end, start - self.unit), (end, below - self.unit))
        self.double_arrow((-self.leg, below), (0.0, below))
        self.text((-self.leg / 2, below), f"leg {number(self.leg)}", box="white")
        straight = m_to_mm(self.pipe.tangent_length(-self.pipe.radius))  # the outer wall's
        tip = (0.4 * max(straight, 0) + 0.6 * self.leg) * self.along - (self.radius + self.wall / 2) * self.inwards
        self.callout(tip, tip - 6 * self.unit * self.inwards, f"wall {number(self.wall)}")
        if self.pipe.bend_radius:
            self._bend()

    def robot(self) -> None:
        """Arrows along which the robot comes and goes."""
        into, out = np.array([1.0, 0.0]), self.along
        inside, outside = 3 * self.unit, 9 * self.unit
        self.arrow(-(self.leg + outside) * into, -(self.leg - inside) * into, ROBOT, 2.4)
        self.arrow((self.leg - inside) * out, (self.leg + outside) * out, ROBOT, 2.4)
        self.axes.plot([], [], color=ROBOT, linewidth=2.4, label="robot's direction of travel")

    def _angle(self) -> float:
        """Draw the interior angle as an arc where its text fits between the legs; return the arc's radius [mm]."""
        behind_bend = m_to_mm(self.pipe.apex(-self.pipe.radius - self.pipe.wall))
        if behind_bend > 30 * self.unit:  # a wide bend leaves the corner of the centre lines free
            radius = behind_bend / 2
        else:
            before_wall = m_to_mm(self.pipe.apex(self.pipe.radius + self.pipe.wall)) + 5 * self.unit
            radius = max((self.outside + 2 * self.unit) / math.sin(self.half), before_wall)
            radius = min(radius, 0.93 * self.leg)
        phi = np.linspace(math.pi - self.pipe.angle, math.pi, 91)
        arc = radius * np.stack([np.cos(phi), np.sin(phi)], axis=1)
        self.axes.plot(*self.to_axes(arc).T, color=DIMENSION, linewidth=1.0, zorder=5)
        for tip, before in ((0, 4), (-1, -5)):
            self.arrow(arc[before], arc[tip], DIMENSION, 1.0)
        self.text((radius + 3.5 * self.unit) * self.bisector, f"{rad_to_deg(self.pipe.angle):g}°", box="white")
        return radius

    def _diameter(self, arc: float) -> None:
        """The diameter, on the straight part of the first leg and away from the angle's arc of a radius [mm]."""
        bend = max(m_to_mm(self.pipe.inner_edge), 0.0)
        distances = [bend + share * (self.leg - bend) for share in (0.7, 0.5, 0.8, 0.35)]
        x = -max(distances, key=lambda distance: min(abs(distance - 4 * self.unit - arc), 9 * self.unit))
        self.double_arrow((x, -self.radius), (x, self.radius))
        text = f"⌀ {number(2 * self.radius)}"
        if self.radius > 3 * self.unit:
            self.text((x + 1.2 * self.unit, -0.45 * self.radius), text, ha="left", box=FREE)
        else:  # too narrow for text inside
            wall = np.array([x, self.outside])
            self.callout(wall, wall + np.array([0.0, 6 * self.unit]), text)

    def _bend(self) -> None:
        """The centre line's radius, and the crossing of the legs' axes from which legs are measured."""
        start = m_to_mm(self.pipe.tangent_length(0.0))
        for end in ((-start, 0.0), start * self.along):
            self.line(end, (0.0, 0.0))
        crown = m_to_mm(self.pipe.apex(0.0)) * self.bisector
        outside = (m_to_mm(self.pipe.apex(-self.pipe.radius - self.pipe.wall)) - 6 * self.unit) * self.bisector
        self.callout(crown, outside, f"bend radius {number(m_to_mm(self.pipe.bend_radius))}")


def _title(pipe: PipeCorner) -> str:
    if pipe.angle == math.pi:
        return f"Straight pipe, {number(m_to_mm(pipe.diameter))} mm"
    bend = f"bend radius {number(m_to_mm(pipe.bend_radius))} mm" if pipe.bend_radius else "mitre"
    return f"Pipe corner, {number(m_to_mm(pipe.diameter))} mm, {rad_to_deg(pipe.angle):g}°, {pipe.turn} turn, {bend}"


def _facts(pipe: PipeCorner) -> str:
    if pipe.angle == math.pi:
        return "all lengths in mm"
    gap, edge = m_to_mm(pipe.gap), m_to_mm(pipe.inner_edge)
    return f"gap across the corner {gap:.1f}, inner wall turns {edge:.1f} before the corner; all lengths in mm"
