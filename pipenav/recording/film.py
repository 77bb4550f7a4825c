"""Pictures of recorded motions: a strip of frames as PNG, or a film as GIF or MP4 in real time."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipenav.drawing.dimensions import INK
from pipenav.drawing.scene import LEAST_FORCE, Scene, draw_force_key, draw_scene, legend_handles
from pipenav.errors import PipenavError
from pipenav.motions.trajectory import Trajectory
from pipenav.recording.caption import Caption, caption_of, details_of, draw_caption, draw_scale
from pipenav.recording.film_files import Frames, check_suffix, write_frames
from pipenav.recording.overview import close_box, draw_overview, has_overview, number_panel, overview_box
from pipenav.recording.view_box import MARGIN, ViewBox
from pipenav.robots import kinematics, laser
from pipenav.robots.outline import link_outlines
from pipenav.storage.atomic_files import atomic_write
from pipenav.tasks.outcome import PassageStage
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Progress = Callable[[int, int], None]

PANELS = 8
"""Most frames of one motion in a strip: two rows of four still show the robot's links clearly."""

COLUMNS = 4
PANEL_IN = 3.4
"""Width of a panel of a strip [in]."""

TEXT_IN = 0.3
"""Height of the text above a panel [in]."""

MAX_ROWS = 24
"""Most rows of panels in a strip; a picture of more is taller than what programs open."""

MOST_IN_STRIP = MAX_ROWS // (PANELS // COLUMNS)
"""Most motions in a strip, each with all its panels."""

FRAME_IN = 8.0
"""Width of a film's frame [in]."""

FOOT_IN = 0.45
"""Height of the legend [in]."""

REAL_TIME = "film in real time"

DPI = 100

KEY_ROOM = 0.06
"""Room below all that moves for the force's scale, as a share of the picture's width."""

SUCCEEDED, FAILED = "#007a5a", "#b04a00"
"""Colours behind an outcome's word."""


def write_film(path: Path, trajectories: Sequence[Trajectory], progress: Progress | None = None) -> None:
    """Draw motions one after another into a file of the kind that its suffix names: .png, .gif or .mp4.

    Args:
        path: the file.
        trajectories: the motions, at least one.
        progress: called with (frames drawn, frames in all).

    Raises:
        PipenavError: another suffix, MP4 without ffmpeg, or more motions than a strip can hold.
        FileProblem: the file cannot be written.
    """
    check_suffix(path)
    report_progress = progress or (lambda _done, _total: None)
    if path.suffix.lower() == ".png":
        atomic_write(path, _strip(trajectories, report_progress))
    else:
        ends = set(np.cumsum([len(motion.q) for motion in trajectories]) - 1)
        write_frames(path, _frames(trajectories, report_progress), ends)


def box_of(trajectory: Trajectory) -> ViewBox:
    """Box that a picture of the motion must show: the robot in every pose, the target, the pipe's walls around them."""
    header, pipe = trajectory.header, trajectory.header.pipe
    polygons = [polygon for link in link_outlines(trajectory.robot, trajectory.q) for polygon in link]
    points = np.concatenate([polygon.reshape(-1, 2) for polygon in polygons]) + np.array([header.base_m, 0.0])
    points = np.concatenate(
        [points, *(wall.face[1:-1] for wall in pipe.wall_sides), np.reshape(header.goal_m or (), (-1, 2))]
    )
    rear = points[:, 0].min()
    points = np.concatenate([points, [[rear, -pipe.radius], [rear, pipe.radius]]])
    margin = MARGIN * float(np.ptp(points[:, 0]))
    low, high = m_to_mm(1.0) * (points.min(axis=0) - margin), m_to_mm(1.0) * (points.max(axis=0) + margin)
    return ViewBox(float(low[0]), float(high[0]), float(low[1] - KEY_ROOM * (high[0] - low[0])), float(high[1]))


