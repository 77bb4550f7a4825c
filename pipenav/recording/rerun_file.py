"""Motions as a recording for the Rerun viewer: walls, moving links, tip, beams, target, numbers over time."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np

from pipenav.errors import PipenavError
from pipenav.recording.posed_motion import PosedMotion
from pipenav.robots.parts import Link
from pipenav.storage.atomic_files import atomic_write

INSTALL = "pip install 'pipenav[rerun]'"
"""Advice where the library is missing."""

SUFFIX = ".rrd"

TIMELINE = "time"
"""Name of the timeline, seconds since the first motion began."""

PAUSE = 1.0
"""Time between two motions that follow each other in a recording [s]."""

WALL, LINK, WHEEL, TIP, BEAM, TARGET = 0x6B7280FF, 0x2F7FC1FF, 0x404854FF, 0x0F9488FF, 0xB453BFFF, 0xD4500CFF
"""Colours, red, green, blue and opacity in a byte each."""


def write_rerun(path: Path, motions: Sequence[PosedMotion]) -> None:
    """Write motions, one after the other, as a recording of the Rerun viewer.

    Args:
        path: the file, .rrd.
        motions: the motions; at least one.

    Raises:
        PipenavError: rerun-sdk is not installed, or the suffix is another one.
        FileProblem: the file cannot be written.
    """
    check_rerun(path)
    atomic_write(path, lambda draft: _record(draft, motions))


def check_rerun(path: Path) -> None:
    """Refuse a file of another suffix, and any where rerun-sdk is missing.

    Raises:
        PipenavError: one of the two.
    """
    if path.suffix.lower() != SUFFIX:
        raise PipenavError(f"{path}: a recording for Rerun needs a name ending in {SUFFIX}.")
    _rerun()


def _rerun() -> Any:
    """The module of the extra `rerun`."""
    try:
        import rerun
    except ImportError as error:
        raise PipenavError(f"a recording for Rerun needs the extra 'rerun': {INSTALL}.") from error
    return rerun


def _record(draft: Path, motions: Sequence[PosedMotion]) -> None:
    rr = _rerun()
    stream = rr.RecordingStream("pipenav", send_properties=False)
    stream.save(draft)
    begins = [0.0, *accumulate(float(motion.time[-1] - motion.time[0]) + PAUSE for motion in motions[:-1])]
    for number, (motion, begin) in enumerate(zip(motions, begins, strict=True)):
        before = f"motion_{number + 1}/" if len(motions) > 1 else ""
        times = rr.TimeColumn(TIMELINE, duration=motion.time - motion.time[0] + begin)
        _log_still(rr, stream, before, motion)
        _log_robot(rr, stream, before, motion, times)
        _log_series(rr, stream, before, motion, begin)
    stream.flush()
    stream.disconnect()


def _log_still(rr: Any, stream: Any, before: str, motion: PosedMotion) -> None:
    """Log all that does not move."""
    stream.log(before + "about", rr.TextDocument(motion.name), static=True)
    walls = rr.LineStrips3D([line.astype(np.float32) for line in motion.walls], colors=[WALL])
    stream.log(before + "pipe/walls", walls, static=True)
    if motion.target is not None:
        stream.log(before + "pipe/target", rr.Points3D([motion.target], radii=[0.008], colors=[TARGET]), static=True)
    for link in motion.robot.links:
        name = f"{before}robot/{link.name}"
        stream.log(f"{name}/shape", _box(rr, link), static=True)
        if link.wheel is not None:
            stream.log(f"{name}/wheel", _wheel(rr, link), static=True)


def _box(rr: Any, link: Link) -> Any:
    """A link in its own frame, which begins at its rear end."""
    half = [link.length / 2, link.width / 2, link.height / 2]
    return rr.Boxes3D(centers=[[link.length / 2, 0, 0]], half_sizes=[half], colors=[LINK], fill_mode="solid")


def _wheel(rr: Any, link: Link) -> Any:
    assert link.wheel is not None
    return rr.Cylinders3D(
        lengths=[1.2 * link.height],
        radii=[link.wheel.radius],
        centers=[[link.wheel.x, 0, 0]],
        colors=[WHEEL],
        fill_mode="solid",
    )


def _log_robot(rr: Any, stream: Any, before: str, motion: PosedMotion, times: Any) -> None:
    """Log links, tip and beams over time."""
    for i, link in enumerate(motion.robot.links):
        columns = rr.Transform3D.columns(translation=motion.start[:, i], mat3x3=motion.axes[:, i])
        stream.send_columns(f"{before}robot/{link.name}", indexes=[times], columns=columns)
    columns = rr.Points3D.columns(positions=motion.tip, radii=np.full(len(motion.tip), 0.005))
    stream.send_columns(before + "robot_tip", indexes=[times], columns=columns)
    stream.log(before + "robot_tip", rr.Points3D.from_fields(colors=[TIP]), static=True)
    path = motion.tip.astype(np.float32)
    stream.log(before + "robot_path", rr.LineStrips3D([path], colors=[TIP]), static=True)
    if motion.beams is not None:
        met = [ends[met] for ends, met in zip(motion.beams.ends, motion.beams.met, strict=True)]
        columns = rr.Points3D.columns(positions=np.concatenate(met)).partition([len(ends) for ends in met])
        stream.send_columns(before + "laser", indexes=[times], columns=columns)
        stream.log(before + "laser", rr.Points3D.from_fields(colors=[BEAM], radii=[0.003]), static=True)


def _log_series(rr: Any, stream: Any, before: str, motion: PosedMotion, begin: float) -> None:
    """Log numbers over time, without those that are not known, and what happened."""
    time = motion.time - motion.time[0] + begin
    for name, values in motion.series.items():
        known = np.isfinite(values)
        if known.any():
            indexes = [rr.TimeColumn(TIMELINE, duration=time[known])]
            stream.send_columns(before + name, indexes=indexes, columns=rr.Scalars.columns(scalars=values[known]))
    for row, text in motion.events:
        stream.set_time(TIMELINE, duration=float(time[row]))
        stream.log(before + "events", rr.TextLog(text))
