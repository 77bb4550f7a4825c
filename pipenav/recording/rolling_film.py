"""Pictures of a motion in space: the route cut open towards the viewer, the robot's halves in two colours.

Above the whole route with the path of the robot's middle, below the robot itself.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.drawing.dimensions import INK
from pipenav.drawing.projection import View
from pipenav.drawing.scene import FORCE
from pipenav.recording.caption import Caption, caption_of, details_of, draw_caption, draw_scale
from pipenav.recording.film import DPI, FAILED, SUCCEEDED
from pipenav.recording.film_files import Frames, write_frames
from pipenav.recording.record_rolling import SpaceRecording
from pipenav.robots.robot import RobotSpec
from pipenav.storage.atomic_files import atomic_write
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Progress = Callable[[int, int], None]

HALF_COLOURS = np.array([[0.00, 0.45, 0.70], [0.84, 0.37, 0.00]])
"""Colours of the rear and the front half: Okabe and Ito's blue and vermilion, as elsewhere."""

BORE = np.array([0.86, 0.88, 0.90])
PANELS, COLUMNS, PANEL_IN = 8, 4, 2.9
REACH = 0.36
"""Distance from the robot's middle to the edge of a panel [m]."""

SKIP = 5
"""Control steps between two frames of a film, which therefore runs five times as fast as the robot."""

SPEED = f"film {SKIP} times as fast as the robot"

FRAME_IN = (9.6, 4.6)
"""Width of a film's frame, and its height below the caption [in]."""

SIDES = 12
"""Sides of the polygon that a wheel is drawn as."""

BOX_FACES = np.array([[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]])
"""Corners of a box's faces; the corners count x slowest, z fastest."""


def draw_in_space(path: Path, recording: SpaceRecording, progress: Progress) -> None:
    """A strip (.png) or a film (.gif, .mp4) of the motion, by the file's suffix.

    Raises:
        PipenavError: MP4 without ffmpeg.
        FileProblem: the file cannot be written.
    """
    view = View.of(recording.route)
    if path.suffix.lower() == ".png":
        picture = io.BytesIO()
        _strip(recording, view, progress).savefig(picture, format="png", dpi=DPI)
        atomic_write(path, picture.getvalue())
        return
    rows = np.append(np.arange(0, len(recording.points) - 1, SKIP), len(recording.points) - 1)
    frames = _frames(recording, view, rows, progress)
    write_frames(path, frames, {len(rows) - 1})


class Faces(NamedTuple):
    """Faces of a robot that are drawn.

    Attributes:
        links: faces of the links, 6 for each piece, (6 pieces, 4, 3) [m].
        wheels: discs of the wheels, (SIDES, 3) each [m].
        half: number of the half that each piece and then each wheel belongs to, (pieces + wheels,).
    """

    links: Floats
    wheels: list[Floats]
    half: Floats


def faces(robot: RobotSpec, points: Floats, normals: Floats) -> Faces:
    """The faces of links and wheels of a robot in a pose.

    Args:
        robot: the robot, with a roll joint.
        points: rear end, joints and tip, (links + 1, 3) [m].
        normals: normals of the halves' planes, (halves, 3).
    """
    assert robot.roll is not None
    boxes, halves, discs, of_wheels, half = [], [], [], [], 0
    for link, start, end in zip(robot.links, points[:-1], points[1:], strict=True):
        forward = (end - start) / link.length
        if link.wheel is not None:
            across = np.cross(normals[half], forward)
            angle = np.arange(SIDES) * 2 * np.pi / SIDES
            rim = np.cos(angle)[:, None] * forward + np.sin(angle)[:, None] * across
            discs.append(start + link.wheel.x * forward + link.wheel.radius * rim)
            of_wheels.append(half)
        divided = link.name == robot.roll.link
        for low, high in [(0.0, robot.roll.x), (robot.roll.x, link.length)] if divided else [(0.0, link.length)]:
            if divided and low > 0:
                half = 1
            up, left = normals[half], np.cross(normals[half], forward)
            corners = [
                start + x * forward + y * left + z * up
                for x in (low, high)
                for y in (-link.width / 2, link.width / 2)
                for z in (-link.height / 2, link.height / 2)
            ]
            boxes.append(np.array(corners)[BOX_FACES])
            halves.append(half)
    return Faces(np.concatenate(boxes), discs, np.array([*halves, *of_wheels]))


