"""`hw-check` and `calibrate` as typed, on an emulated arm in real time."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.command import run
from helpers.emulated import few_ids
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings

from pipenav.robots.robot import load_robot

pytestmark = pytest.mark.realtime


@pytest.fixture(autouse=True)
def plain_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setenv("TERM", "dumb")


@pytest.fixture
def emulator() -> Iterator[Emulator]:
    with Emulator(load_robot("basic"), EmulatorSettings(front_sensor=False)) as started:
        yield started


def test_hw_check_as_typed(
    emulator: Emulator, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    few_ids(monkeypatch)
    assert run("hw-check", "--arm", str(emulator.arm_path)) == 0
    assert capsys.readouterr().out.count("ok  ") >= 6
    emulator.order(fault="dead", servo=4)
    assert run("hw-check", "--arm", str(emulator.arm_path)) == 1
    shown = capsys.readouterr()
    assert "servo 4 (theta3) does not answer" in shown.out
    assert "the arm has 1 problem" in shown.err


def test_a_servo_that_would_not_shut_down_is_refused_by_every_command(
    emulator: Emulator, capsys: pytest.CaptureFixture[str]
) -> None:
    emulator.order(fault="shutdown", servo=2, value=0)
    for command in (("hw-check",), ("run-real", "--policy", "arm", "--yes")):
        assert run(*command, "--arm", str(emulator.arm_path)) == 1
        assert "does not switch itself off on overload and overheating" in capsys.readouterr().out
    assert byte_log.only_asked(emulator.log_path)
    assert run("calibrate", "--store-only", "--arm", str(emulator.arm_path)) == 0
    assert run("hw-check", "--arm", str(emulator.arm_path)) == 0


def test_answers_are_kept_although_the_servos_cannot_be_given_their_settings(
    emulator: Emulator, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Answers(io.StringIO):
        """Answers of a person; with the last one the servos lose and gain something."""

        def readline(self, *size: int) -> str:  # type: ignore[override]
            line = super().readline(*size)
            if self.tell() == len(self.getvalue()):
                emulator.order(fault="lock")
            return line

    emulator.order(place=[512, 512, 512, 512])
    monkeypatch.setattr(sys, "stdin", Answers("\n".join(["", "", "y", "15", "", "n", "", "y", "", "y"]) + "\n"))
    ports = ("--port", emulator.arm.port, "--scanner-port", emulator.arm.scanner.port, "--robot", "basic")
    arm = tmp_path / "arm.toml"
    assert run("calibrate", *ports, "--arm", str(arm), "--write-servos") == 1
    said = capsys.readouterr().err
    assert "its EEPROM is locked" in said and f"store them by pipenav calibrate --store-only --arm {arm}" in said
    assert arm.read_text().count("sign = -1") == 1


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (
            ("--store-only", "--port", "/dev/ttyUSB0"),
            "--port would be ignored here: --store-only stores what",
        ),
        (("--port", "/dev/tty\udcff"), "port: input should be a valid string"),
        (("--port", "/dev/" + "x" * 2000), "port: string should have at most 1000 characters"),
    ],
)
def test_what_cannot_be_calibrated(args: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("calibrate", *args) == 1
    assert words in capsys.readouterr().err


def test_calibrate_without_a_port_is_wrong_usage() -> None:
    assert run("calibrate") == 2


def test_calibrate_as_typed(
    emulator: Emulator, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    emulator.order(place=[512, 512, 512, 512])
    answers = ["", "", "y", "15", "", "n", "", "y", "", "y"]
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n".join(answers) + "\n"))
    ports = ("--port", emulator.arm.port, "--scanner-port", emulator.arm.scanner.port, "--robot", "basic")
    (tmp_path / "arm.toml").write_text("another arm's")
    assert run("calibrate", *ports, "--arm", str(tmp_path / "arm.toml"), "--write-servos") == 0
    written = (tmp_path / "arm.toml").read_text()
    assert (tmp_path / "arm-1.toml").read_text() == "another arm's"
    assert written.count("sign = -1") == 1
    assert "servo 1 (l): limits" in capsys.readouterr().out
    emulator.order(place=[512, 512, 512, 512])
    assert run("hw-check", "--arm", str(tmp_path / "arm.toml")) == 0
