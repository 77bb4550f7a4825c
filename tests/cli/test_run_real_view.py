"""The terminal of a mission: what it shows, and the keys that it listens to."""

from __future__ import annotations

import io
import os
import sys
import termios
from collections.abc import Iterator
from typing import Any

import pytest
from rich.console import Console

from pipenav.backends.safety import Stopped
from pipenav.cli.run_real_view import MissionView
from pipenav.robots.robot import load_robot

ROBOT = load_robot("real-setup")


@pytest.fixture
def keyboard(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A descriptor to which typed keys are written."""
    master, slave = os.openpty()
    with os.fdopen(slave, "r") as typed:
        monkeypatch.setattr(sys, "stdin", typed)
        yield master
    os.close(master)


def view() -> MissionView:
    return MissionView(Console(file=io.StringIO(), force_terminal=True, width=120), ROBOT)


def shown(view: MissionView) -> str:
    file = view._console.file
    assert isinstance(file, io.StringIO)
    return file.getvalue()


def tick(number: int, **more: Any) -> dict[str, Any]:
    joints = len(ROBOT.joints)
    record = {"tick": number, "stage": "reach", "q": [0.1] * joints, "sent": [0.2] * joints, "clamped": ["theta1"]}
    record |= {"ranges": [0.3] * ROBOT.laser.beams, "target": [0.4, 0.1], "raw": {"late": 2}}
    return {**record, "seconds": {"bus": 0.006, "decide": 0.001, "taken": 0.008}, "warnings": ["weak supply"], **more}


@pytest.mark.usefixtures("keyboard")
def test_a_tick_shows_joints_ranges_target_timing_and_warnings() -> None:
    with view() as made:
        made(tick(0))
    for words in (
        "100.0 mm",
        "11.5 deg",
        "limited",
        "least 300 mm",
        "400, 100 mm",
        "taken 8.0",
        "late 2",
        "weak supply",
    ):
        assert words in shown(made)


@pytest.mark.usefixtures("keyboard")
def test_a_tick_that_held_is_no_stage_and_no_picture() -> None:
    with view() as made:
        made({"tick": 0, "stage": "hold", "raw": {"late": 0}})
    assert "hold" not in shown(made)


def test_space_is_the_emergency_stop_and_other_keys_are_not(keyboard: int) -> None:
    before = termios.tcgetattr(keyboard)
    with view() as made:
        os.write(keyboard, b"x")
        made(tick(0))
        os.write(keyboard, b"x x")
        with pytest.raises(Stopped, match="the space bar was pressed") as stopped:
            made(tick(1))
    assert stopped.value.cause == "e-stop"
    assert termios.tcgetattr(keyboard) == before, "the terminal is as it was"


def test_a_held_arm_is_released_by_any_key_which_is_asked_for_once(keyboard: int) -> None:
    with view() as made:
        assert not made.released()
        assert not made.released()
        os.write(keyboard, b"x")
        assert made.released()
    assert shown(made).count("hold the arm, then press any key") == 1
