"""`pipenav view` and `pipenav mirror-rear` as typed."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from helpers.command import run
from PIL import Image

from pipenav.motions.trajectory_file import read_trajectory

FAST = ("--option", "timestep=0.005", "--option", "threads=1")


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "300")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    return tmp_path


@pytest.fixture
def front(here: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    assert run("view", "--policy", "arm", "--pipes", "d=95,angle=65,turn=right", "--out", "front.csv", *FAST) == 0
    assert re.search(
        r"95 mm, 65 deg, right, reach: reached after 1\.\d s, largest contact force", capsys.readouterr().out
    )
    return here / "front.csv"


def test_a_picture_where_none_was_asked_for(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("view", "--policy", "baseline:centreline", *FAST) == 0
    picture = "view-baseline-centreline-corner-d90-a60-left-timestep0.005-threads1.png"
    assert f"written: {picture}" in capsys.readouterr().out
    assert Image.open(here / picture).size[0] > 1000


def test_a_recording_can_be_drawn_and_mirrored(front: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = [
        "mirror-rear",
        "--trajectory",
        "front.csv",
        "--out",
        "rear.csv",
        "--replay",
        "--record",
        "done.csv",
        *FAST,
    ]
    assert run(*command) == 0
    said = capsys.readouterr().out
    assert re.search(r"hand-over jump: the robot's middle \d+ mm \(\d+ mm along the pipe\) and 115 deg; largest", said)
    assert "replay on mujoco: the arm came out of the corner after" in said
    assert re.search(r"error [\d.]+ mm at the tip, [\d.]+ deg of a hinge, .* contact force [\d.]+ N", said)
    plan, done = read_trajectory(Path("rear.csv")), read_trajectory(Path("done.csv"))
    assert np.array_equal(plan.q, (read_trajectory(front).q * [1, -1, -1, -1])[::-1])
    assert done.succeeded
    assert done.contact_force is not None
    files = [f"--trajectory={name}" for name in ("front.csv", "rear.csv", "done.csv")]
    assert run("view", *files, "--out", "all.png") == 0
    assert "95 mm, 65 deg, left, rear: not run after" in capsys.readouterr().out
    assert Path("all.png").is_file()


def test_the_same_seed_and_episode_are_the_same_recording(front: Path) -> None:
    again = ("view", "--policy", "arm", "--pipes", "d=95,angle=65,turn=right", *FAST)
    assert run(*again, "--out", "again.csv") == 0
    assert Path("again.csv").read_bytes() == front.read_bytes()
    assert run(*again, "--episode", "1", "--out", "other.csv") == 0
    assert Path("other.csv").read_bytes() != front.read_bytes()


@pytest.mark.parametrize(
    ("args", "message"),
    [
        ((), "give one of --policy, --behaviour, --trajectory, --eval and --telemetry"),
        (
            ("--policy", "arm", "--trajectory", "front.csv"),
            "give one of --policy, --behaviour, --trajectory, --eval and --telemetry",
        ),
        (
            ("--policy", "arm", "--behaviour", "locate:map"),
            "give one of --policy, --behaviour, --trajectory, --eval and --telemetry",
        ),
        (("--trajectory", "none.csv"), "cannot read none.csv: No such file"),
        (("--policy", "arm", "--out", "film.avi"), r"film.avi: its suffix must be one of"),
        (("--policy", "arm", "--out", "nowhere/film.gif"), "there is no folder nowhere for film.gif"),
        (("--policy", "arm", "--pipes", "working-range"), "180 pipes are too many to look at"),
        (("--policy", "arm", "--pipes", "d=90,angle=60", "--pipes", "d=90,angle=70", "--out", "a.csv"), "one motion"),
        (("--policy", "arm", "--live"), "MuJoCo's viewer needs a display"),
        (("--policy", "arm", "--option", "timestep=0.003"), "does not divide the control period"),
        (("--policy", "amr"), "unknown policy 'amr': did you mean 'arm'"),
        (("--trajectory", "front.csv", "--pipes", "d=90,angle=60"), "brings its own pipe"),
        (("--trajectory", "front.csv", "--seed", "1", "--episode", "0"), "--seed and --episode would be ignored here"),
        (("--trajectory", "front.csv", "--backend", "mujoco"), "--backend would be ignored here"),
        (("--trajectory", "front.png", "--out", "front.png"), "front.png is read and would be written over"),
        (("--policy", "arm", "--robot", "pirate"), "policy arm was made for robot 'basic' and brings it"),
        (
            ("--policy", "arm", *(f"--pipes=d=90,angle={angle}" for angle in range(60, 73))),
            "13 pipes are too many for one strip: name at most 12",
        ),
        (("--policy", "arm", "--out", "a.png", "--out", "./a.png"), "a.png is named for two results"),
        (("--trajectory", "front.csv", "--out", "copy.csv"), "--trajectory only draws one"),
        (("--trajectory", "front.csv", "--live", "--out", "a.png"), "writes nothing"),
    ],
)
def test_what_cannot_be_drawn(args: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("view", *args) == 1
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1
    assert not list(Path().iterdir())


@pytest.mark.parametrize(
    "output", [("--out", "front.csv"), ("--out", "link.csv"), ("--replay", "--record", "front.csv")]
)
def test_no_input_is_written_over(output: tuple[str, ...], front: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("link.csv").symlink_to("front.csv")
    before = front.read_bytes()
    assert run("mirror-rear", "--trajectory", "front.csv", *output) == 1
    assert "is read and would be written over: give the result another name." in capsys.readouterr().err
    assert front.read_bytes() == before
    assert not Path("rear.csv").exists()


def test_two_results_have_two_names(front: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("mirror-rear", "--trajectory", "front.csv", "--replay", "--record", "./rear.csv") == 1
    assert "rear.csv is named for two results: give each a name of its own." in capsys.readouterr().err
    assert front.exists()


def test_what_cannot_be_mirrored(front: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = front.read_text()
    front.write_text(text.replace('"outcome": "reached"', '"outcome": "timeout"'))
    assert run("mirror-rear", "--trajectory", "front.csv") == 1
    assert "did not succeed (outcome: timeout): only a successful front passage" in capsys.readouterr().err
    lines = text.splitlines(keepends=True)
    front.write_text("".join(lines[:6] + lines[7:]))
    assert run("mirror-rear", "--trajectory", "front.csv") == 1
    assert "line 7, t_s: 0.5 instead of 0.4" in capsys.readouterr().err
    assert run("mirror-rear", "--trajectory", "front.csv", "--record", "done.csv") == 1
    assert "--record writes what --replay runs: give both." in capsys.readouterr().err
    assert run("mirror-rear", "--trajectory", "front.csv", "--replay", "--backend", "hardware") == 1
    assert "it is not a simulator; choose one that is" in capsys.readouterr().err
    assert not Path("rear.csv").exists(), "it was written before the replay was refused"
    assert run("mirror-rear", "--trajectory", "front.csv", "--option", "timestep=0.001") == 1
    assert "--option would be ignored here: only --replay runs a simulator; leave it out." in capsys.readouterr().err
    assert not Path("rear.csv").exists()


@pytest.mark.slow
def test_pictures_that_nobody_named_do_not_replace_each_other(front: Path) -> None:
    pipe = ("--pipes", "d=100,angle=90", *FAST)
    for source in (["--policy", "arm"], ["--policy", "baseline:centreline"], ["--policy", "arm", "--episode", "2"]):
        assert run("view", *source, *pipe) == 0
    assert run("view", "--policy", "arm", *pipe, "--seed", "1") == 0
    assert run("view", "--trajectory", str(front)) == 0
    assert len(list(Path().glob("view-*.png"))) == 5


@pytest.mark.slow
def test_motions_and_missions_are_written_for_other_viewers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rerun")
    pytest.importorskip("mcap")
    monkeypatch.chdir(tmp_path)
    log = Path(__file__).parents[1] / "data" / "0.1" / "mission" / "telemetry.jsonl"
    assert run("view", "--policy", "arm", "--pipes", "d=100,angle=90", "--rerun", "arm.rrd") == 0
    assert run("view", "--telemetry", str(log), "--rerun", "mission.rrd", "--mcap", "mission.mcap") == 0
    assert {path.name for path in tmp_path.iterdir()} == {"arm.rrd", "mission.rrd", "mission.mcap"}
    assert (tmp_path / "arm.rrd").read_bytes()[:3] == b"RRF"
    assert (tmp_path / "mission.mcap").read_bytes()[1:5] == b"MCAP"
    said = capsys.readouterr().out
    assert "written: arm.rrd" in said and "written: mission.mcap" in said