class _Layout(NamedTuple):
    """Layout of a motion's part of a strip.

    Attributes:
        caption: its caption.
        whole: box of the picture of the whole route; None without one.
        overview: height of that picture [in].
        box: box of its panels, of which only the proportions count where they follow the robot.
        height: height of the whole part [in].
    """

    caption: Caption
    whole: ViewBox | None
    overview: float
    box: ViewBox
    height: float

    @classmethod
    def of(cls, motion: Trajectory, lines: int, width: float) -> _Layout:
        """The layout of a motion with so many lines of panels, in a strip of a width [in]."""
        caption = _caption(motion, width)
        whole = overview_box(motion) if has_overview(motion) else None
        overview = 0.0 if whole is None else width * whole.aspect
        box = box_of(motion) if whole is None else close_box(motion, 0)
        height = caption.height + overview + lines * (PANEL_IN * box.aspect + TEXT_IN)
        return cls(caption, whole, overview, box, height)


def _strip(trajectories: Sequence[Trajectory], report_progress: Progress) -> bytes:
    """PNG picture of a few frames of each motion, evenly in time."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = [np.unique(np.linspace(0, len(motion.q) - 1, PANELS).round().astype(int)) for motion in trajectories]
    lines = [-(-len(chosen) // COLUMNS) for chosen in rows]
    if sum(lines) > MAX_ROWS:
        raise PipenavError(
            f"{len(trajectories)} motions are too many for one strip: name fewer pipes, or give --out a name ending in "
            ".gif or .mp4."
        )
    width = COLUMNS * PANEL_IN
    layouts = [_Layout.of(motion, count, width) for motion, count in zip(trajectories, lines, strict=True)]
    heights = [layout.height for layout in layouts]
    figure = Figure(figsize=(width, sum(heights) + FOOT_IN), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    grids: Any = figure.subfigures(len(trajectories) + 1, 1, height_ratios=[*heights, FOOT_IN], squeeze=False)[:, 0]
    drawn, total = 0, sum(map(len, rows))
    for motion, chosen, grid, layout in zip(trajectories, rows, grids[:-1], layouts, strict=True):
        draw_caption(grid, layout.caption, width, layout.height)
        whole = layout.whole
        if whole is not None:
            below = 1 - (layout.caption.height + layout.overview) / layout.height
            axes = grid.add_axes((0.005, below, 0.99, layout.overview / layout.height))
            draw_overview(axes, motion, chosen.tolist(), whole)
        panels = grid.subplots(-(-len(chosen) // COLUMNS), COLUMNS, squeeze=False)
        top = 1 - (layout.caption.height + layout.overview + TEXT_IN) / layout.height
        grid.subplots_adjust(left=0.005, right=0.995, bottom=0.0, top=top, wspace=0.03)
        grid.subplots_adjust(hspace=TEXT_IN / (PANEL_IN * layout.box.aspect))
        for axes in panels.flat[len(chosen) :]:
            axes.set_axis_off()
        for number, (axes, row) in enumerate(zip(panels.flat, chosen, strict=False), 1):
            box = layout.box if whole is None else close_box(motion, int(row))
            _frame(axes, motion, int(row), box, size=8.5)
            if whole is not None:
                number_panel(axes, number)
            report_progress(drawn := drawn + 1, total)
    _legend(grids[-1], trajectories)
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=DPI)
    return picture.getvalue()


def _frames(trajectories: Sequence[Trajectory], report_progress: Progress) -> Frames:
    """Frames of every control step of every motion."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    boxes = [box_of(motion) for motion in trajectories]
    captions = [_caption(motion, FRAME_IN, REAL_TIME) for motion in trajectories]
    head = max(caption.height for caption in captions)
    height = max(FRAME_IN * box.aspect for box in boxes) + head + TEXT_IN + FOOT_IN
    height = 2 * round(height * DPI / 2) / DPI
    total, drawn = sum(len(motion.q) for motion in trajectories), 0
    for motion, box, caption in zip(trajectories, boxes, captions, strict=True):
        for row in range(len(motion.q)):
            figure = Figure(figsize=(FRAME_IN, height), dpi=DPI, facecolor="white")
            canvas = FigureCanvasAgg(figure)
            bands: Any = figure.subfigures(3, 1, height_ratios=[head, height - head - FOOT_IN, FOOT_IN])
            top, middle, bottom = bands
            draw_caption(top, caption, FRAME_IN, head)
            axes = middle.add_axes((0.01, 0.0, 0.98, 1 - TEXT_IN / (height - head - FOOT_IN)))
            _frame(axes, motion, row, box, size=11)
            _legend(bottom, [motion])
            canvas.draw()
            yield np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
            report_progress(drawn := drawn + 1, total)


