"""A drawing of a route with its dimensions, in millimetres: from above where it is planar, else in space.

In space a second picture shows the tube cut open. There, and where there are many corners, a schedule below shows every
corner as it appears to a robot that looks ahead and never rolls.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.corner import draw_walls
from pipenav.drawing.cut_open import cut_open_height, draw_route_open
from pipenav.drawing.dimensions import (
    CENTRE,
    EDGE,
    INK,
    TALLEST_IN,
    WIDTH_IN,
    frame_axes,
    number,
    save_figure,
    write_title,
)
from pipenav.drawing.down import down_sign
from pipenav.drawing.projection import View, draw_tube
from pipenav.drawing.route_sketch import RouteSketch
from pipenav.drawing.schedule import draw_schedule
from pipenav.drawing.words import counts_of
from pipenav.pipes.branch_pipes import reaches_of
from pipenav.pipes.pipe_system import system_of
from pipenav.pipes.route import PipeRoute
from pipenav.units import m_to_mm, rad_to_deg

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELLED = 8
"""Corners of the longest route with dimensions in the picture; a longer one has them in its schedule alone."""

STRAIGHT = 1e-6
"""Reach of a mitre, and sine of a wall's turn, below which a corner or a wall counts as straight."""

TALLEST_IN_SPACE = 6.8
"""Height of the picture in space at most [in]: with what stands below it, a page still holds it."""

OPEN_SHARE = 0.7
"""Size of the picture that is cut open, as a share of the one with dimensions."""


def draw_route(route: PipeRoute, name: str, path: Path) -> None:
    """Draw a route into a PNG file, under a name."""
    save_figure(route_figure(route, name), path)


def route_figure(route: PipeRoute, name: str) -> Figure:
    """The drawing of a route as a matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(facecolor="white", layout="constrained")
    parts = 3 - route.planar - (route.planar and len(route.corners) <= LABELLED)
    first, *others = figure.subplots(parts, 1, squeeze=False)[:, 0]
    tall = _plan(route, first) if route.planar else _in_space(route, first)
    shrink = min(1.0, (TALLEST_IN if route.planar else TALLEST_IN_SPACE) / tall)
    heights = [tall * shrink]
    if not route.planar:
        heights.append(cut_open_height(route, OPEN_SHARE * tall * shrink))
    if others:
        heights.append(draw_schedule(route, others[-1]))
        first.get_gridspec().set_height_ratios(heights)
    if not route.planar:
        draw_route_open(route, others[0])
    width = WIDTH_IN if others else max(WIDTH_IN * shrink, 6.5)
    figure.set_size_inches(width + 0.6, sum(heights) + (1.0 if others else 1.4))
    bores = "-".join(number(m_to_mm(2 * radius)) for radius in dict.fromkeys(route.legs.radius.tolist()))
    bore = f"⌀ {bores} mm, wall {number(m_to_mm(route.wall))} mm"
    length = f"{sum(route.straights):.2f} m along the centre line, lengths from corner to corner"
    slope = (
        f"; it begins {'up' if route.slope > 0 else 'down'} at {abs(rad_to_deg(route.slope)):g}°" if route.slope else ""
    )
    write_title(first, f"{name}: {counts_of(route)}, {bore}", f"{length}; all lengths in mm{slope}")
    if route.planar:
        figure.legend(loc="outside lower center", ncols=4, fontsize=9, frameon=False, labelcolor=INK)
    return figure


def _plan(route: PipeRoute, axes: Axes) -> float:
    """Draw the route from above; return the height of the drawing at full width [in]."""
    draw_walls(axes, route)
    branches = route.branches
    ends = branches.start + branches.length[:, None] * branches.axes[:, :, 0]
    lines = [route.legs.line(0.0, 0.0), *np.stack([branches.start, ends], axis=1)]
    for number_of_line, line in enumerate(lines):
        label = None if number_of_line else "centre line"
        drawn = m_to_mm(1.0) * line[:, :2]
        axes.plot(*drawn.T, color=CENTRE, linewidth=0.9, dashes=(12, 3, 2, 3), zorder=2, label=label)
    edges = _inner_edges(route)
    if len(edges):
        axes.plot(*m_to_mm(1.0) * edges.T, "o", color=EDGE, markersize=4, zorder=6, label="inner edge")
    sketch = RouteSketch(route, axes, View.from_above())
    if len(route.corners) <= LABELLED:
        sketch.lengths()
        sketch.angles()
        sketch.branch_sizes(angles=True)
    sketch.robot()
    sketch.corners()
    if route.slope:
        axes.add_artist(down_sign(View.from_above().seen(route.down), axes.transAxes, (1.0, 1.0)))
    return frame_axes(axes, *sketch.frame())


def _inner_edges(route: PipeRoute) -> Floats:
    """Sharp inner edges of a planar route's mitres, tees and crosses, (k, 2) [m]."""
    legs = route.legs
    fitting = np.array([bool(corner.branches) for corner in route.corners])
    sharp = (legs.reach > STRAIGHT) & (legs.bend <= legs.radius[:-1]) & ~fitting
    inwards = np.diff(legs.axes[:, :2, 0], axis=0)[sharp] / np.sin(legs.turn_angle[sharp, None])
    found = [legs.start[1:, :2][sharp] + legs.radius[:-1][sharp, None] * inwards]
    for i in np.flatnonzero(fitting):
        before, after = (2 * legs.radius[i : i + 2]).tolist()
        reach = float(reaches_of(route.corners[i], before, after).max()) + route.diameter
        for face, _ in route.wall_sides:
            steps = np.diff(face, axis=0)
            steps /= np.linalg.norm(steps, axis=1, keepdims=True)
            turns = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
            near = np.linalg.norm(face[1:-1] - legs.start[i + 1, :2], axis=1) < reach
            found.append(face[1:-1][near & (turns < -STRAIGHT)])
    return np.concatenate(found)


def _in_space(route: PipeRoute, axes: Axes) -> float:
    """Draw the route in space; return the height of the drawing at full width [in]."""
    system = system_of(route)
    view = View.of(system)
    drawn = draw_tube(axes, system, view)
    sketch = RouteSketch(route, axes, view)
    sketch.drawn.append(drawn)
    if len(route.corners) <= LABELLED:
        sketch.lengths()
        sketch.branch_sizes(angles=False)
    sketch.robot()
    sketch.corners()
    sketch.directions()
    tall = frame_axes(axes, *sketch.frame())
    axes.set_axis_off()
    axes.add_artist(down_sign(view.seen(route.down), axes.transAxes, (1.0, 1.0)))
    return tall
