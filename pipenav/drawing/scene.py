"""A robot in its pipe from above, in millimetres of the pipe's frame: the drawing in every picture of a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Floats
from pipenav.drawing.corner import draw_walls
from pipenav.drawing.dimensions import INK
from pipenav.drawing.down import down_sign
from pipenav.pipes.pipe import Pipe
from pipenav.robots import frames, kinematics
from pipenav.robots.outline import link_outlines
from pipenav.robots.robot import RobotSpec
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes


# Okabe and Ito's colours, which people with any kind of colour vision tell apart; shapes differ as well.
LINK = "#0072b2"
LINK_EDGE = "#003a5c"
BEAM = "#e69f00"
TARGET = "#009e73"
FORCE = "#d55e00"

FORCE_SCALE = 6.0
"""Length of a contact arrow [mm/N]: 10 N are half a link of the thesis's arm; the usual peaks fit into the picture."""

LEAST_FORCE = 0.3
"""Least force that is drawn [N]: arrows of smaller ones would be shorter than their heads."""

KEY_FORCE = 10.0
"""Force of the arrow in the legend [N]."""


class Scene(NamedTuple):
    """A robot in its pipe at one time.

    Attributes:
        pipe: pipe around the robot.
        robot: description of the robot.
        base: x of the robot's frame in the pipe's frame [m].
        q: configuration in the robot's own frame, (coordinates,) [rad or m].
        ranges: laser readings from right to left, (beams,) [m].
        target: target in the pipe's frame, (2,) [m]; None for a task without a target.
        link_forces: forces of the pipe on the links, (links, 2) [N]; None for forces that are not known.
        gravity: gravity's part in the pipe's plane, (2,) [m/s^2]; None where nothing weighs, or it is not known.
    """

    pipe: Pipe
    robot: RobotSpec
    base: float
    q: Floats
    ranges: Floats
    target: Floats | None = None
    link_forces: Floats | None = None
    gravity: Floats | None = None


def draw_scene(axes: Axes, scene: Scene) -> None:
    """Draw pipe, beams, target, robot and contact forces; the axes' limits are left as they are."""
    draw_walls(axes, scene.pipe)
    offset = np.array([scene.base, 0.0])
    pose = kinematics.forward(scene.robot, scene.q[None])
    _draw_beams(axes, scene, pose.tip[0] + offset, float(pose.headings[0, -1]))
    if scene.target is not None:
        axes.plot(*m_to_mm(1.0) * scene.target, "*", color=TARGET, markersize=15, markeredgecolor="white", zorder=8)
    outlines = [[polygon[0] + offset for polygon in link] for link in link_outlines(scene.robot, scene.q[None])]
    for polygon in (polygon for link in outlines for polygon in link):
        axes.fill(*m_to_mm(1.0) * polygon.T, facecolor=LINK, edgecolor=LINK_EDGE, linewidth=0.9, zorder=5)
    turning = [link.joint is not None and link.joint.type == "hinge" for link in scene.robot.links]
    hinges = (pose.joints[0] + offset)[turning]
    axes.plot(*m_to_mm(1.0) * hinges.T, "o", color="white", markersize=4.5, markeredgecolor=LINK_EDGE, zorder=6)
    if scene.link_forces is not None:
        for link, force in zip(outlines, scene.link_forces, strict=True):
            if np.linalg.norm(force) >= LEAST_FORCE:
                _draw_force(axes, contact_point(link, scene.pipe), force)


def _draw_beams(axes: Axes, scene: Scene, tip: Floats, heading: float) -> None:
    """Draw beams as thin lines as long as they read, with a dot where one meets a wall within the laser's range."""
    beams = heading + scene.robot.laser.angles
    ends = tip + scene.ranges[:, None] * np.stack([np.cos(beams), np.sin(beams)], axis=1)
    for end in ends:
        axes.plot(*m_to_mm(1.0) * np.stack([tip, end]).T, color=BEAM, linewidth=0.7, alpha=0.6, zorder=4)
    lidar = scene.robot.laser
    within = (scene.ranges > lidar.range_min) & (scene.ranges < lidar.range_max)  # the least reading may lie in a wall
    met = m_to_mm(1.0) * ends[within]
    axes.plot(*met.T, ".", color=BEAM, markersize=4.5, zorder=4)


