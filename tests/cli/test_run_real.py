"""`run-real` and `replay` as typed, on an emulated arm in real time."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.command import run
from helpers.waiting import wait_until
from pipenav_hardware.emulator import byte_log

from pipenav.deployment import arm_policy
from pipenav.deployment.arm_policy import policy_for
from pipenav.deployment.summary import located_placement, write_motions
from pipenav.deployment.telemetry import Recording, Telemetry, read_telemetry
from pipenav.deployment.trajectories import ArmPlacement, placement_of
from pipenav.errors import PipenavError
from pipenav.motions.trajectory_file import read_trajectory
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.policy import load_policy, resolve_policy
from pipenav.storage import shipped

pytestmark = pytest.mark.realtime

GOALS = "fffffe18831e04"
"""First bytes of a packet of four goals."""

EMULATED = ("run-real", "--emulate", "--robot", "basic", "--d", "130", "--patience", "8", "--allow-slow-bus")


@pytest.fixture(autouse=True)
def plain_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setenv("TERM", "dumb")


@pytest.fixture(scope="module")
def passage(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of one mission with the thesis's scanner faults."""
    folder = tmp_path_factory.mktemp("runs") / "real-1"
    command = [sys.executable, "-m", "pipenav", *EMULATED, "--angle", "90", "--turn", "right", "--faults", "thesis"]
    ended = subprocess.run([*command, "--out", str(folder)], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "passed: " in ended.stdout
    return folder


@pytest.fixture
def recording(passage: Path) -> Recording:
    return read_telemetry(passage / "telemetry.jsonl")


def test_an_emulated_mission_goes_around_the_corner_and_back(passage: Path, recording: Recording) -> None:
    assert recording.end is not None and recording.end["end"] == "passed"
    stages = [tick["stage"] for tick in recording.ticks if tick["stage"] != "hold"]
    assert list(dict.fromkeys(stages)) == ["locate", "reach", "back", "passed"]
    assert not any(on for on, _ in byte_log.torque(passage / "bus.jsonl", (1, 2, 3, 4)).values())
    assert {path.name for path in passage.iterdir()} == {
        *("telemetry.jsonl", "policy.zip", "run.png", "report.html", "bus.jsonl", "locate.csv", "front.csv")
    }
    assert (passage / "run.png").read_bytes().startswith(b"\x89PNG")


def test_what_the_telemetry_says_was_sent_is_what_arrived(passage: Path, recording: Recording) -> None:
    sent = [tick["packet"] for tick in recording.ticks if tick.get("packet")]
    arrived = [heard.packet.encode().hex() for heard in byte_log.instructions(passage / "bus.jsonl")]
    assert [packet for packet in arrived if packet.startswith(GOALS)] == sent
    assert len(sent) > 15


def test_a_tick_tells_everything(recording: Recording) -> None:
    tick = next(tick for tick in recording.ticks if tick["stage"] == "reach")
    assert {*("q", "qd", "ranges", "observation", "action", "command", "sent", "clamped", "packet")} <= tick.keys()
    assert {*("states", "alarms", "scan_mm", "front_m", "late", "seconds")} <= tick["raw"].keys()
    assert {"bus", "read", "decide", "send", "taken"} <= tick["seconds"].keys()


def test_a_replay_is_the_same_bit_for_bit(
    passage: Path, recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("replay", str(passage / "telemetry.jsonl"), "--draw", str(tmp_path / "again.png")) == 0
    assert f"{len(recording.ticks)} ticks" in capsys.readouterr().out
    assert (tmp_path / "again.png").stat().st_size > 10_000


@pytest.mark.parametrize("key", ["action", "sent", "packet", "q", "observation"])
def test_a_replay_finds_the_first_difference(
    passage: Path, tmp_path: Path, key: str, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = (passage / "telemetry.jsonl").read_text().splitlines()
    row = next(i for i, line in enumerate(lines) if '"stage": "reach"' in line)
    tick = json.loads(lines[row])
    tick[key] = tick[key][:-1] + ("0" if tick[key][-1] != "0" else "1") if key == "packet" else [tick[key][0] + 1e-15]
    lines[row] = json.dumps(tick)
    (tmp_path / "policy.zip").write_bytes((passage / "policy.zip").read_bytes())
    (tmp_path / "telemetry.jsonl").write_text("\n".join(lines) + "\n")
    assert run("replay", str(tmp_path / "telemetry.jsonl")) == 1
    assert f"tick {row - 1}: {key} is" in capsys.readouterr().err


def test_its_motions_are_trajectory_files(passage: Path, recording: Recording) -> None:
    parts = [read_trajectory(passage / name) for name in ("locate.csv", "front.csv")]
    for part in parts:
        assert part.header.backend == "hardware" and part.succeeded
        assert part.header.pipe == PipeCorner.of(130, 90, "right")
    assert parts[1].q[0] == pytest.approx(parts[0].q[-1], abs=0), "the front starts where locating ended"
    reached = [tick["q"] for tick in recording.ticks if tick["stage"] in ("reach", "back")]
    assert parts[1].q[:3].tolist() == reached[:3]


def test_an_arm_in_a_known_pipe_is_placed_by_the_target_that_it_located(passage: Path, recording: Recording) -> None:
    pipe = PipeCorner.of(130, 90, "right")
    true = read_trajectory(passage / "front.csv").header.base_m
    target = next(tick["target"] for tick in recording.ticks if tick.get("target"))
    assert placement_of(pipe, np.array(target), 0.1).base == pytest.approx(true, abs=0.025)


def test_a_dry_run_sends_nothing_that_moves(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(*EMULATED, "--dry-run", "--ticks", "8", "--out", str(tmp_path / "run")) == 0
    assert "would move" in capsys.readouterr().out
    assert byte_log.only_asked(tmp_path / "run" / "bus.jsonl")
    ticks = read_telemetry(tmp_path / "run" / "telemetry.jsonl").ticks
    assert len(ticks) == 8 and ticks[-1]["packet"]


def wait_for_ticks(folder: Path, count: int) -> None:
    """Wait until a mission has recorded so many ticks."""
    log = folder / "telemetry.jsonl"
    wait_until(lambda: log.exists() and len(log.read_text().splitlines()) > count, f"{count} ticks are recorded")


@pytest.mark.parametrize(
    ("stop", "code", "words"),
    [("file", 1, "STOP appeared"), ("SIGUSR1", 138, "SIGUSR1 came")],
)
def test_an_emergency_stop_ends_with_torque_off(
    tmp_path: Path, stop: str, code: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "run"

    def press() -> None:
        wait_for_ticks(folder, 4)
        if stop == "file":
            (folder / "STOP").touch()
        else:
            os.kill(os.getpid(), signal.Signals[stop])

    thread = threading.Thread(target=press, daemon=True)
    thread.start()
    assert run(*EMULATED, "--out", str(folder)) == code
    shown = capsys.readouterr()
    assert words in shown.err
    assert "the last" in shown.out, "the last ticks are shown"
    assert not any(on for on, _ in byte_log.torque(folder / "bus.jsonl", (1, 2, 3, 4)).values())
    assert read_telemetry(folder / "telemetry.jsonl").end is not None
    assert run("replay", str(folder / "telemetry.jsonl")) == 0


def test_a_killed_mission_leaves_its_ticks_and_no_torque(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    command = [sys.executable, "-m", "pipenav", *EMULATED, "--out", str(folder)]
    driver = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wait_for_ticks(folder, 7)
    driver.kill()
    driver.wait()
    ticks = read_telemetry(folder / "telemetry.jsonl").ticks
    switched = (folder / "bus.jsonl", (1, 2, 3, 4))
    wait_until(lambda: not any(on for on, _ in byte_log.torque(*switched).values()), "the watchdog lets go of the arm")
    goals = [
        h for h in byte_log.instructions(folder / "bus.jsonl") if h.packet.encode().hex().startswith("fffffe18831e04")
    ]
    assert len(goals) - len([tick for tick in ticks if tick.get("packet")]) in (0, 1), (
        "all but a running tick are there"
    )


JOINTS = "l, theta1, theta2, theta3"
SUPPLY = "switch the supply off before touching the arm"


@pytest.mark.parametrize(
    ("fault", "cause", "joints"),
    [({"fault": "unplug"}, "bus-lost", JOINTS), ({"fault": "dead", "servo": 3}, "comms", "theta2")],
    ids=["the adapter is pulled", "a servo is silent"],
)
def test_a_stop_names_the_joints_that_could_not_be_confirmed_off(
    tmp_path: Path, fault: dict[str, Any], cause: str, joints: str, capfd: pytest.CaptureFixture[str]
) -> None:
    faults = tmp_path / "faults.json"
    faults.write_text(json.dumps([{**fault, "tick": 4}]))
    assert run(*EMULATED, "--faults", str(faults), "--out", str(tmp_path / "run")) == 1
    said = capfd.readouterr().err
    assert f"stopped ({cause})" in said
    assert said.count(f"Torque may still be on at {joints}: {SUPPLY}.") == 2, "the program and its supervisor say so"


def test_a_full_disk_ends_a_mission_in_one_sentence_with_torque_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    whole = Telemetry.tick

    def fill(telemetry: Telemetry, record: dict[str, Any]) -> None:
        if record["tick"] == 5:
            telemetry._file = FileIO("/dev/full", "w")
        whole(telemetry, record)

    monkeypatch.setattr(Telemetry, "tick", fill)
    assert run(*EMULATED, "--out", str(tmp_path / "run")) == 1
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert "stopped (telemetry): cannot write" in said and "No space left on device; make room" in said
    assert not any(on for on, _ in byte_log.torque(tmp_path / "run" / "bus.jsonl", (1, 2, 3, 4)).values())


def test_a_mission_whose_output_nobody_reads_goes_on(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "pipenav", *EMULATED, "--ticks", "12", "--out", str(tmp_path / "run")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as mission:
        assert mission.stdout is not None and mission.stderr is not None
        while "is going to move" not in mission.stdout.readline():
            pass
        mission.stdout.close()
        said = mission.stderr.read()
    assert "Traceback" not in said
    assert len(read_telemetry(tmp_path / "run" / "telemetry.jsonl").ticks) == 12
    assert not any(on for on, _ in byte_log.torque(tmp_path / "run" / "bus.jsonl", (1, 2, 3, 4)).values())


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in a folder where nothing lies."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("elsewhere")
@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("--policy", "best.zip"), "policy file best.zip cannot be read"),
        (("--policy", "arm"), "there is no arm description arm.toml: write one with pipenav calibrate"),
        (("--policy", "arm", "--robot", "real-setup"), "real-setup"),
        (("--policy", "arm", "--robot", "nobody"), "nobody"),
        (("--policy", "arm", "--turn", "up", "--emulate"), "up"),
        (("--policy", "arm", "--turn", "up"), "turn 'up' is neither left nor right"),
        (("--policy", "arm", "--d", "130"), "give --d and --angle, or neither"),
        (("--policy", "arm", "--target", "somewhere"), "target 'somewhere' is not X,Y"),
        (("--policy", "arm", "--target", "10000,0"), "target 10000,0 mm is out of the arm's reach: x must lie between"),
        (("--policy", "arm", "--target", "0.42,0.08"), "out of the arm's reach (is it in metres?)"),
        (("--emulate", "--d", "0"), "diameter 0 mm is out of range: choose 40 to 300 mm."),
        (("--emulate", "--robot", "pirate"), "approach I drives a slide followed by hinges, and robot 'pirate' has"),
        (("--emulate", "--stop-file", "odd.json"), "the stop file odd.json is there already: remove it"),
        (("--emulate", "--stop-file", "nowhere/STOP"), "there is no folder nowhere for the stop file STOP"),
        (("--policy", "arm", "--patience", "2"), "would delay the stops of a real arm"),
        (("--policy", "arm", "--seed", "2"), "--seed would be ignored here: it is the seed of an emulated arm"),
        (
            ("--policy", "arm", "--emulate", "--arm", "none.toml"),
            "--arm would be ignored here: --emulate needs",
        ),
        (("--policy", "arm", "--faults", "thesis"), "give --emulate too"),
        (("--policy", "arm", "--emulate", "--faults", "none.json"), "cannot read none.json: No such file"),
        (("--policy", "arm", "--emulate", "--faults", "explode.json"), "bus has no fault 'explode': choose drop, "),
        (("--policy", "arm", "--emulate", "--faults", "odd.json"), "fault 1: unknown key 'servoo': did you mean"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_what_cannot_be_driven_is_refused_in_a_sentence(
    args: tuple[str, ...],
    words: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("explode.json").write_text('[{"fault": "explode"}]')
    Path("odd.json").write_text('[{"fault": "drop", "servoo": 2}]')
    assert run("run-real", *args) == 1
    shown = capsys.readouterr().err
    assert words in shown and "Traceback" not in shown
    assert not Path("runs").exists(), "a run that did not begin leaves no folder"


def test_a_robot_without_a_shipped_policy_is_refused(tmp_path: Path) -> None:
    text = (shipped.robots_dir() / "real-setup" / "robot.toml").read_text(encoding="utf-8")
    (tmp_path / "robot.toml").write_text(text.replace('name = "real-setup"', 'name = "nobodys"', 1), encoding="utf-8")
    with pytest.raises(PipenavError, match="no shipped policy drives robot 'nobodys'"):
        policy_for(None, str(tmp_path / "robot.toml"))


def test_a_policy_that_commands_torques_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    policy = load_policy(resolve_policy("arm"))
    task = policy.header.task.model_copy(update={"control": "torque"})
    policy.header = policy.header.model_copy(update={"task": task})
    monkeypatch.setattr(arm_policy, "load_policy", lambda _: policy)
    with pytest.raises(PipenavError, match="commands torques"):
        policy_for("arm", None)


def test_a_mission_in_the_folder_of_another_is_refused(passage: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(*EMULATED, "--out", str(passage)) == 1
    assert "holds a mission already" in capsys.readouterr().err


def test_pictures_and_motions_of_a_mission_in_an_unknown_pipe(recording: Recording, tmp_path: Path) -> None:
    class MissionPlan:
        policy, folder, target = load_policy(resolve_policy("arm")), tmp_path, None

    plan: Any = MissionPlan()
    assert [path.name for path in write_motions(plan, recording.ticks, "passed", None)] == ["run.png"]
    place = located_placement(plan, recording.ticks, PipeCorner.of(130, 90, "right"))
    assert isinstance(place, ArmPlacement)
    names = [path.name for path in write_motions(plan, recording.ticks, "passed", place)]
    assert names == ["run.png", "locate.csv", "front.csv"]
