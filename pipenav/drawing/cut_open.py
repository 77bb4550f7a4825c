"""The second picture of a route in space: its tube cut open, as a whole or, where it is long, corner by corner."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.dimensions import INK
from pipenav.drawing.projection import CutOpen, View
from pipenav.pipes.branch_pipes import reaches_of
from pipenav.pipes.pipe_system import system_of
from pipenav.pipes.route import PipeRoute
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE = "Cut open towards the viewer"

THIN = 0.045
"""Diameter below which the inside of a pipe is too small to be seen in the whole route, as a share of its length."""

MOST = 8
"""Most corners that are shown one by one."""

PER_ROW, CORNER_IN = 4, 2.2
"""Pictures of corners in a row, and the side of each [in]."""

AROUND = 1.3
"""Room around a corner's fitting, in diameters."""


def shown_by_corners(route: PipeRoute) -> bool:
    """Whether the corners are shown one by one, as the pipe is thin in the picture of the whole."""
    thin = route.diameter < THIN * float(np.ptp(route.centre_line, axis=0).max())
    return thin and len(route.corners) <= MOST


def cut_open_height(route: PipeRoute, whole: float) -> float:
    """Height of the picture [in], where one of the whole would have a given height [in]."""
    if not shown_by_corners(route):
        return whole + 0.3
    return math.ceil(len(route.corners) / PER_ROW) * CORNER_IN + 0.3


def draw_route_open(route: PipeRoute, axes: Axes) -> None:
    """Draw the route cut open towards the viewer, in place of axes that stand where it is to be."""
    system = system_of(route)
    opened = CutOpen.of(system, View.of(system))
    axes.set_axis_off()
    if shown_by_corners(route):
        _corners(route, axes, opened)
        return
    axes.set_title(TITLE, loc="left", fontsize=10, color=INK)
    points = opened.draw(axes)
    margin = 0.03 * np.ptp(points, axis=0).max()
    (left, bottom), (right, top) = points.min(axis=0) - margin, points.max(axis=0) + margin
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")


def _corners(route: PipeRoute, axes: Axes, opened: CutOpen) -> None:
    """Draw every corner in a picture of its own, with its number."""
    place, figure = axes.get_subplotspec(), axes.get_figure()
    assert place is not None and figure is not None
    axes.remove()
    rows = math.ceil(len(route.corners) / PER_ROW)
    grid = place.subgridspec(rows, PER_ROW)
    badge = {"boxstyle": "circle,pad=0.25", "facecolor": "white", "edgecolor": INK, "linewidth": 0.8}
    for i, at in enumerate(route.centre_line[1:-1]):
        panel = figure.add_subplot(grid[i // PER_ROW, i % PER_ROW])
        half = _reach(route, i) + AROUND * 2 * float(route.legs.radius[i : i + 2].max())
        opened.near(at, 3.0 * half).draw(panel)
        x, y = m_to_mm(1.0) * opened.view.flat(_middle(route, i, at))
        side = m_to_mm(half)
        panel.set(xlim=(x - side, x + side), ylim=(y - side, y + side), aspect="equal", xticks=[], yticks=[])
        panel.text(0.06, 0.94, f"{i + 1}", transform=panel.transAxes, fontsize=8, va="top", bbox=badge, zorder=8)
        for spine in panel.spines.values():
            spine.set_color("#d5dbe1")
        if i == 0:
            panel.set_title(f"{TITLE}, corner by corner", loc="left", fontsize=10, color=INK)


def _reach(route: PipeRoute, i: int) -> float:
    """Distance from a corner's crossing to where its fitting ends [m]."""
    corner, legs = route.corners[i], route.legs
    if corner.branches:
        return float(reaches_of(corner, *(2 * legs.radius[i : i + 2]).tolist()).max())
    return max(float(legs.bend[i] * legs.reach[i]), corner.length / 2)


def _middle(route: PipeRoute, i: int, crossing: Floats) -> Floats:
    """Middle of a corner's picture, (3,) [m]: the crossing of its axes, moved into a bend."""
    bend = float(route.legs.bend[i])
    if not bend:
        return crossing
    inwards = route.legs.axes[i + 1, :, 0] - route.legs.axes[i, :, 0]
    half = (math.pi - route.corners[i].angle) / 2
    return np.asarray(crossing + bend * (1 / math.cos(half) - 1) * inwards / np.linalg.norm(inwards))
