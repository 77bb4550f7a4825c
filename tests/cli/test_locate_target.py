"""`pipenav locate-target` as typed, and what `pipenav view` makes of its trajectory."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from helpers.command import run
from PIL import Image

from pipenav.evaluation.locate_stage import inside_second_leg
from pipenav.motions.trajectory_file import read_trajectory
from pipenav.motions.trajectory_table import TrajectoryFileError
from pipenav.storage import shipped

FAST = ("--option", "timestep=0.005", "--option", "threads=1")


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "300")
    return tmp_path


def fact(said: str, name: str) -> str:
    """The value in the line of that name."""
    (line,) = re.findall(rf"^ +{name}  +(.+?)(?:  |$)", said, re.MULTILINE)
    return str(line).strip()


def test_one_pipe_is_reported_recorded_and_drawn(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pipe = ("--d", "95", "--angle", "65", "--turn", "right", "--robot", "high-fidelity")
    assert run("locate-target", *pipe, "--out", "found", *FAST) == 0
    said = capsys.readouterr().out
    assert "95 mm, 65 deg, right: high-fidelity, locate:map, mujoco" in said
    trajectory = read_trajectory(here / "found" / "locate-corner-d95-a65-right.csv")
    assert trajectory.header.goal_m is not None
    x, y = trajectory.header.goal_m
    assert (fact(said, "target x"), fact(said, "target y")) == (f"{1000 * x:.1f}", f"{1000 * y:.1f}")
    assert inside_second_leg(trajectory.header.pipe, np.array([x, y]))
    assert fact(said, "well placed") == "yes"
    assert re.fullmatch(r"\d+ of 10", fact(said, "beam"))
    assert 0 < int(fact(said, "found at step")) < len(trajectory.q)
    assert fact(said, "peak force") == "0.0"
    assert fact(said, "outcome") == trajectory.header.outcome == "reached"
    assert (trajectory.header.stage, trajectory.header.controller) == ("locate", "locate:map")
    assert Image.open(here / "found" / "locate-corner-d95-a65-right.png").size[0] > 1000
    assert run("view", "--trajectory", "found/locate-corner-d95-a65-right.csv", "--out", "seen.png") == 0
    assert Image.open("seen.png").size[0] > 1000


def test_a_pipe_without_a_target_ends_with_1(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("locate-target", "--d", "100", "--angle", "180", "--out", "found", *FAST) == 1
    said = capsys.readouterr().out
    assert fact(said, "target x") == fact(said, "beam") == fact(said, "well placed") == "-"
    assert fact(said, "outcome") != "reached"
    assert read_trajectory(here / "found" / "locate-corner-d100-a180-left.csv").header.goal_m is None
    assert (here / "found" / "locate-corner-d100-a180-left.png").is_file()


def test_several_pipes_have_a_row_each(capsys: pytest.CaptureFixture[str]) -> None:
    sets = ("--pipes", "d=90,angle=60", "--pipes", "d=120,angle=120,turn=right")
    assert run("locate-target", *sets, "--out", "found", *FAST) == 0
    said = capsys.readouterr().out
    assert re.search(r"90 mm, 60 deg, left +-[\d.]+ +[\d.]+ +\d+ of 10 +\d+ +yes +0\.0 +reached", said)
    assert re.search(r"120 mm, 120 deg, right +[\d.]+ +-[\d.]+ +\d+ of 10 +\d+ +yes +0\.0 +reached", said)
    assert "found well placed: 2 of 2 pipes" in said
    assert len(list(Path("found").iterdir())) == 4


def test_the_printed_method_fails_where_the_default_does_not(capsys: pytest.CaptureFixture[str]) -> None:
    sets = ("--pipes", "d=120,angle=120", "--pipes", "d=80,angle=120")
    assert run("locate-target", *sets, "--variant", "thesis", *FAST) == 1
    said = capsys.readouterr().out
    assert re.search(r"120 mm, 120 deg, left .* yes .* reached", said)
    assert re.search(r"80 mm, 120 deg, left +- +- +- +- +- .* timeout", said)
    assert "1 of 2 pipes" in said


def test_the_same_seed_is_the_same_search(here: Path) -> None:
    for folder, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        assert run("locate-target", "--d", "90", "--angle", "60", "--seed", seed, "--out", folder, *FAST) == 0
    one, again, other = ((here / f / "locate-corner-d90-a60-left.csv").read_bytes() for f in "abc")
    assert one == again != other


def test_view_records_the_same_search(here: Path) -> None:
    assert run("locate-target", "--d", "90", "--angle", "60", "--out", "found", *FAST) == 0
    assert run("view", "--behaviour", "locate:map", "--out", "seen.csv", "--out", "seen.png", *FAST) == 0
    assert Path("seen.csv").read_bytes() == (here / "found" / "locate-corner-d90-a60-left.csv").read_bytes()


def test_a_misplaced_target_may_lie_anywhere_and_another_may_not(here: Path) -> None:
    assert run("locate-target", "--d", "90", "--angle", "60", "--out", "found", *FAST) == 0
    path = here / "found" / "locate-corner-d90-a60-left.csv"
    outside = re.sub(r'"goal_m": \[[^]]*\]', '"goal_m": [0.4, 0.4]', path.read_text())
    path.write_text(outside)
    with pytest.raises(TrajectoryFileError, match=r"the target goal_m \(0.4, 0.4\) lies outside the pipe"):
        read_trajectory(path)
    path.write_text(outside.replace('"outcome": "reached"', '"outcome": "misplaced"'))
    assert read_trajectory(path).header.goal_m == (0.4, 0.4)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        ((), "give --d and --angle, for example --d 90 --angle 60, or --pipes"),
        (("--d", "90"), "give --d and --angle, for example --d 90 --angle 60, or --pipes"),
        (("--angle", "60"), "give --d and --angle, for example --d 90 --angle 60, or --pipes"),
        (("--d", "90", "--angle", "60", "--pipes", "thesis"), "one pipe or a set, not both"),
        (("--turn", "right", "--pipes", "thesis"), "one pipe or a set, not both"),
        (("--d", "90", "--angle", "60", "--turn", "up"), "turn 'up' is unknown"),
        (("--d", "9", "--angle", "60"), "diameter 9 mm"),
        (("--pipes", "theses"), "unknown pipe set 'theses': did you mean 'thesis'"),
        (("--d", "90", "--angle", "60", "--robot", "basics"), "unknown robot 'basics'"),
        (("--d", "90", "--angle", "60", "--backend", "mujocco"), "unknown backend 'mujocco'"),
        (("--d", "90", "--angle", "60", "--option", "timestep=0.003"), "does not divide the control period"),
    ],
)
def test_what_cannot_be_searched(args: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("locate-target", *args, "--out", "found") == 1
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1
    assert not list(Path().glob("found/*"))


def test_a_pipe_too_narrow_for_the_robot_is_refused(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (shipped.robots_dir() / "real-setup" / "robot.toml").read_text(encoding="utf-8")
    (here / "wide.toml").write_text(text.replace("width = 0.036", "width = 0.042"), encoding="utf-8")
    assert run("locate-target", "--d", "45", "--angle", "90", "--robot", "wide.toml") == 1
    assert "is too narrow for robot 'real-setup', which is 42 mm wide and needs 46 mm" in capsys.readouterr().err
