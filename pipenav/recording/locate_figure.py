"""The laser's view of a corner until a target was found, as a picture from above."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from pipenav.arrays import Floats
from pipenav.drawing.dimensions import INK
from pipenav.drawing.down import LEVEL
from pipenav.drawing.scene import Scene, draw_scene, legend_handles
from pipenav.drawing.style import heading
from pipenav.recording.caption import details_of
from pipenav.recording.film import box_of
from pipenav.recording.record import Located
from pipenav.robots import kinematics
from pipenav.units import m_to_mm

MET = "#7f8c99"
"""Colour of the points that earlier scans met."""

WIDTH_IN = 9.0
"""Width of the picture [in]."""


def locate_figure(located: Located) -> Figure:
    """The robot and its beams when the target was found, or at the end; the ends of all beams before; the target."""
    from matplotlib.lines import Line2D

    trajectory = located.trajectory
    header, robot = trajectory.header, trajectory.robot
    row = len(trajectory.q) - 1 if located.found is None else located.found
    target = None if header.goal_m is None else np.array(header.goal_m)
    box = box_of(trajectory)
    figure = Figure(figsize=(WIDTH_IN, WIDTH_IN * box.aspect), dpi=100, facecolor="white")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    draw_scene(axes, Scene(header.pipe, robot, header.base_m, trajectory.q[row], located.ranges[row], target))
    axes.plot(*m_to_mm(1.0) * _met(located, row).T, ".", color=MET, markersize=4, zorder=3)
    axes.set(xlim=(box.left, box.right), ylim=(box.bottom, box.top), aspect="equal", xticks=[], yticks=[])
    said = "no target found" if located.found is None else f"target found after {trajectory.time[row]:.1f} s"
    details = details_of(header.controller, header.robot, header.backend, header.options, header.seed)
    heading(axes, f"{header.pipe.label}: {said}", f"{details} · {LEVEL}")
    met = Line2D([], [], linestyle="", color=MET, marker=".", markersize=7, label="met by earlier scans")
    handles = [*legend_handles(target=target is not None, forces=False), met]
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=4, frameon=False, labelcolor=INK)
    return figure


def _met(located: Located, row: int) -> Floats:
    """Points where the beams of the scans before a row met a wall, in the pipe's frame, (points, 2) [m]."""
    trajectory, ranges = located.trajectory, located.ranges[:row]
    lidar = trajectory.robot.laser
    pose = kinematics.forward(trajectory.robot, trajectory.q[:row])
    beams = pose.headings[:, -1:] + lidar.angles
    rays = ranges[..., None] * np.stack([np.cos(beams), np.sin(beams)], axis=-1)
    ends = pose.tip[:, None] + rays + [trajectory.header.base_m, 0.0]
    return np.asarray(ends[(ranges > lidar.range_min) & (ranges < lidar.range_max)])
