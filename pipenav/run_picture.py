"""The top view of a run on an arm: where it went, what it saw, where its target was."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pipenav import kinematics
from pipenav.report_figures import GRID, INK, MAIN, MUTED, SECOND, THIRD, png
from pipenav.robot import RobotSpec

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

STAGE_COLOURS = {"locate": THIRD, "reach": MAIN, "back": SECOND}
POSES = 6
"""Poses of the arm that are drawn in each stage."""


def run_picture(robot: RobotSpec, ticks: Sequence[dict[str, Any]], walls: Sequence[Array], title: str) -> bytes:
    """A PNG of the run in the robot's frame.

    Args:
        robot: the robot.
        ticks: telemetry records.
        walls: polylines of the pipe in the robot's frame where it is known, (k, 2) [m].
        title: of the picture.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 7))
    axes = figure.add_subplot()
    known = [tick for tick in ticks if "q" in tick]
    for wall in walls:
        axes.plot(*(1e3 * wall).T, color=INK, linewidth=2, zorder=1)
    if known:
        _draw_scans(axes, robot, known)
        _draw_arm(axes, robot, known)
        _draw_target(axes, known)
        _frame(axes, robot, known)
    axes.set_aspect("equal")
    axes.set_xlabel("along the first leg [mm]", color=MUTED)
    axes.set_ylabel("to the left [mm]", color=MUTED)
    axes.grid(color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.set_title(title, loc="left", color=INK, fontsize=12)
    handles, _ = axes.get_legend_handles_labels()
    if handles:
        axes.legend(frameon=False, loc="best")
    return png(figure)


def _draw_scans(axes: Axes, robot: RobotSpec, ticks: Sequence[dict[str, Any]]) -> None:
    """Where the beams ended: the walls as the robot saw them. Beams at either end of the range saw none."""
    q, ranges = np.array([tick["q"] for tick in ticks]), np.array([tick["ranges"] for tick in ticks])
    pose = kinematics.forward(robot, q)
    beams = pose.headings[:, -1:] + robot.laser.angles
    ends = pose.tip[:, None] + ranges[..., None] * np.stack([np.cos(beams), np.sin(beams)], axis=-1)
    hit = (ranges > robot.laser.range_min) & (ranges < robot.laser.range_max)
    x, y = 1e3 * ends[hit].T
    axes.scatter(x, y, s=5, color=MUTED, alpha=0.35, linewidths=0, label="laser readings", zorder=2)


def _draw_arm(axes: Axes, robot: RobotSpec, ticks: Sequence[dict[str, Any]]) -> None:
    for stage, colour in STAGE_COLOURS.items():
        part = [tick["q"] for tick in ticks if tick["stage"] == stage]
        if not part:
            continue
        pose = kinematics.forward(robot, np.array(part))
        axes.plot(
            *(1e3 * pose.tip).T, color=colour, linewidth=1.5, marker=".", markersize=3, label=f"tip: {stage}", zorder=4
        )
        for i in np.unique(np.linspace(0, len(part) - 1, POSES).round().astype(int)):
            chain = np.concatenate([pose.joints[i], pose.tip[i][None]])
            axes.plot(*(1e3 * chain).T, color=colour, linewidth=5, alpha=0.18, solid_joinstyle="round", zorder=3)


def _draw_target(axes: Axes, ticks: Sequence[dict[str, Any]]) -> None:
    target = next((tick["target"] for tick in reversed(ticks) if tick.get("target")), None)
    if target is not None:
        x, y = 1e3 * np.array(target)
        axes.plot(x, y, marker="*", markersize=15, color=SECOND, linestyle="none", label="target", zorder=5)


def _frame(axes: Axes, robot: RobotSpec, ticks: Sequence[dict[str, Any]]) -> None:
    """The part of the world where something happened: pipes may be metres long."""
    pose = kinematics.forward(robot, np.array([tick["q"] for tick in ticks]))
    points = 1e3 * np.concatenate([pose.joints.reshape(-1, 2), pose.tip])
    margin = 120.0
    axes.set_xlim(points[:, 0].min() - margin, points[:, 0].max() + margin)
    axes.set_ylim(points[:, 1].min() - margin, points[:, 1].max() + margin)
