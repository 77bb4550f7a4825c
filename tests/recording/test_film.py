"""Pictures and films of motions: kinds, sizes, times, and what keeps one from being written."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from helpers.checkout import ROOT
from helpers.films import ROBOT, TWO, motion
from matplotlib.figure import Figure
from PIL import Image

from pipenav.errors import FileProblem, PipenavError
from pipenav.motions.trajectory import Trajectory
from pipenav.pipes.corner import PipeCorner
from pipenav.recording import film, film_files
from pipenav.recording.film import box_of, write_film
from pipenav.recording.film_files import check_suffix
from pipenav.robots.outline import link_outlines


@pytest.mark.parametrize(
    "pipe",
    [
        PipeCorner.of(100, 90),
        PipeCorner.of(70, 55, "right"),
        PipeCorner.of(120, 125),
        PipeCorner.of(90, 90, "left", 150),
    ],
)
def test_everything_that_moves_is_in_the_picture(pipe: PipeCorner) -> None:
    one = motion(5, pipe)
    box = box_of(one)
    points = np.concatenate([polygon.reshape(-1, 2) for link in link_outlines(ROBOT, one.q) for polygon in link])
    points = (
        np.concatenate([points + np.array([one.header.base_m, 0.0]), [one.header.goal_m], pipe.walls.outer[1:-1]]) * 1e3
    )
    assert (points > [box.left, box.bottom]).all()
    assert (points < [box.right, box.top]).all()


@pytest.mark.slow
def test_a_strip_is_one_picture_with_a_row_for_each_motion(tmp_path: Path) -> None:
    reports: list[tuple[int, int]] = []
    write_film(tmp_path / "one.png", TWO[:1])
    write_film(tmp_path / "two.png", TWO, lambda done, total: reports.append((done, total)))
    one, two = (Image.open(tmp_path / name).size for name in ("one.png", "two.png"))
    assert one[0] == two[0]
    assert two[1] > 1.5 * one[1]
    assert reports == [(i, 7) for i in range(1, 8)]


def test_a_strip_of_a_long_motion_has_its_first_and_last_frame(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    rows: list[int] = []
    monkeypatch.setattr(film, "_frame", lambda *given, **_: rows.append(given[2]))
    write_film(tmp_path / "long.png", [motion(101, PipeCorner.of(100, 90))])
    assert (rows[0], rows[-1], len(rows)) == (0, 100, film.PANELS)
    assert np.ptp(np.diff(rows)) <= 1


@pytest.mark.slow
def test_a_gif_is_in_real_time_and_rests_on_last_frames(tmp_path: Path) -> None:
    write_film(tmp_path / "two.gif", TWO)
    picture = Image.open(tmp_path / "two.gif")
    durations = []
    for number in range(picture.n_frames):
        picture.seek(number)
        durations.append(picture.info["duration"])
    assert durations == [100, 100, 100, 1200, 100, 100, 1200]


@pytest.mark.slow
def test_an_mp4_is_in_real_time_for_every_player(tmp_path: Path) -> None:
    write_film(tmp_path / "two.mp4", TWO)
    frames = imageio_ffmpeg.read_frames(str(tmp_path / "two.mp4"))
    about = next(frames)
    assert about["fps"] == 10
    assert about["pix_fmt"].startswith("yuv420p")
    assert all(turn_sign % 2 == 0 for turn_sign in about["size"])
    assert len(list(frames)) == 7 + 2 * (film_files.HOLD - 1)


def test_frames_of_one_film_differ_and_are_of_one_size() -> None:
    pictures = list(film._frames(TWO, lambda *_: None))
    assert len({picture.shape for picture in pictures}) == 1
    assert all((one != two).any() for one, two in pairwise(pictures))


def test_the_legend_holds_only_what_is_there() -> None:
    def shown(motions: list[Trajectory]) -> list[str]:
        figure = Figure()
        film._legend(figure, motions)
        return [text.get_text() for text in figure.legends[0].texts]

    free = Trajectory(TWO[0].header.model_copy(update={"goal_m": None}), ROBOT, TWO[0].q)
    assert shown(TWO) == ["robot", "target", "laser beam", "contact force"]
    assert shown([free]) == ["robot", "laser beam"]
    assert shown([free, TWO[0]]) == shown(TWO)


def test_the_outcome_stands_in_the_last_frame_alone() -> None:
    one = TWO[0]
    for row in range(len(one.q)):
        axes = Figure().add_subplot()
        film._frame(axes, one, row, box_of(one), size=8)
        assert axes.get_title("right") == ("reached" if row == len(one.q) - 1 else "")


def test_other_suffixes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match=r"picture\.jpg: its suffix must be one of: \.png, \.gif, \.mp4"):
        write_film(tmp_path / "picture.jpg", TWO)
    write_film(tmp_path / "LOUD.PNG", TWO[:1])


def test_too_many_motions_for_a_strip(tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match="are too many for one strip"):
        write_film(tmp_path / "many.png", TWO * 20)


def test_without_ffmpeg_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(PipenavError, match=r"MP4 needs ffmpeg, which is not installed: pip install imageio-ffmpeg"):
        check_suffix(tmp_path / "film.mp4")
    (tmp_path / "ffmpeg").write_text("#!/bin/sh\n")
    (tmp_path / "ffmpeg").chmod(0o755)
    check_suffix(tmp_path / "film.mp4")


def test_an_encoder_that_fails_leaves_the_old_file_and_its_words(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    encoder = tmp_path / "encoder"
    encoder.write_text("#!/bin/sh\necho no such codec >&2\nexit 3\n")
    encoder.chmod(0o755)
    monkeypatch.setattr(film_files, "_ffmpeg", lambda: str(encoder))
    (tmp_path / "film.mp4").write_bytes(b"old")
    with pytest.raises(FileProblem, match="ffmpeg says: no such codec"):
        write_film(tmp_path / "film.mp4", TWO[:1])
    assert (tmp_path / "film.mp4").read_bytes() == b"old"
    assert {path.name for path in tmp_path.iterdir()} == {"encoder", "film.mp4"}


@pytest.mark.slow
def test_drawing_needs_no_display(tmp_path: Path) -> None:
    program = (
        "import os, sys\n"
        "os.environ.pop('DISPLAY', None)\n"
        "from pathlib import Path\n"
        "sys.path.append('tests')\n"
        "from helpers.films import TWO\n"
        "from pipenav.recording.film import write_film\n"
        "write_film(Path(sys.argv[1]), TWO[:1])\n"
        "assert not {'matplotlib.pyplot', 'OpenGL', 'glfw'} & set(sys.modules)\n"
    )
    picture = str(tmp_path / "a.png")
    subprocess.run([sys.executable, "-c", program, picture], check=True, cwd=ROOT)
