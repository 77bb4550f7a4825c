"""Routes in several planes, as commands take and refuse them."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command import run

from pipenav.evaluation.results import read_evaluation

SEVERAL_PLANES = """schema = 1
diameter_mm = 90
first_straight_mm = 900

[[corners]]
angle_deg = 120
turn = "left"
straight_mm = 900

[[corners]]
angle_deg = 120
turn = "left"
roll_deg = 90
straight_mm = 900
"""


def several_planes(folder: Path) -> str:
    (folder / "several.toml").write_text(SEVERAL_PLANES, encoding="utf-8")
    return str(folder / "several.toml")


@pytest.mark.slow
def test_routes_in_several_planes_are_counted_beside_those_in_one(tmp_path: Path) -> None:
    """Random actions pass nowhere."""
    args = ("--pipes", several_planes(tmp_path), "--pipes", "d=90,angle=90", "--episodes", "1", "--robot", "pirate")
    assert run("eval", "--policy", "baseline:random", *args, "--out", str(tmp_path / "found")) == 0
    rolled, corner = read_evaluation(tmp_path / "found").pipes
    assert (rolled.route, corner.route) == ("run-d90-L120-L120roll90", None)
    for record in (rolled, corner):
        assert record.traverse_attempts == sum(record.failures.values()) == 1


@pytest.mark.slow
def test_a_picture_of_a_route_in_several_planes(tmp_path: Path) -> None:
    picture = tmp_path / "strip.png"
    args = ("view", "--policy", "baseline:random", "--robot", "pirate", "--pipes", several_planes(tmp_path))
    assert run(*args, "--out", str(picture)) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (
            ("eval", "--backend", "pybullet"),
            "backend 'pybullet' moves robots only in a plane: choose --backend mujoco",
        ),
        (("eval", "--disturb", "real-world"), "--disturb disturbs robots in a plane"),
        (("view", "--out", "way.csv"), "its suffix must be one of: .png, .gif, .mp4"),
        (("view", "--pipes", "d=90,angle=90"), "a picture in space shows one route"),
    ],
)
def test_what_cannot_be_done_in_several_planes_is_said(
    args: tuple[str, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name, *rest = args
    common = ("--policy", "baseline:random", "--robot", "pirate", "--pipes", several_planes(tmp_path))
    assert run(name, *common, *rest) == 1
    assert said in " ".join(capsys.readouterr().err.split())


def test_the_sequence_turns_corners_in_one_plane_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    args = ("--pipes", several_planes(tmp_path), "--episodes", "1", "--out", str(tmp_path / "found"))
    assert run("eval", "--policy", "baseline:sequence", *args) == 1
    assert "turns corners in one plane" in " ".join(capsys.readouterr().err.split())
