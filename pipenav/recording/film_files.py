"""Films as files: GIF or MP4, a frame in a control period."""

from __future__ import annotations

import contextlib
import errno
import io
import itertools
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.errors import PipenavError
from pipenav.storage.atomic_files import atomic_write

Frames = Iterator[NDArray[np.uint8]]
"""Pictures one after another, (height, width, 3) each, all of one size with even sides."""

SUFFIXES = (".png", ".gif", ".mp4")
"""Suffixes of the files that a motion can be drawn into."""

HOLD = 12
"""Control periods for which the last frame of each motion stays, to be read."""


def write_frames(path: Path, frames: Frames, ends: set[int]) -> None:
    """Write a film, a frame in a control period.

    Args:
        path: the file, .gif or .mp4.
        frames: the pictures.
        ends: numbers of the frames that stay for a while.

    Raises:
        PipenavError: MP4 without ffmpeg.
        FileProblem: the file cannot be written.
    """
    if path.suffix.lower() == ".gif":
        atomic_write(path, _gif(frames, ends))
    else:
        encoder = _ffmpeg()
        atomic_write(path, lambda draft: _mp4(draft, encoder, frames, ends))


def check_suffix(path: Path, known: Sequence[str] = SUFFIXES) -> None:
    """Refuse a file whose suffix is not known, and MP4 where ffmpeg is missing."""
    if path.suffix.lower() not in known:
        raise PipenavError(f"{path}: its suffix must be one of: {', '.join(known)}.")
    if path.suffix.lower() == ".mp4":
        _ffmpeg()


def _gif(frames: Frames, ends: set[int]) -> bytes:
    from PIL import Image

    pictures, durations = [], []
    period = round(1000 * CONTROL_PERIOD)  # milliseconds
    for number, pixels in enumerate(frames):
        pictures.append(Image.fromarray(pixels).quantize(128, dither=Image.Dither.NONE))
        durations.append(period * HOLD if number in ends else period)
    film = io.BytesIO()
    pictures[0].save(film, format="GIF", save_all=True, append_images=pictures[1:], duration=durations, loop=0)
    return film.getvalue()


def _ffmpeg() -> str:
    """The program that encodes MP4: the one that imageio-ffmpeg brings, or the system's."""
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):  # RuntimeError: the package has no program for this platform
        program = shutil.which("ffmpeg")
    if program is None:
        raise PipenavError(
            "MP4 needs ffmpeg, which is not installed: pip install imageio-ffmpeg, or give --out a name ending in .gif."
        )
    return program


def _mp4(draft: Path, encoder: str, frames: Frames, ends: set[int]) -> None:
    first = next(frames)
    size, rate = f"{first.shape[1]}x{first.shape[0]}", f"{1 / CONTROL_PERIOD:g}"
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", rate, "-i", "-"]
    # This colour format is the one that every player shows.
    command = [encoder, "-y", "-v", "error", *raw, "-pix_fmt", "yuv420p", "-movflags", "+faststart", str(draft)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None and process.stderr is not None
        with contextlib.suppress(BrokenPipeError):  # the encoder says why it left
            for number, pixels in enumerate(itertools.chain([first], frames)):
                process.stdin.write(pixels.tobytes() * (HOLD if number in ends else 1))
            process.stdin.close()
        said = process.stderr.read().decode(errors="replace").strip()
    if process.returncode:
        raise OSError(errno.EIO, f"ffmpeg says: {' '.join(said.split())}")