def contact_point(polygons: list[Floats], pipe: Pipe) -> Floats:
    """The point at which a link is nearest to a wall, (2,) [m]: a corner of the link, or an edge of a wall.

    Args:
        polygons: polygons of the link's outline, each (points, 2) [m] in the pipe's frame.
        pipe: pipe around the link.
    """
    corners = np.concatenate(polygons)
    edges = np.concatenate([np.stack([polygon, np.roll(polygon, -1, axis=0)], axis=1) for polygon in polygons])
    bends = np.concatenate([wall.face[1:-1] for wall in pipe.wall_sides])
    points = np.concatenate([corners, bends])
    distances = np.concatenate([_distance(corners, pipe.segments), _distance(bends, edges)])
    return np.asarray(points[distances.argmin()])


def _distance(points: Floats, segments: Floats) -> Floats:
    """Distance of points (p, 2) to the nearest of segments (s, 2, 2): (p,)."""
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    share = ((points[:, None] - start) * along).sum(axis=2) / (along**2).sum(axis=1)
    nearest = start + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.asarray(np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1))


def _draw_force(axes: Axes, point: Floats, force: Floats) -> None:
    """Draw an arrow from the contact along the force on the link, with a white rim, as it mostly lies on the link."""
    from matplotlib.patches import FancyArrowPatch
    from matplotlib.patheffects import Normal, Stroke

    start = m_to_mm(1.0) * point
    style: dict[str, Any] = {
        "arrowstyle": "-|>",
        "color": FORCE,
        "linewidth": 1.8,
        "mutation_scale": 11,
        "shrinkA": 0,
        "shrinkB": 0,
    }
    arrow = FancyArrowPatch(tuple(start), tuple(start + FORCE_SCALE * force), zorder=9, **style)
    arrow.set_path_effects([Stroke(linewidth=3.4, foreground="white"), Normal()])
    axes.add_patch(arrow)


def legend_handles(target: bool, forces: bool) -> list[Artist]:
    """Legend of the colours and marks; `draw_force_key` gives the arrows' scale.

    Args:
        target: whether there is a target.
        forces: whether there are contact forces.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    star = Line2D([], [], linestyle="", color=TARGET, marker="*", markersize=12, label="target")
    arrow = Line2D([], [], linestyle="", color=FORCE, marker=">", markersize=8, label="contact force")
    return [
        Patch(facecolor=LINK, edgecolor=LINK_EDGE, label="robot"),
        *([star] if target else []),
        Line2D([], [], color=BEAM, linewidth=1.2, marker=".", label="laser beam"),
        *([arrow] if forces else []),
    ]


def draw_force_key(axes: Axes, x: float, y: float, fontsize: float) -> None:
    """Draw the arrow of `KEY_FORCE` with its text, from (x, y) [mm] to the right."""
    _draw_force(axes, np.array([x, y]) / m_to_mm(1.0), np.array([KEY_FORCE, 0.0]))
    text = f"  {KEY_FORCE:g} N"
    axes.text(x + FORCE_SCALE * KEY_FORCE, y, text, color=INK, fontsize=fontsize, va="center", zorder=9)


def scene_pixels(scene: Scene, pixels: int = 480, around: float = 0.4) -> NDArray[np.uint8]:
    """A square picture around the tip, red, green and blue, (pixels, pixels, 3).

    Args:
        scene: scene to draw.
        pixels: width and height of the picture.
        around: distance from the tip to the picture's edges [m].
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(pixels / 100, pixels / 100), dpi=100)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    draw_scene(axes, scene)
    x, y = m_to_mm(1.0) * frames.robot_to_pipe(kinematics.forward(scene.robot, scene.q[None]).tip[0], scene.base)
    reach = m_to_mm(around)
    axes.set(xlim=(x - reach, x + reach), ylim=(y - reach, y + reach))
    axes.set_axis_off()
    if scene.gravity is not None and scene.gravity.any():
        down = np.array([*scene.gravity, 0.0]) / np.linalg.norm(scene.gravity)
        axes.add_artist(down_sign(down, axes.transAxes, (0.99, 0.99)))
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
