"""The top view of a mission: where the arm went, what it saw, where its target was."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipenav.drawing.corner import draw_walls
from pipenav.drawing.scene import BEAM, FORCE, LINK, LINK_EDGE, TARGET
from pipenav.drawing.style import GRID, INK, MUTED, png
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import frames, kinematics
from pipenav.robots.outline import link_outlines
from pipenav.robots.robot import RobotSpec
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes


STAGE_COLOURS = {"locate": INK, "reach": LINK, "back": FORCE}
POSES = 5
"""Number of outlines of the robot that are drawn on its path to the target."""

MARGIN = 90.0
"""Room around all that happened [mm]: pipes may be metres long."""


def mission_picture(
    robot: RobotSpec, ticks: Sequence[dict[str, Any]], title: str, pipe: PipeCorner | None = None, base: float = 0.0
) -> bytes:
    """A PNG of the mission: in the pipe's frame where the pipe is known, else in the robot's.

    Args:
        robot: the robot.
        ticks: telemetry records.
        title: the picture's title.
        pipe: the pipe that the arm was in; None where it is not known.
        base: x of the robot's frame in the pipe's frame [m].
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 7))
    axes = figure.add_subplot()
    if pipe is not None:
        draw_walls(axes, pipe)
    known = [tick for tick in ticks if drawable(tick, robot)]
    if known:
        pose = kinematics.forward(robot, np.array([tick["q"] for tick in known]))
        _draw_scans(axes, robot, known, pose, base)
        _draw_path(axes, robot, known, pose, base)
        _draw_target(axes, known, base)
        seen = m_to_mm(1.0) * frames.robot_to_pipe(np.concatenate([pose.joints.reshape(-1, 2), pose.tip]), base)
        low, high = seen.min(axis=0) - MARGIN, seen.max(axis=0) + MARGIN
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(0.0, -0.12), ncols=5)
    axes.set_aspect("equal")
    whose = "robot" if pipe is None else "pipe"
    axes.set_xlabel(f"x in the {whose}'s frame [mm]", color=MUTED)
    axes.set_ylabel("y [mm]", color=MUTED)
    axes.grid(color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    for edge in ("top", "right"):
        axes.spines[edge].set_visible(False)
    axes.set_title(title, loc="left", color=INK, fontsize=12)
    return png(figure)


def drawable(tick: Mapping[str, Any], robot: RobotSpec) -> bool:
    """Whether a record has everything that is drawn of it, in numbers for this robot."""
    numbers = {"q": robot.coordinates, "ranges": robot.laser.beams, "target": 2}
    for key, size in numbers.items():
        values = tick.get(key)
        if values is None and key == "target":
            continue
        if not isinstance(values, list) or len(values) != size:
            return False
        if not all(isinstance(value, int | float) and math.isfinite(value) for value in values):
            return False
    return isinstance(tick.get("stage"), str)


def _draw_scans(
    axes: Axes, robot: RobotSpec, ticks: Sequence[dict[str, Any]], pose: kinematics.ChainPose, base: float
) -> None:
    """Draw the ends of the beams: the walls as the robot saw them. Beams at either end of the range saw no wall."""
    ranges = np.array([tick["ranges"] for tick in ticks])
    beams = pose.headings[:, -1:] + robot.laser.angles
    tips = frames.robot_to_pipe(pose.tip, base)
    ends = tips[:, None] + ranges[..., None] * np.stack([np.cos(beams), np.sin(beams)], axis=-1)
    met = (ranges > robot.laser.range_min) & (ranges < robot.laser.range_max)
    axes.plot(*m_to_mm(1.0) * ends[met].T, ".", color=BEAM, markersize=3.5, alpha=0.7, label="laser readings", zorder=2)


def _draw_path(
    axes: Axes, robot: RobotSpec, ticks: Sequence[dict[str, Any]], pose: kinematics.ChainPose, base: float
) -> None:
    """The path of the tip, coloured by stage, and a few outlines of the robot while it reaches."""
    stages = np.array([tick["stage"] for tick in ticks])
    reach = np.flatnonzero(stages == "reach")
    drawn = reach[np.unique(np.linspace(0, len(reach) - 1, POSES).round().astype(int))] if len(reach) else reach
    q = np.array([tick["q"] for tick in ticks])
    for link in link_outlines(robot, q[drawn]):
        for polygons in link:
            for polygon in polygons:
                axes.fill(
                    *m_to_mm(1.0) * frames.robot_to_pipe(polygon, base).T,
                    facecolor=LINK,
                    edgecolor=LINK_EDGE,
                    alpha=0.2,
                    zorder=3,
                )
    for stage, colour in STAGE_COLOURS.items():
        tips = m_to_mm(1.0) * frames.robot_to_pipe(pose.tip[stages == stage], base)
        if len(tips):
            axes.plot(*tips.T, color=colour, linewidth=1.5, marker=".", markersize=4, label=f"tip: {stage}", zorder=6)


def _draw_target(axes: Axes, ticks: Sequence[dict[str, Any]], base: float) -> None:
    target = next((tick["target"] for tick in reversed(ticks) if tick.get("target")), None)
    if target is not None:
        x, y = m_to_mm(1.0) * frames.robot_to_pipe(target, base)
        axes.plot(x, y, "*", color=TARGET, markersize=15, markeredgecolor="white", label="target", zorder=8)