def _strip(recording: SpaceRecording, view: View, report_progress: Progress) -> Any:
    """Figure of the whole route above a few moments, evenly in time."""
    from matplotlib.figure import Figure

    rows = np.unique(np.linspace(0, len(recording.points) - 1, PANELS).round().astype(int))
    lines = -(-len(rows) // COLUMNS)
    width = COLUMNS * PANEL_IN
    caption = _caption(recording, width)
    height = 0.36 * width + lines * (PANEL_IN + 0.3) + caption.height
    figure = Figure(figsize=(width, height), facecolor="white", layout="constrained")
    draw_caption(figure, caption, width, height)
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0, 0, 1, 1 - caption.height / height))
    grid = figure.add_gridspec(lines + 1, COLUMNS, height_ratios=[0.36 * width, *[PANEL_IN + 0.3] * lines])
    _overview(figure.add_subplot(grid[0, :]), recording, view, len(recording.points) - 1, rows)
    for number, row in enumerate(rows):
        axes = figure.add_subplot(grid[1 + number // COLUMNS, number % COLUMNS])
        _close_up(axes, recording, view, int(row))
        report_progress(number + 1, len(rows))
    return figure


def _frames(recording: SpaceRecording, view: View, rows: Floats, report_progress: Progress) -> Frames:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width, below = FRAME_IN
    caption = _caption(recording, width, SPEED)
    height = 2 * round((below + caption.height) * DPI / 2) / DPI
    share = (below - 0.4) / height  # room for the close-up's text, and below
    for number, row in enumerate(rows):
        figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
        canvas = FigureCanvasAgg(figure)
        draw_caption(figure, caption, width, height)
        _overview(figure.add_axes((0.01, 0.02, 0.44, share)), recording, view, int(row), rows[:0])
        _close_up(figure.add_axes((0.48, 0.02, 0.51, share)), recording, view, int(row))
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
        report_progress(number + 1, len(rows))


def _overview(axes: Axes, recording: SpaceRecording, view: View, row: int, marked: Floats) -> None:
    """Draw the whole route and the path of the robot's middle so far, with the moments of the close-ups."""
    _pipe(axes, recording, view)
    middle = recording.points.mean(axis=1)
    path = m_to_mm(1.0) * view.flat(middle[: row + 1])
    axes.plot(*path.T, color=INK, linewidth=1.0, zorder=6)
    for number, at in enumerate(marked, 1):
        x, y = m_to_mm(1.0) * view.flat(middle[at])
        axes.text(x, y, f"{number}", fontsize=8, ha="center", va="center", zorder=8, bbox=_badge())
    if not len(marked):
        axes.plot(*path[-1], "o", color=FORCE, markersize=7, zorder=8)
    axes.set(aspect="equal")
    axes.set_axis_off()
    if row == len(recording.points) - 1:
        outcome = f"{recording.outcome} after {recording.time[-1]:.1f} s"
        colour = SUCCEEDED if recording.succeeded else FAILED
        axes.text(0.0, 0.0, outcome, transform=axes.transAxes, color=colour, fontweight="bold")


def _caption(recording: SpaceRecording, width: float, speed: str = "") -> Caption:
    """Route, what acted and with which settings, colours, and a film's speed, in lines of a width [in]."""
    acted = details_of(recording.controller, recording.robot.name, recording.backend, recording.options, recording.seed)
    parts = (acted, "rear half blue, front half orange", speed)
    return caption_of(f"{recording.route.label}: whole robot", " · ".join(part for part in parts if part), width)


def _badge() -> dict[str, Any]:
    return {"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": INK, "linewidth": 0.7}


def _close_up(axes: Axes, recording: SpaceRecording, view: View, row: int) -> None:
    """Draw the robot in the pipe that is cut open towards the viewer."""
    from matplotlib.collections import PolyCollection

    points = recording.points[row]
    middle = points.mean(axis=0)
    _pipe(axes, recording, view, middle)
    links, discs, half = faces(recording.robot, points, recording.normals[row])
    pieces = len(links) // 6
    shapes = [*links, *discs]
    colours = np.concatenate([np.repeat(HALF_COLOURS[half[:pieces]], 6, axis=0), 0.45 * HALF_COLOURS[half[pieces:]]])
    order = np.argsort([shape.mean(axis=0) @ view.to_viewer for shape in shapes])
    drawn = [m_to_mm(1.0) * view.flat(shapes[i]) for i in order]
    axes.add_collection(PolyCollection(drawn, facecolors=colours[order], edgecolors="white", linewidths=0.3, zorder=5))
    x, y = m_to_mm(1.0) * view.flat(middle)
    reach = m_to_mm(REACH)
    axes.set(xlim=(x - reach, x + reach), ylim=(y - reach, y + reach), aspect="equal", xticks=[], yticks=[])
    draw_scale(axes, x - 0.94 * reach, y - 0.9 * reach, 2 * reach, fontsize=8)
    axes.set_title(f"{recording.time[row]:.1f} s   {recording.doing[row]}", loc="left", fontsize=9, color=INK)


def _pipe(axes: Axes, recording: SpaceRecording, view: View, around: Floats | None = None) -> None:
    """Draw the far half of the wall, seen from inside, near a point or all of it."""
    from matplotlib.collections import PolyCollection

    pieces = wall_quads(recording.route)
    if around is not None:
        pieces = pieces[np.linalg.norm(pieces.mean(axis=1) - around, axis=1) < 2 * REACH]
    normal = np.cross(pieces[:, 1] - pieces[:, 0], pieces[:, 3] - pieces[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    facing = normal @ view.to_viewer
    far = facing < 0
    shade = 1.0 - 0.35 * (1.0 + facing[far])[:, None]
    colours = np.clip(shade * BORE, 0, 1)
    order = np.argsort(pieces[far].mean(axis=1) @ view.to_viewer)
    drawn = m_to_mm(1.0) * view.flat(pieces[far][order])
    axes.add_collection(PolyCollection(list(drawn), facecolors=colours[order], edgecolors="none", zorder=2))
    if around is None:
        axes.update_datalim(drawn.reshape(-1, 2))
        axes.autoscale_view()
