"""`pipenav certify` as typed: verdicts, certificates that hold, and certificates that do not."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pipenav.certify.model import Model
from pipenav.certify.motion_check import check_by_distance, check_by_shapely
from pipenav.motions.mirror import plan_rear
from pipenav.motions.trajectory_file import read_trajectory
from pipenav.storage.shipped import robots_dir
from tests.helpers.command import run


def certify(folder: Path, robot: str, pipe: str, *more: str) -> list[Path]:
    assert run("certify", "--robot", robot, "--pipes", pipe, "--out", str(folder), *more) == 0
    return sorted(folder.glob("*.json"))


@pytest.mark.parametrize(
    ("robot", "pipe"),
    [("basic", "d=75,angle=60,turn=right"), ("pirate", "d=66,angle=60"), ("pirate", "d=60,angle=90,bend_radius=1.5D")],
)
def test_a_passable_pipe_has_a_motion_that_both_tests_find_free(tmp_path: Path, robot: str, pipe: str) -> None:
    (path,) = certify(tmp_path, robot, pipe)
    assert json.loads(path.read_text())["verdict"] == "passable"
    assert run("certify", "--check", str(path)) == 0
    motion = read_trajectory(path.with_suffix(".csv"))
    model = Model(motion.robot, motion.header.pipe.require_corner())
    for check in (check_by_distance, check_by_shapely):
        assert check(model, motion.q, motion.header.base_m).free
    speeds = np.abs(np.diff(motion.q, axis=0))[:, -len(motion.robot.joints) :] / 0.1
    assert (speeds <= motion.robot.speed_limits).all()
    if not motion.robot.free:
        assert len(plan_rear([motion]).q) == len(motion.q)


def test_both_tests_refuse_the_motion_in_a_narrower_pipe(tmp_path: Path) -> None:
    (path,) = certify(tmp_path, "pirate", "d=66,angle=60")
    motion = read_trajectory(path.with_suffix(".csv"))
    pipe = motion.header.pipe.require_corner()
    narrower = Model(motion.robot, pipe.model_copy(update={"diameter": pipe.diameter - 0.003}))
    q = motion.q + np.array([-0.001, 0.0, 0.0, *[0.0] * 6])
    for check in (check_by_distance, check_by_shapely):
        assert not check(narrower, q, motion.header.base_m).free


def test_an_edited_certificate_does_not_hold(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (path,) = certify(tmp_path, "pirate", "d=60,angle=60")
    assert run("certify", "--check", str(path)) == 0
    path.write_text(path.read_text().replace('"impossible"', '"passable"'))
    capfd.readouterr()
    assert run("certify", "--check", str(path)) == 1
    assert "was edited" in capfd.readouterr().err


def test_a_certificate_of_another_robot_does_not_hold(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (path,) = certify(tmp_path, "pirate", "d=60,angle=60")
    capfd.readouterr()
    assert run("certify", "--check", str(path), "--robot", "basic") == 1
    assert "not of this robot 'basic'" in capfd.readouterr().err


def test_an_edited_motion_does_not_hold(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (path,) = certify(tmp_path, "basic", "d=90,angle=90")
    motion = path.with_suffix(".csv")
    lines = motion.read_text().splitlines()
    motion.write_text("\n".join([*lines[:-1], lines[-1].replace("1", "2")]) + "\n")
    capfd.readouterr()
    assert run("certify", "--check", str(path)) == 1
    assert capfd.readouterr().err.count("\n") == 1


def test_high_parts_cannot_pass_a_round_bore_that_boards_let_them_pass(tmp_path: Path) -> None:
    """`real-setup` in 70 mm, 60 deg: between boards it passes, in a round tube its servos have too little width."""
    for bore, verdict in (("plane", "passable"), ("round", "impossible")):
        (path,) = certify(tmp_path / bore, "real-setup", "d=70,angle=60", "--bore", bore)
        assert json.loads(path.read_text())["verdict"] == verdict


def test_episodes_have_certificates_of_their_own(tmp_path: Path) -> None:
    paths = certify(tmp_path, "basic", "d=80,angle=90", "--episodes", "2")
    ends = [json.loads(path.read_text())["ends"]["along"] for path in paths]
    assert len(ends) == 2
    assert ends[0] != ends[1]
    assert all(first == last for first, last in ends)


def test_a_tee_is_undecided_and_says_why(tmp_path: Path) -> None:
    (path,) = certify(tmp_path, "basic", "d=100,tee=90,way=into")
    assert json.loads(path.read_text())["verdict"] == "undecided"
    assert "tee" in json.loads(path.read_text())["reason"]


def test_a_route_is_undecided_and_says_why(capfd: pytest.CaptureFixture[str]) -> None:
    assert run("certify", "--robot", "pirate", "--pipes", "runs-level:1", "--pipes", "d=60,angle=60") == 0
    told = " ".join(capfd.readouterr().out.split())
    assert "undecided" in told
    assert "several corners" in told
    assert "impossible" in told


def test_a_robot_that_does_not_fit_at_rest_is_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    wide = tmp_path / "wide.toml"
    wide.write_text((robots_dir() / "basic" / "robot.toml").read_text().replace("width = 0.020", "width = 0.050"))
    assert run("certify", "--robot", str(wide), "--pipes", "d=50,angle=60") == 1
    assert "needs 54 mm at rest" in capfd.readouterr().err
    assert run("certify", "--robot", "pirate", "--pipes", "d=40,angle=60,bend_radius=1.5D", "--check", "none.json") == 1
    assert run("certify", "--robot", "basic", "--pipes", "d=40,angle=60", "--check", "none.json") == 1
    assert run("certify") == 1
    assert capfd.readouterr().err.count("\n") == 3
