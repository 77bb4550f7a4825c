"""`pipenav drive` and `pipenav compare` as typed."""

from __future__ import annotations

import os
import pty
import select
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest
from helpers.command import run
from helpers.terminal import environment

from pipenav.deployment.telemetry import read_telemetry
from pipenav.driving.records import read_records


def test_a_policy_alone_and_a_script_are_put_beside_each_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    common = ("--pipes", "d=100,angle=90", "--robot", "basic")
    by_policy = ("--policy", "arm", "--operator", "none")
    assert run("drive", *common, *by_policy, "--out", str(tmp_path / "alone")) == 0
    assert run("drive", *common, "--operator", "scripted", "--out", str(tmp_path / "script")) == 0
    assert "scripted operator: 1 of 1 episodes passed" in capsys.readouterr().out
    assert run("compare", str(tmp_path / "alone"), str(tmp_path / "script")) == 0
    said = capsys.readouterr().out
    assert "arm " in said
    assert "scripted operator" in said
    assert "1 episodes that all of them drove" in said
    for name, who in (("alone", "policy"), ("script", "person")):
        ticks = read_telemetry(tmp_path / name / "episode-0000.jsonl").ticks
        assert {tick["stage"] for tick in ticks} == {who}


SCRIPTED = ("--operator", "scripted")
REFUSED = {
    "nobody": (("--operator", "none"), "nobody drives"),
    "no terminal": ((), "stdin is none"),
    "no device": (("--input", "midi", "--device", "/no/such"), "cannot be opened"),
    "a script's device": (("--operator", "scripted", "--device", "3"), "are a person's"),
    "space in a simulator of the plane": (
        (*SCRIPTED, "--backend", "pybullet", "--pipes", "runs-rolled:1"),
        "only in a plane",
    ),
    "disturbed in space": ((*SCRIPTED, "--disturb", "rough", "--pipes", "runs-rolled:1"), "disturbs robots in a plane"),
    "steps through a tee": ((*SCRIPTED, "--pipes", "d=100,tee=90"), "other fittings than corners"),
    "no room to roll": ((*SCRIPTED, "--pipes", "space-s-bends:1"), "steps take at least"),
    "no mapping": (("--mapping", "none.toml"), "none.toml"),
    "a script on the real arm": (("--operator", "scripted", "--arm", "arm.toml"), "never drives the real arm"),
    "two arms": (("--emulate", "--arm", "arm.toml"), "leave out --arm"),
    "a policy alone on the arm": (("--emulate", "--policy", "arm", "--operator", "none"), "pipenav run-real"),
    "a policy that is not told the way": (("--arm", "arm.toml", "--policy", "arm"), "which way the pipe turns"),
    "a whole robot's policy on the arm": (("--emulate", "--policy", "pirate"), "approach I"),
    "delayed stops": (("--arm", "arm.toml", "--patience", "2"), "delay the stops"),
}


@pytest.mark.parametrize(("words", "said"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_driven_is_refused_and_nothing_is_made(
    words: tuple[str, ...],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    read, write = os.pipe()
    with os.fdopen(read) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        assert run("drive", *words) == 1
    os.close(write)
    error = capsys.readouterr().err
    assert said in error
    assert len(error.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_window_without_a_display_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    script = ("--robot", "basic", "--operator", "scripted", "--window", "--no-record")
    assert run("drive", *script, "--out", str(tmp_path / "driven")) == 1
    assert "display" in capsys.readouterr().err


def test_one_folder_alone_is_not_compared(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("compare", "one") == 1
    assert "name two or more" in capsys.readouterr().err


@pytest.mark.realtime
@pytest.mark.slow
def test_keys_on_a_terminal_drive_the_robot_and_the_terminal_is_as_before(tmp_path: Path) -> None:
    folder = tmp_path / "driven"
    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)
    command = [sys.executable, "-m", "pipenav", "drive", "--pipes", "d=100,angle=90", "--out", str(folder)]
    with subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, env=environment()) as process:
        log, seen, pressed = folder / "episode-0000.jsonl", b"", b""
        give_up = time.monotonic() + 60
        while process.poll() is None and time.monotonic() < give_up:
            if select.select([ours], [], [], 0.1)[0]:
                seen += os.read(ours, 65536)
            lines = log.read_text().count("\n") if log.exists() else 0
            if lines > 3 and not pressed:
                pressed = b"a"
                os.write(ours, pressed)
            if lines > 12 and pressed == b"a":
                pressed = b"x"
                os.write(ours, pressed)
        assert process.wait(10) == 0
    assert termios.tcgetattr(theirs) == before
    assert "step (a) unclamp the front" in seen.decode(errors="replace")
    ticks = read_telemetry(log).ticks
    assert any(tick["asked"].get("step") == "a" for tick in ticks)
    assert ticks[-1]["step"] in ("", "a")
    os.close(ours)
    os.close(theirs)


def test_every_pipe_and_episode_is_in_the_records(tmp_path: Path) -> None:
    pipes = ("--pipes", "d=100,angle=90", "--pipes", "d=110,angle=80,turn=right")
    scripted = ("--robot", "basic", "--operator", "scripted", "--no-record")
    assert run("drive", *pipes, *scripted, "--episodes", "2", "--out", str(tmp_path / "out")) == 0
    records = read_records(tmp_path / "out")
    numbered = [(episode.pipe, episode.number) for episode in records.episodes]
    assert numbered == [(pipe, number) for pipe in pipes[1::2] for number in (0, 1)]
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["drive.json"]
