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
from pipenav.drawing.down import WEIGHTLESS
from pipenav.drawing.labels import around
from pipenav.drawing.projection import CutOpen, View
from pipenav.drawing.scene import FORCE
from pipenav.pipes.pipe_system import system_of
from pipenav.recording.caption import Caption, caption_of, details_of, draw_caption, draw_scale
from pipenav.recording.film import DPI, FAILED, SUCCEEDED
from pipenav.recording.film_files import Frames, write_frames
from pipenav.recording.overview import badge, labels_around, number_panel
from pipenav.recording.record_rolling import SpaceRecording
from pipenav.robots.robot import RobotSpec
from pipenav.storage.atomic_files import atomic_write
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Progress = Callable[[int, int], None]

HALF_COLOURS = np.array([[0.00, 0.45, 0.70], [0.84, 0.37, 0.00]])
"""Colours of the rear and the front half: Okabe and Ito's blue and vermilion, as elsewhere."""

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
    system = system_of(recording.route)
    pipe = CutOpen.of(system, View.of(system))
    if path.suffix.lower() == ".png":
        picture = io.BytesIO()
        _strip(recording, pipe, progress).savefig(picture, format="png", dpi=DPI)
        atomic_write(path, picture.getvalue())
        return
    rows = np.append(np.arange(0, len(recording.points) - 1, SKIP), len(recording.points) - 1)
    frames = _frames(recording, pipe, rows, progress)
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


