"""Sets of pipes: shipped, typed and from files."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_sets import corner_set_names, parse_corners
from pipenav.units import m_to_mm, rad_to_deg

ANGLES = list(range(55, 126, 5))


def corners(pipes: list[PipeCorner]) -> set[tuple[int, int, str]]:
    return {(round(m_to_mm(pipe.diameter)), round(rad_to_deg(pipe.angle)), pipe.turn) for pipe in pipes}


def written(folder: Path, text: str) -> str:
    path = folder / "mine.toml"
    path.write_text(f'description = "mine"\n{text}', encoding="utf-8")
    return str(path)


def test_the_thesis_evaluates_in_60_pipes() -> None:
    pipes = parse_corners(["thesis"])
    assert len(pipes) == 60
    assert corners(pipes) == {(d, a, "left") for d in (90, 100, 110, 120) for a in ANGLES}


def test_the_thesis_trains_in_7_pipes() -> None:
    pipes = parse_corners(["thesis-train"])
    assert len(pipes) == 7
    assert corners(pipes) == {(120, a, "left") for a in range(60, 121, 10)}


def test_the_working_range_is_90_corners_to_either_side() -> None:
    pipes = parse_corners(["working-range"])
    assert len(pipes) == 180
    assert corners(pipes) == {(d, a, turn) for d in range(70, 121, 10) for a in ANGLES for turn in ("left", "right")}


FRONTIER = [name for name in corner_set_names() if name.startswith(("frontier-", "wider-"))]
"""Sets of pipes that certificates found passable, see tests/certify/test_frontier_sets.py."""


@pytest.mark.parametrize("name", sorted({*corner_set_names()} - {*FRONTIER}))
def test_every_shipped_set_can_be_passed(name: str) -> None:
    for pipe in parse_corners([name]):
        assert 0.07 <= pipe.diameter <= 0.13  # the thesis's physical arm ran in 130 mm
        sharpest = 45 if pipe.branches else 55  # a tee has more room
        assert sharpest <= round(rad_to_deg(pipe.angle), 6) <= (180 if pipe.branches else 140)


def test_a_typed_pipe() -> None:
    assert parse_corners(["d=90,angle=60"]) == [PipeCorner.of(90, 60)]
    assert parse_corners([" d = 90 , turn = right, angle = 60"]) == [PipeCorner.of(90, 60, "right")]
    assert parse_corners(["d=90,angle=60,bend_radius=100"]) == [PipeCorner.of(90, 60, "left", 100)]


def test_pipes_keep_their_order_and_come_once() -> None:
    given = ["d=110,angle=60", "d=90,angle=60", "d=110,angle=60.0,turn=left", "thesis"]
    pipes = parse_corners(given)
    assert pipes[:2] == [PipeCorner.of(110, 60), PipeCorner.of(90, 60)]
    assert len(pipes) == len(set(pipes)) == 60


def test_a_file(tmp_path: Path) -> None:
    body = 'diameters_mm = [80]\nangles_deg = { start = 60, stop = 70, step = 5 }\nturns = ["right"]'
    assert parse_corners([written(tmp_path, body)]) == [PipeCorner.of(80, angle, "right") for angle in (60, 65, 70)]


def test_a_file_with_diameters_of_their_own_for_each_angle(tmp_path: Path) -> None:
    rows = [(60, "[70, 72.5]"), (90, "{ start = 60, stop = 62, step = 1 }")]
    tables = "\n".join(f"[[rows]]\nangle_deg = {angle}\ndiameters_mm = {values}" for angle, values in rows)
    left = [PipeCorner.of(d, angle) for angle, d in ((60, 70), (60, 72.5), (90, 60), (90, 61), (90, 62))]
    assert parse_corners([written(tmp_path, tables)]) == left
    both = parse_corners([written(tmp_path, f'turns = ["left", "right"]\n{tables}')])
    assert both == left + [corner.mirrored for corner in left]


def test_a_file_in_a_folder_whose_name_has_an_equals_sign(tmp_path: Path) -> None:
    folder = tmp_path / "d=80"
    folder.mkdir()
    assert parse_corners([written(folder, "diameters_mm = [80]\nangles_deg = [60]")]) == [PipeCorner.of(80, 60)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("thesi", "unknown pipe set 'thesi': did you mean 'thesis'"),
        ("no-such.toml", "cannot read no-such.toml: No such file or directory; check its name."),
        ("d=90", "pipe 'd=90' is incomplete, without angle: write it as"),
        ("d=90,angle=", "pipe 'd=90,angle=' is incomplete"),
        ("d=90,angle=60,d=100", "pipe 'd=90,angle=60,d=100' says d twice: say it once."),
        ("d=90,angle=60,turn=", "turn '' is unknown: choose 'left' or 'right'."),
        ("d=99,5,angle=60", "has '5' in it, which is no key=value: write it as"),
        ("runs-level", "'runs-level' names routes: give single corners"),
        ("s-bends:1", "'s-bends:1' names routes: give single corners"),
        ("d=90,angle=wide", "pipe 'd=90,angle=wide': angle 'wide' is no number: write it as"),
        ("d=90,angel=60", "'angel': did you mean 'angle'?"),
        ("d=90,angle=60,turn=up", "turn 'up' is unknown: choose 'left' or 'right'."),
        ("d=900,angle=60", "diameter 900 mm is out of range"),
        ("d=nan,angle=60", "diameter nan mm is out of range"),
        ("d=90,angle=1", "angle 1 deg is out of range"),
    ],
)
def test_what_is_no_pipe_is_named(text: str, message: str) -> None:
    with pytest.raises(PipenavError) as caught:
        parse_corners([text])
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("angles_deg = [60]", "diameters_mm: this key is missing, add it"),
        ("diameters_mm = []\nangles_deg = [60]", "diameters_mm: list should have at least 1 item"),
        ('diameters_mm = ["a"]\nangles_deg = [60]', "diameters_mm.0: input should be a valid number"),
        ("diameters_mm = [90]\nangles_deg = [60]\nturn = 1", "unknown key 'turn': did you mean 'turns'?"),
        ("diameters_mm = {start = 70, stop = 80, step = 10, stp = 1}\nangles_deg = [60]", "did you mean"),
        ("diameters_mm = {start = 70, stop = 85, step = 10}\nangles_deg = [60]", "a whole number of steps of 10"),
        ("diameters_mm = {start = 80, stop = 70, step = 10}\nangles_deg = [60]", "from 80 up to 70 must be"),
        ("diameters_mm = {start = 70, stop = inf, step = 10}\nangles_deg = [60]", "should be a finite number"),
        ("diameters_mm = {start = 70, stop = 80, step = 1e-9}\nangles_deg = [60]", "at most 1000"),
        ("diameters_mm = [400]\nangles_deg = [60]", "diameter 400 mm is out of range"),
        ("diameters_mm = [", "is not valid TOML"),
        ("diameter_mm = [90]\nangles_deg = [60]", "unknown key 'diameter_mm': did you mean 'diameters_mm'?"),
        ("rows = []", "rows: list should have at least 1 item"),
        ("[[rows]]\nangle_deg = 60", "rows.0.diameters_mm: this key is missing, add it"),
        ("[[rows]]\nangle_deg = nan\ndiameters_mm = [60]", "rows.0.angle_deg: input should be a finite number"),
        ("[[rows]]\nangel_deg = 60\ndiameters_mm = [60]", "did you mean 'rows.0.angle_deg'?"),
        ("angles_deg = [60]\n[[rows]]\nangle_deg = 60\ndiameters_mm = [60]", "unknown key 'angles_deg'"),
        ("[[rows]]\nangle_deg = 60\ndiameters_mm = [400]", "diameter 400 mm is out of range"),
        ("s_bend = true", "holds routes: give single corners"),
        ("[[corners]]\nangle_deg = 90", "holds routes: give single corners"),
    ],
)
def test_a_wrong_file_is_explained(tmp_path: Path, body: str, message: str) -> None:
    with pytest.raises(PipenavError) as caught:
        parse_corners([written(tmp_path, body)])
    assert message in str(caught.value)
