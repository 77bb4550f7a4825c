"""A policy and a person on one arm: its mission goes on after every hand-back, and torque is off whatever ends it."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.driving import RandomHands, changes
from helpers.emulated import driver
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings

from pipenav.backends.real_robot import ArmStart
from pipenav.backends.simulators import open_simulator
from pipenav.deployment.mission import mission_settings
from pipenav.deployment.session import Ending
from pipenav.deployment.telemetry import read_telemetry
from pipenav.driving.arm_session import ArmScene, Beside, HandMission, drive_by_hand
from pipenav.driving.ask import NOTHING, Ask, Operator, OperatorLost, Seen
from pipenav.driving.door import Door, Scene
from pipenav.locating.locator import Exit
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.policy import load_policy, resolve_policy
from pipenav.tasks.reach import episode

POLICY = load_policy(resolve_policy("arm"))
ROBOT = POLICY.header.robot
PIPE = PipeCorner.of(120, 90)
BESIDE = Beside(POLICY, mission_settings(Exit.of(PIPE), None, False))
IDS = (1, 2, 3, 4)


def scene(folder: Path, most_ticks: int | None = None) -> ArmScene:
    return ArmScene(Scene(PIPE, 0.08, None), 0.0, folder, folder / "STOP", most_ticks)


@pytest.mark.parametrize("turn", ["left", "right"])
@pytest.mark.parametrize("seed", range(4))
def test_a_mission_passes_whenever_a_hand_takes_over(seed: int, turn: str, tmp_path: Path) -> None:
    """Whatever stage a hand takes the arm from, it goes on from there: it finds, reaches and comes back."""
    pipe = PipeCorner.of(120, 90, turn)
    start = episode.sample(ROBOT, POLICY.header.task, [pipe], np.random.default_rng(seed))
    backend = open_simulator("mujoco", ROBOT, 1, {"threads": 1}, len(pipe.segments))
    reading = backend.reset(np.array([0]), [pipe], start.q, start.base)
    hands = RandomHands(ROBOT, seed)
    beside = Beside(POLICY, mission_settings(Exit.of(pipe), None, False))
    mission = HandMission(ROBOT, Door(ROBOT, hands, True), scene(tmp_path), beside)
    stages, step = set(), ROBOT.speed_limits * 0.1
    sent: list[Any] = []
    for _ in range(1000):
        decision = mission.decide(reading)
        if decision.command is None:
            break
        stages.add((decision.stage, decision.step))
        assert (decision.observation is not None) == (decision.step == "reach")
        sent.append(decision.command.values[0])
        backend.step(decision.command)
        reading = backend.read()
    backend.close()
    assert mission.outcome == "passed"
    assert {("policy", "locate"), ("policy", "reach"), ("policy", "back"), ("person", "")} <= stages
    assert mission.door.takeovers > 0
    assert (np.abs(np.diff(sent, axis=0)) <= step * (1 + 1e-6)).all()
    assert np.abs(reading.q - start.q)[0, 1:].max() < 0.3  # straight, as it began


class Nobody:
    """Asks for nothing, until something happens."""

    def __init__(self, ticks: int, happens: Callable[[], Ask]) -> None:
        self._ticks, self._happens = ticks, happens

    def ask(self, seen: Seen) -> Ask:
        return NOTHING if seen.tick < self._ticks else self._happens()


def session(folder: Path, operator: Operator, most_ticks: int | None = None) -> tuple[Ending, bool]:
    """A session on an emulated arm, and whether a servo has torque afterwards."""
    drawn = episode.sample(ROBOT, POLICY.header.task, [PIPE], np.random.default_rng(1))
    start = ArmStart(drawn.q[0], float(drawn.base[0]))
    settings = EmulatorSettings(boot_time=0.0)
    with Emulator(ROBOT, settings, pipe=PIPE, start=start) as emulator, driver(emulator) as arm:
        given = scene(folder, most_ticks)
        mission = HandMission(ROBOT, Door(ROBOT, operator, True), given, BESIDE)
        ending = drive_by_hand(arm, mission, given, lambda _: None, {"robot": ROBOT.name})
        log = folder / "bus.jsonl"
        log.write_bytes(emulator.log_path.read_bytes())
    return ending, any(on for on, _ in byte_log.torque(log, IDS).values())


def lost() -> Ask:
    raise OperatorLost("the gamepad")


def raising(number: int) -> Callable[[], Ask]:
    def happens() -> Ask:
        os.kill(os.getpid(), number)
        return NOTHING

    return happens


ENDINGS = {
    "the end key": (lambda: Ask(end=True), "ended"),
    "the stop key": (lambda: Ask(stop=True), "e-stop"),
    "a gamepad that vanishes": (lost, "operator"),
    "Ctrl-C": (raising(signal.SIGINT), "signal"),
    "SIGTERM": (raising(signal.SIGTERM), "signal"),
    "a foot switch": (raising(signal.SIGUSR1), "e-stop"),
}


@pytest.mark.realtime
@pytest.mark.parametrize(("happens", "outcome"), ENDINGS.values(), ids=ENDINGS)
def test_torque_is_off_after_every_ending_while_the_policy_drives(
    happens: Callable[[], Ask], outcome: str, tmp_path: Path
) -> None:
    ending, torque = session(tmp_path, Nobody(9, happens))
    assert ending.outcome == outcome
    assert not torque
    recording = read_telemetry(tmp_path / "telemetry.jsonl")
    assert {tick["stage"] for tick in recording.ticks if "q" in tick} <= {"policy", "hold", "ended"}
    assert recording.ticks[0]["stage"] == "policy"
    assert (tmp_path / "policy.zip").read_bytes() == POLICY.path.read_bytes()


@pytest.mark.realtime
def test_a_fault_of_the_program_leaves_no_torque(tmp_path: Path) -> None:
    def happens() -> Ask:
        raise ZeroDivisionError("a fault")

    drawn = tmp_path / "faulty"
    drawn.mkdir()
    with Emulator(ROBOT, EmulatorSettings(boot_time=0.0)) as emulator, driver(emulator) as arm:
        given = scene(drawn)
        mission = HandMission(ROBOT, Door(ROBOT, Nobody(5, happens), True), given, BESIDE)
        with pytest.raises(ZeroDivisionError):
            drive_by_hand(arm, mission, given, lambda _: None, {"robot": ROBOT.name})
        log = drawn / "bus.jsonl"
        log.write_bytes(emulator.log_path.read_bytes())
    assert not any(on for on, _ in byte_log.torque(log, IDS).values())


@pytest.mark.realtime
@pytest.mark.slow
def test_hands_and_policy_share_an_emulated_arm_without_a_jump_or_a_trip(tmp_path: Path) -> None:
    ending, torque = session(tmp_path, RandomHands(ROBOT, 3, strength=0.1), 300)
    assert ending.outcome in ("passed", "ended")
    assert not torque
    found = changes(tmp_path / "telemetry.jsonl", ROBOT)
    assert found.count[0] > 1
    assert found.jump <= 1 + 1e-6
