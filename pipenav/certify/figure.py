"""Pictures of certificates: the tightest pose of a motion, or a link that cannot pass."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipenav.arrays import Floats
from pipenav.certify.cells import ROUNDING
from pipenav.certify.certificate import Certified, trajectory
from pipenav.certify.model import Model
from pipenav.certify.motion_check import clearances
from pipenav.certify.push import pushed
from pipenav.certify.verdict import Freed, Verdict, freed_joint, passable, tightest
from pipenav.certify.wall_distance import SQUARE
from pipenav.drawing.scene import Scene, draw_scene
from pipenav.drawing.style import INK, MAIN, MUTED, heading
from pipenav.motions.trajectory import Trajectory
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.robots import frames, kinematics
from pipenav.robots.robot import RobotSpec
from pipenav.units import m_to_mm, mm_to_m, rad_to_deg

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DEPTH, DEPTHS = 2e-4, 40
"""Steps in which an overlap is measured [m], and their number: less than the parts' half widths."""

AROUND = 40.0
"""Room around the robot in a picture [mm]."""

WIDER_MM = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 64.0)
"""Widenings of the bore in which a motion is looked for, to show where it does not fit [mm]."""


def tightest_figure(certified: Certified) -> Figure:
    """The pose of a passable pipe's motion in which the robot is nearest to a wall."""
    motion, model = trajectory(certified), certified.model
    q = motion.q[tightest(model, motion.q, motion.header.base_m)]
    return _pose_figure(Scene(*_around(motion), q, _blind(model)), model, f"{certified.verdict.kind}, tightest pose")


def impossible_figure(certified: Certified) -> Figure | None:
    """Why a pipe cannot be passed: a link or a pose that does not fit; None where nothing shows it.

    A link that cannot pass a mitre is shown by `stuck_figure`. Else an arm that lacks travel of a joint is shown where
    it would need most, and any other robot in the pose of a wider pipe's motion that overlaps most with this one.
    """
    if certified.verdict.kind != "impossible":
        return None
    if (figure := stuck_figure(certified)) is not None:
        return figure
    model, ends = certified.model, certified.ends
    if ends is not None and (freed := freed_joint(model, ends)) is not None:
        return _beyond_limits(certified, freed)
    for more in WIDER_MM:
        wider = model.with_bore(model.pipe.diameter + mm_to_m(more))
        if (found := passable(wider, ends)) is not None:
            return _overlapping(certified, found, wider.pipe)
    return None


def _overlapping(certified: Certified, found: Verdict, wider: PipeCorner) -> Figure:
    """The pose of a wider pipe's motion that overlaps most with the walls of the one that was certified."""
    motion = trajectory(certified._replace(verdict=found))
    row, overlap = _deepest(certified.model, motion.q, found.base)
    bore, deep = m_to_mm(wider.diameter), m_to_mm(overlap)
    most = "at least " if overlap >= certified.model.overlap + DEPTHS * DEPTH - ROUNDING else ""
    text = f"impossible: a motion through {bore:.0f} mm overlaps here by {most}{deep:.1f} mm"
    scene = Scene(*_around(motion), motion.q[row], _blind(certified.model))
    return _pose_figure(scene, certified.model, text)


def _deepest(model: Model, q: Floats, base: float) -> tuple[int, float]:
    """Row of a motion with the deepest overlap with the walls, and that overlap [m]: parts are made smaller until none
    of them touches."""
    rows, deep = np.arange(len(q)), model.overlap
    for overlap in model.overlap + np.arange(1, DEPTHS + 1) * DEPTH:
        touching = rows[clearances(model._replace(overlap=float(overlap)), q[rows], base) <= 0]
        if not len(touching):
            break
        rows, deep = touching, float(overlap)
    return int(rows[len(rows) // 2]), deep


def _beyond_limits(certified: Certified, freed: Freed) -> Figure:
    """The pose of a motion in which a joint would be furthest beyond its limits."""
    motion = trajectory(certified._replace(verdict=freed.verdict))
    model, joint, at = certified.model, certified.model.robot.joints[freed.number], motion.q[:, freed.number]
    row = int(np.maximum(at - joint.upper, joint.lower - at).argmax())
    limit, unit = (joint.upper if at[row] > 0 else joint.lower), "rad" if joint.type == "hinge" else "m"
    text = f"impossible: {joint.name} would have to be at {at[row]:.2f} {unit}, its limit is {limit:.2f}"
    return _pose_figure(Scene(*_around(motion), motion.q[row], _blind(model)), model, text)


def _around(motion: Trajectory) -> tuple[Pipe, RobotSpec, float]:
    """Pipe, robot and base of a motion, for its scene."""
    return motion.header.pipe, motion.robot, motion.header.base_m


def _blind(model: Model) -> Floats:
    return np.zeros(model.robot.laser.beams)


def _pose_figure(scene: Scene, model: Model, text: str) -> Figure:
    """A robot's pose in its pipe, with the kind of bore and a few words above it."""
    from matplotlib.figure import Figure

    points = m_to_mm(1.0) * frames.robot_to_pipe(kinematics.waypoints(model.robot, scene.q[None])[0], scene.base)
    figure = Figure((7.0, 6.0), facecolor="white", layout="constrained")
    axes = figure.subplots()
    draw_scene(axes, scene)
    room = AROUND + m_to_mm(model.pipe.diameter)
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    axes.set_xlim(points[:, 0].min() - room, max(points[:, 0].max(), 0.0) + room)
    axes.set_ylim(points[:, 1].min() - room, points[:, 1].max() + room)
    axes.tick_params(labelcolor=INK, labelsize=9)
    bore = "between boards" if model.bore == "plane" else "round bore"
    heading(axes, f"{model.robot.name}: {model.pipe.label}, {bore}", text)
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
