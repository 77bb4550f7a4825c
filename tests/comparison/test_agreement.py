"""MuJoCo and PyBullet, which share no code, move, see and touch alike: within the tolerances that users are shown."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from pipenav.backends.plugins import find_backends
from pipenav.backends.requirements import availability
from pipenav.backends.simulators import SimulatorSettings
from pipenav.cli import main
from pipenav.comparison.agreement import Agreement, Check, SimulatorPair, checks, compare
from pipenav.robots.robot import load_robot
from pipenav.robots.variants import robot_names

pytestmark = pytest.mark.slow

ARMS = [name for name in robot_names() if not load_robot(name).free]
BOTH = ("mujoco", "pybullet")


@lru_cache
def agreement_of(robot: str) -> Agreement:
    for name in BOTH:
        can_load, missing, _ = availability(find_backends()[name])
        if not can_load:
            pytest.skip(f"{name}: {missing}")
    return compare(load_robot(robot), *map(SimulatorSettings, BOTH))


@pytest.mark.parametrize("robot", ARMS)
def test_every_difference_is_within_its_tolerance(robot: str) -> None:
    assert [check for check in checks(load_robot(robot), agreement_of(robot)) if not check.holds] == []


@pytest.mark.parametrize("robot", ARMS)
def test_there_is_something_to_compare(robot: str) -> None:
    agreement = agreement_of(robot)
    joints = len(load_robot(robot).joints)
    for comparison in agreement:
        for recorded in comparison:
            assert np.isfinite(recorded).any()
            assert np.nanmax(recorded) > 0
    for moved in (agreement.driven, agreement.stepped):
        own = moved.reference[np.arange(joints), :, np.arange(joints)]  # (joints, steps)
        assert np.all(own.max(axis=1) > 0.01)
        assert not np.array_equal(*moved)
    assert np.all(agreement.force.reference[:, -1] > 1.0)


def spoilt(agreement: Agreement, **shifts: float) -> Agreement:
    """With the other simulator off by so much in the named fields."""
    fields = agreement._asdict()
    for name, shift in shifts.items():
        fields[name] = SimulatorPair(fields[name].reference, fields[name].reference + shift)
    return Agreement(**fields)


@pytest.mark.parametrize(
    ("field", "shift", "lines"),
    [
        ("driven", 0.03, ["free motion under a pulse of duty: hinges", "free motion under a pulse of duty: slide"]),
        ("stepped", 0.002, ["free motion under a step of the set-point: slide"]),
        ("ranges", 0.006, ["laser readings in the same pose"]),
        ("tips", 0.005, ["tip on the same passage: at its end"]),
        ("force", 0.1, ["first touch of a wall", "force at rest on a wall"]),
        ("pressed", -0.003, ["pose at rest on a wall: hinges"]),
    ],
)
def test_a_difference_is_noticed(field: str, shift: float, lines: list[str]) -> None:
    wrong = checks(load_robot("basic"), spoilt(agreement_of("basic"), **{field: shift}))
    assert [check.what for check in wrong if not check.holds] == lines


def command(agreement: Agreement, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Exit code of `pipenav compare-backends` with an agreement that has been measured already."""
    monkeypatch.setattr("pipenav.comparison.agreement.compare", lambda *_: agreement)
    with pytest.raises(SystemExit) as left:
        main(["compare-backends", "--out", str(folder)])
    return int(left.value.code or 0)


def test_the_command_draws_and_tells(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(agreement_of("basic"), tmp_path, monkeypatch) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"free-motion.png", "passages.png", "walls.png"}
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in tmp_path.iterdir())
    assert capsys.readouterr().out.count("holds") == len(checks(load_robot("basic"), agreement_of("basic")))


def test_the_command_fails_where_they_disagree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert command(spoilt(agreement_of("basic"), ranges=0.01), tmp_path, monkeypatch) == 1


def test_a_check_holds_up_to_its_tolerance() -> None:
    assert Check("", 1.0, 1.0, "mm", "").holds
    assert not Check("", 1.01, 1.0, "mm", "").holds
