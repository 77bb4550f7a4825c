"""Pictures of certificates: the tightest pose of a motion, or a link that cannot pass."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipenav.certify.certificate import Certified, trajectory
from pipenav.certify.push import pushed
from pipenav.certify.verdict import tightest
from pipenav.certify.wall_distance import SQUARE
from pipenav.drawing.scene import Scene, draw_scene
from pipenav.drawing.style import INK, MAIN, MUTED, heading
from pipenav.robots import frames, kinematics
from pipenav.units import m_to_mm, rad_to_deg

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


def stuck_figure(certified: Certified) -> Figure | None:
    """A link that cannot pass a mitre, where it has least room, pushed into the outer corner; None for other proofs."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle, Polygon

    model, proof = certified.model, certified.verdict.proof
    if proof is None or not proof.headings or model.pipe.bend_radius:
        return None
    first = [link.name for link in model.robot.links].index(proof.links[0])
    link, at = model.shapes(proof=True).stretch(first, first), np.array([[proof.headings[0]]])
    found, mirror = pushed(model, link, at), np.array([1.0, model.pipe.turn_sign])
    cos, sin = np.cos(at[0, 0]), np.sin(at[0, 0])
    turned = np.array([[cos, sin], [-sin, cos]])
    scale = m_to_mm(1.0)
    figure = Figure((7.0, 6.0), facecolor="white", layout="constrained")
    axes = figure.subplots()
    for side in (1.0, -1.0):
        line = model.pipe.model_copy(update={"turn": "left"}).line(side * model.pipe.radius) * mirror * scale
        axes.plot(*line.T, color=INK, linewidth=2)
    for centre, half in zip(link.boxes.centre, link.boxes.half, strict=True):
        corners = ((centre + half * SQUARE) @ turned + found.origin[0]) * mirror * scale
        axes.add_patch(Polygon(corners, facecolor=MAIN, alpha=0.5, edgecolor=INK))
    for centre, radius in zip(link.discs.centre, link.discs.radius, strict=True):
        axes.add_patch(Circle((centre @ turned + found.origin[0]) * mirror * scale, radius * scale, color=MUTED))
    reach = 1.5 * scale * (model.pipe.diameter + float(link.lengths.sum()))
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]", xlim=(-reach, reach), ylim=(-reach, reach))
    axes.tick_params(labelcolor=INK, labelsize=9)
    angle, lacking = rad_to_deg(proof.headings[0]), m_to_mm(-float(found.gap[0]))
    text = f"impossible: at a heading of {angle:.0f} deg {proof.links[0]} lacks {lacking:.1f} mm of bore"
    heading(axes, f"{model.robot.name}: {model.pipe.label}", text)
    return figure
