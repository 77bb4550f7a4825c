"""Pictures of certificates: the tightest pose of a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipenav.certify.certificate import Certified, trajectory
from pipenav.certify.verdict import tightest
from pipenav.drawing.scene import Scene, draw_scene
from pipenav.drawing.style import INK, heading
from pipenav.robots import frames, kinematics
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AROUND = 40.0
"""Room around the robot in a picture [mm]."""


def tightest_figure(certified: Certified) -> Figure:
    """The pose of a passable pipe's motion in which the robot is nearest to a wall."""
    from matplotlib.figure import Figure

    motion, model = trajectory(certified), certified.model
    row = tightest(model, motion.q, motion.header.base_m)
    points = kinematics.waypoints(model.robot, motion.q[row : row + 1])[0]
    points = m_to_mm(1.0) * frames.robot_to_pipe(points, motion.header.base_m)
    figure = Figure((7.0, 6.0), facecolor="white", layout="constrained")
    axes = figure.subplots()
    blind = np.zeros(model.robot.laser.beams)
    draw_scene(axes, Scene(motion.header.pipe, model.robot, motion.header.base_m, motion.q[row], blind))
    room = AROUND + m_to_mm(model.pipe.diameter)
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    axes.set_xlim(points[:, 0].min() - room, max(points[:, 0].max(), 0.0) + room)
    axes.set_ylim(points[:, 1].min() - room, points[:, 1].max() + room)
    axes.tick_params(labelcolor=INK, labelsize=9)
    bore = "between boards" if model.bore == "plane" else "round bore"
    heading(axes, f"{model.robot.name}: {model.pipe.label}", f"{bore}: {certified.verdict.kind}, tightest pose")
    return figure