def _frame(axes: Axes, trajectory: Trajectory, row: int, box: ViewBox, size: float) -> None:
    """Draw a panel: the scene, above it time, largest contact force and, at the end, the outcome."""
    draw_scene(axes, scene_of(trajectory, row))
    width = box.right - box.left
    low = box.bottom + 0.04 * width
    if _touches(trajectory):
        draw_force_key(axes, box.left + 0.03 * width, low, size)
    draw_scale(axes, box.left + (0.3 if _touches(trajectory) else 0.03) * width, low, width, size)
    axes.set(xlim=(box.left, box.right), ylim=(box.bottom, box.top), aspect="equal", xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_color("#d5dbe1")
    text = f"{trajectory.time[row]:.1f} s"
    if trajectory.contact_force is not None:
        text += f"   {trajectory.contact_force[row]:.1f} N"
    axes.set_title(text, loc="left", fontsize=size, color=INK, pad=5)
    outcome = trajectory.header.outcome
    if row == len(trajectory.q) - 1 and outcome is not None:
        frame = {"boxstyle": "round,pad=0.2", "edgecolor": "none"}
        frame["facecolor"] = SUCCEEDED if trajectory.succeeded else FAILED
        axes.set_title(outcome, loc="right", fontsize=size, fontweight="bold", color="white", pad=5, bbox=frame)


STAGE_WORDS = {
    PassageStage.REACH: "front half",
    PassageStage.LOCATE: "locating a target",
    PassageStage.REAR: "rear half, mirrored pipe",
    PassageStage.TRAVERSE: "whole robot",
}


def _caption(trajectory: Trajectory, width: float, speed: str = "") -> Caption:
    """Pipe and stage, what acted and with which settings, and a film's speed, in lines of a width [in]."""
    header = trajectory.header
    details = details_of(header.controller, header.robot, header.backend, header.options, header.seed)
    title = f"{header.pipe.label}: {STAGE_WORDS[header.stage]}"
    gravity = None if header.gravity_mps2 is None else np.array([*header.gravity_mps2, 0.0])
    return caption_of(title, " · ".join(part for part in (details, speed) if part), width, gravity)


def _touches(trajectory: Trajectory) -> bool:
    """Whether the motion has a contact force that is drawn."""
    forces = trajectory.link_forces
    return forces is not None and bool((np.linalg.norm(forces, axis=2) >= LEAST_FORCE).any())


def _legend(figure: Any, trajectories: Sequence[Trajectory]) -> None:
    """Draw the meaning of the marks that some motion has, in one line."""
    target = any(motion.header.goal_m is not None for motion in trajectories)
    handles = legend_handles(target=target, forces=any(map(_touches, trajectories)))
    figure.legend(handles=handles, loc="center", ncols=4, frameon=False, fontsize=9.5, labelcolor=INK)


def scene_of(trajectory: Trajectory, row: int) -> Scene:
    """The scene of a row. Its beams are those of a laser without noise: a trajectory does not hold them."""
    header, robot, q = trajectory.header, trajectory.robot, trajectory.q[row]
    pose = kinematics.forward(robot, q[None])
    tip, beams = pose.tip + np.array([header.base_m, 0.0]), pose.headings[:, -1:] + robot.laser.angles
    ranges = laser.measure(robot.laser, laser.cast(tip, beams, header.pipe.segments[None]))[0]
    target = None if header.goal_m is None else np.array(header.goal_m)
    forces = None if trajectory.link_forces is None else trajectory.link_forces[row]
    return Scene(header.pipe, robot, header.base_m, q, ranges, target, forces)
