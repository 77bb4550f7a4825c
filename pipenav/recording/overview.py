"""A whole route from above in one picture, with the robot in successive poses along it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.corner import draw_walls, free_outline
from pipenav.drawing.dimensions import INK
from pipenav.drawing.labels import Labels, around
from pipenav.drawing.projection import View, straights_of
from pipenav.drawing.scene import LINK, LINK_EDGE
from pipenav.motions.trajectory import Trajectory
from pipenav.pipes.pipe_system import PipeSystem, system_of
from pipenav.pipes.route import as_route
from pipenav.recording.caption import draw_scale
from pipenav.recording.view_box import MARGIN, ViewBox
from pipenav.robots.outline import link_outlines
from pipenav.tasks.outcome import PassageStage
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PALE = 0.6
"""Share of white in the first of the poses; the last one has the robot's own colour."""

AROUND_ROBOT = 1.1
"""Width of a close-up, as a share of the robot's greatest width or height in the motion."""

TALLEST = 0.62
"""Height of the overview at most, as a share of its width."""

ROOM = 0.05
"""Room below the route for the scale, as a share of the width."""


def has_overview(trajectory: Trajectory) -> bool:
    """Whether the motion is one of a whole robot in a route, which a picture of the robot's surroundings cuts off."""
    return trajectory.header.stage is PassageStage.TRAVERSE and trajectory.header.pipe.corner is None


def overview_box(trajectory: Trajectory) -> ViewBox:
    """Box around the whole route and all poses."""
    points = np.concatenate([free_outline(trajectory.header.pipe), *_outlines(trajectory)])
    margin = MARGIN * float(np.ptp(points, axis=0).max())
    low, high = m_to_mm(1.0) * (points.min(axis=0) - margin), m_to_mm(1.0) * (points.max(axis=0) + margin)
    width = float(high[0] - low[0])
    missing = max(0.0, float(high[1] - low[1]) / TALLEST - width) / 2  # a tall route stands in the middle
    box = ViewBox(float(low[0]) - missing, float(high[0]) + missing, float(low[1]), float(high[1]))
    return box._replace(bottom=box.bottom - ROOM * (box.right - box.left))


def close_box(trajectory: Trajectory, row: int) -> ViewBox:
    """Square box around the robot in one row, of one size in all rows."""
    outlines = [part[[row]] for part in _by_row(trajectory)]
    middle = m_to_mm(1.0) * np.concatenate([part.reshape(-1, 2) for part in outlines]).mean(axis=0)
    every = np.concatenate(_by_row(trajectory), axis=1)
    half = m_to_mm(1.0) * AROUND_ROBOT / 2 * float(np.ptp(every, axis=1).max())
    return ViewBox(*(middle[0] + half * np.array([-1, 1])).tolist(), *(middle[1] + half * np.array([-1, 1])).tolist())


def draw_overview(axes: Axes, trajectory: Trajectory, rows: Sequence[int], box: ViewBox) -> None:
    """Draw the whole route, the path of the robot's middle, and its poses in some rows, numbered from 1."""
    from matplotlib.colors import to_rgb

    mm, pipe = m_to_mm(1.0), trajectory.header.pipe
    draw_walls(axes, pipe)
    parts = _by_row(trajectory)
    middle = np.concatenate(parts, axis=1).mean(axis=1)  # (rows, 2)
    axes.plot(*mm * middle.T, color=INK, linewidth=0.8, zorder=4)
    width = box.right - box.left
    off = mm * (float(pipe.leg_frames.radius.max()) + pipe.wall) + 0.022 * width
    labels = labels_around(system_of(as_route(pipe)), View.from_above(), width)
    for number, row in enumerate(rows, 1):
        white = PALE * (1 - (number - 1) / max(len(rows) - 1, 1))
        colour = tuple(white + (1 - white) * part for part in to_rgb(LINK))
        for part in parts:
            axes.fill(*mm * part[row].T, facecolor=colour, edgecolor=LINK_EDGE, linewidth=0.5, zorder=5)
        at = labels.best("00", around(mm * middle[row], off, np.array([0.0, 1.0]), 16)).at
        axes.plot(*np.stack([mm * middle[row], at]).T, color=INK, linewidth=0.5, zorder=6)
        x, y = at
        axes.text(x, y, f"{number}", fontsize=8, ha="center", va="center", color=INK, zorder=8, bbox=badge())
    draw_scale(axes, box.left + 0.02 * width, box.bottom + 0.4 * ROOM * width, width / 2, fontsize=8.5)
    axes.set(xlim=(box.left, box.right), ylim=(box.bottom, box.top), aspect="equal")
    axes.set_axis_off()


def labels_around(system: PipeSystem, view: View, width: float) -> Labels:
    """Places for numbers beside pipes, in a picture of a width [mm]."""
    half = np.concatenate([strand.legs.radius for strand in system.strands]) + system.wall
    return Labels(m_to_mm(1.0) * view.flat(straights_of(system)), m_to_mm(1.0) * half, width / 110)


def number_panel(axes: Axes, number: int) -> None:
    """Write the number of a pose into the corner of its close-up."""
    axes.text(0.03, 0.97, f"{number}", transform=axes.transAxes, fontsize=8, va="top", bbox=badge(), zorder=10)


def badge() -> dict[str, Any]:
    """Style of a number in a circle."""
    return {"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": INK, "linewidth": 0.7}


def _outlines(trajectory: Trajectory) -> list[Floats]:
    return [part.reshape(-1, 2) for part in _by_row(trajectory)]


def _by_row(trajectory: Trajectory) -> list[Floats]:
    """Polygons of the robot's outline in every row, (rows, points, 2) each [m]."""
    base = np.array([trajectory.header.base_m, 0.0])
    return [part + base for link in link_outlines(trajectory.robot, trajectory.q) for part in link]
