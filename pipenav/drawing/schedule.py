"""A schedule of a route's corners: every corner as a dial, as it appears to a robot that looks ahead."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from pipenav.drawing.dimensions import CENTRE, DIMENSION, EDGE, FREE, INK, number
from pipenav.drawing.words import words_of
from pipenav.pipes.route import PipeRoute
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PER_ROW = 6
"""Corners in a row of the schedule."""

CELL, DIAL = 2.2, 0.45
"""Distance between two dials of the schedule, and their radius."""

LINE = 0.26
"""Height of a line of text."""

UNIT_IN = 0.62
"""Height of a unit of the schedule [in]."""

TITLE = "Corners as seen by a robot that looks ahead and never rolls"
WITH_BRANCHES = f"{TITLE}; thin marks: branches"


def draw_schedule(route: PipeRoute, axes: Axes) -> float:
    """Draw every corner as a dial that shows to which side the pipe bends; return the height of all [in]."""
    words = [words_of(corner, branches=True) for corner in route.corners]
    rows = math.ceil(len(words) / PER_ROW)
    row = 2 * DIAL + 0.4 + LINE * max(4, *(text.count("\n") + 1 for text in words), 0)
    axes.set(xlim=(-1.7, CELL * PER_ROW - 0.5), ylim=(-row * rows + 0.8, 1.3), aspect="equal")
    axes.set_axis_off()
    title = WITH_BRANCHES if any(corner.branches for corner in route.corners) else TITLE
    axes.text(-1.7, 1.05, title, fontsize=10, color=INK)
    style: dict[str, Any] = {"ha": "center", "fontsize": 9, "color": DIMENSION}
    for i, text in enumerate(words):
        x, y = CELL * (i % PER_ROW), -row * (i // PER_ROW)
        _dial(route, i, axes, (x, y))
        axes.text(x - DIAL, y + DIAL, f"{i + 1}", ha="center", va="center", fontsize=10, color=INK, fontweight="bold")
        axes.text(x, y - DIAL - 0.12, text, va="top", **style)
        for at, straight in ((x - CELL / 2, i), (x + CELL / 2, i + 1)):
            if at < x or i + 1 == len(words):
                axes.plot([at - CELL / 2 + DIAL, at + CELL / 2 - DIAL], [y, y], color=CENTRE, linewidth=1)
                axes.text(at, y + 0.1, number(m_to_mm(route.straights[straight])), **style)
    return UNIT_IN * (row * rows + 0.5)


def _dial(route: PipeRoute, i: int, axes: Axes, middle: tuple[float, float]) -> None:
    """Draw a dial: an arrow to where the corner turns, or a point where it goes straight on, and marks of branches."""
    x, y = middle
    corner = route.corners[i]
    phi = np.linspace(0, 2 * math.pi, 60)
    axes.fill(x + DIAL * np.cos(phi), y + DIAL * np.sin(phi), facecolor=FREE, edgecolor=INK, linewidth=1)
    before = sum(other.roll for other in route.corners[:i])
    for branch in corner.branches:
        side = before + branch.roll + math.pi * (branch.turn == "right")
        size = math.sin(branch.angle)  # a branch straight on is a point
        tip = np.array([-math.cos(side), math.sin(side)])  # left of the robot is left in the dial
        ends = np.array([x, y]) + np.outer([0.5 * DIAL, 1.25 * DIAL], tip)
        if size > 1e-6:
            axes.plot(*ends.T, color=INK, linewidth=1.4, zorder=4)
        else:
            axes.plot(x, y, "o", color="none", markeredgecolor=INK, markersize=7, zorder=4)
    if corner.reducer:
        small = min(1.0, float(route.legs.radius[i + 1] / route.legs.radius[i]))
        large = min(1.0, float(route.legs.radius[i] / route.legs.radius[i + 1]))
        for share in {small, large} - {1.0}:
            axes.plot(x + share * DIAL * np.cos(phi), y + share * DIAL * np.sin(phi), color=EDGE, linewidth=2)
    elif corner.straight_on:
        axes.plot(x, y, "o", color=EDGE, markersize=7 if corner.branches else 5, zorder=5)
    else:
        inside = route.legs.inside[i]
        tip = np.array([-math.cos(inside), math.sin(inside)]) * 0.85 * DIAL
        arrow = {"arrowstyle": "-|>", "color": EDGE, "linewidth": 2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (x + tip[0], y + tip[1]), (x - tip[0], y - tip[1]), arrowprops=arrow)