def _strip(recording: SpaceRecording, pipe: CutOpen, report_progress: Progress) -> Any:
    """Figure of the whole route above a few moments, evenly in time."""
    from matplotlib.figure import Figure

    rows = np.unique(np.linspace(0, len(recording.points) - 1, PANELS).round().astype(int))
    lines = -(-len(rows) // COLUMNS)
    width = COLUMNS * PANEL_IN
    caption = _caption(recording, width, pipe.view)
    height = 0.36 * width + lines * (PANEL_IN + 0.3) + caption.height
    figure = Figure(figsize=(width, height), facecolor="white", layout="constrained")
    draw_caption(figure, caption, width, height)
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0, 0, 1, 1 - caption.height / height))
    grid = figure.add_gridspec(lines + 1, COLUMNS, height_ratios=[0.36 * width, *[PANEL_IN + 0.3] * lines])
    _overview(figure.add_subplot(grid[0, :]), recording, pipe, len(recording.points) - 1, rows)
    for number, row in enumerate(rows):
        axes = figure.add_subplot(grid[1 + number // COLUMNS, number % COLUMNS])
        _close_up(axes, recording, pipe, int(row))
        number_panel(axes, number + 1)
        report_progress(number + 1, len(rows))
    return figure


def _frames(recording: SpaceRecording, pipe: CutOpen, rows: Floats, report_progress: Progress) -> Frames:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width, below = FRAME_IN
    caption = _caption(recording, width, pipe.view, SPEED)
    height = 2 * round((below + caption.height) * DPI / 2) / DPI
    share = (below - 0.4) / height  # room for the close-up's text, and below
    for number, row in enumerate(rows):
        figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
        canvas = FigureCanvasAgg(figure)
        draw_caption(figure, caption, width, height)
        _overview(figure.add_axes((0.01, 0.02, 0.44, share)), recording, pipe, int(row), rows[:0])
        _close_up(figure.add_axes((0.48, 0.02, 0.51, share)), recording, pipe, int(row))
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
        report_progress(number + 1, len(rows))


def _overview(axes: Axes, recording: SpaceRecording, pipe: CutOpen, row: int, marked: Floats) -> None:
    """Draw the whole route, the path of the robot's middle so far, and its poses, numbered where there are several."""
    view, mm = pipe.view, m_to_mm(1.0)
    drawn = pipe.draw(axes)
    middle = mm * view.flat(recording.points.mean(axis=1))
    axes.plot(*middle[: row + 1].T, color=INK, linewidth=0.8, zorder=4)
    width = float(np.ptp(drawn, axis=0).max())
    system = system_of(recording.route)
    off = mm * (float(recording.route.legs.radius.max()) + system.wall) + 0.025 * width
    labels = labels_around(system, view, width)
    for number, at in enumerate(marked, 1):
        _robot(axes, recording, view, int(at))
        beside = labels.best("00", around(middle[at], off, np.array([0.0, 1.0]), 16)).at
        x, y = beside
        axes.plot(*np.stack([middle[at], beside]).T, color=INK, linewidth=0.5, zorder=6)
        axes.text(x, y, f"{number}", fontsize=8, ha="center", va="center", zorder=8, bbox=badge())
        drawn = np.concatenate([drawn, beside[None]])
    if not len(marked):
        _robot(axes, recording, view, row)
        axes.plot(*middle[row], "o", color="none", markeredgecolor=FORCE, markersize=24, markeredgewidth=1.2, zorder=8)
    margin = 0.02 * width
    (left, bottom), (right, top) = drawn.min(axis=0) - margin, drawn.max(axis=0) + margin
    axes.set(xlim=(left, right), ylim=(bottom - 0.05 * width, top), aspect="equal")
    draw_scale(axes, left, bottom - 0.03 * width, width, fontsize=8)
    axes.set_axis_off()
    if row == len(recording.points) - 1:
        outcome = f"{recording.outcome} after {recording.time[-1]:.1f} s"
        colour = SUCCEEDED if recording.succeeded else FAILED
        axes.set_title(outcome, loc="left", color=colour, fontsize=10, fontweight="bold")


def _caption(recording: SpaceRecording, width: float, view: View, speed: str = "") -> Caption:
    """Route, what acted and with which settings, colours, and a film's speed, in lines of a width [in]."""
    acted = details_of(recording.controller, recording.robot.name, recording.backend, recording.options, recording.seed)
    gravity = recording.gravity
    weightless = WEIGHTLESS if gravity is not None and not gravity.any() else ""
    parts = (acted, "rear half blue, front half orange", weightless, speed)
    title, details = f"{recording.route.label}: whole robot", " · ".join(part for part in parts if part)
    down = None if gravity is None or weightless else view.seen(gravity)
    return caption_of(title, details, width, down)


def _close_up(axes: Axes, recording: SpaceRecording, pipe: CutOpen, row: int) -> None:
    """Draw the robot in the pipe that is cut open towards the viewer."""
    middle = recording.points[row].mean(axis=0)
    pipe.near(middle, 2 * REACH).draw(axes)
    _robot(axes, recording, pipe.view, row)
    x, y = m_to_mm(1.0) * pipe.view.flat(middle)
    reach = m_to_mm(REACH)
    axes.set(xlim=(x - reach, x + reach), ylim=(y - reach, y + reach), aspect="equal", xticks=[], yticks=[])
    draw_scale(axes, x - 0.94 * reach, y - 0.9 * reach, 2 * reach, fontsize=8)
    axes.set_title(f"{recording.time[row]:.1f} s   {recording.doing[row]}", loc="left", fontsize=9, color=INK)


def _robot(axes: Axes, recording: SpaceRecording, view: View, row: int) -> None:
    """Draw the robot's links and wheels in a row, its halves in two colours."""
    from matplotlib.collections import PolyCollection

    links, discs, half = faces(recording.robot, recording.points[row], recording.normals[row])
    pieces = len(links) // 6
    shapes = [*links, *discs]
    colours = np.concatenate([np.repeat(HALF_COLOURS[half[:pieces]], 6, axis=0), 0.45 * HALF_COLOURS[half[pieces:]]])
    order = np.argsort([shape.mean(axis=0) @ view.to_viewer for shape in shapes])
    drawn = [m_to_mm(1.0) * view.flat(shapes[i]) for i in order]
    axes.add_collection(PolyCollection(drawn, facecolors=colours[order], edgecolors="white", linewidths=0.3, zorder=5))
