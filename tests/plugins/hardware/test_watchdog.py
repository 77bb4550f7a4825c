"""The supervisor process switches torque off when the driver dies or hangs while it is on, and else says nothing."""

from __future__ import annotations

import os
import select
import threading
import time
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.waiting import GENEROUS
from pipenav_hardware.packets import READ, TORQUE_OFF_ALL, Packet, Stream
from pipenav_hardware.supervisor import BURSTS, GROUP_PREFIX, PACKETS_PER_BURST, leave_control_group
from pipenav_hardware.watchdog import SILENCE, Watchdog

from pipenav.backends.safety import Stopped

pytestmark = pytest.mark.realtime

PATIENCE = 4.0
"""Factor on the supervisor's time limit: a busy machine may keep the driver of these tests silent for a while."""

LONG = 2 * SILENCE * PATIENCE
ALL = len(BURSTS) * PACKETS_PER_BURST * len(TORQUE_OFF_ALL)
"""Bytes that the supervisor sends to switch torque off."""


class Bus:
    """A servo bus that only listens."""

    def __init__(self) -> None:
        self.heard, self.port = os.pipe()

    def silent(self, seconds: float) -> bool:
        """Whether nothing is sent for so long."""
        return not select.select([self.heard], [], [], seconds)[0]

    def packets(self) -> bytes:
        """The bytes that are sent to switch torque off."""
        sent = b""
        while len(sent) < ALL:
            assert not self.silent(GENEROUS), "nothing more is sent"
            sent += os.read(self.heard, 4096)
        return sent


@pytest.fixture
def bus() -> Iterator[Bus]:
    made = Bus()
    yield made
    os.close(made.heard)
    os.close(made.port)


@pytest.fixture
def watchdog(bus: Bus) -> Iterator[Watchdog]:
    made = Watchdog(bus.port, PATIENCE)
    yield made
    made.close()
    made.close()


def only_torque_off(sent: bytes) -> bool:
    return sent == TORQUE_OFF_ALL * (ALL // len(TORQUE_OFF_ALL))


def test_a_driver_that_lives_is_left_alone(bus: Bus, watchdog: Watchdog) -> None:
    watchdog.armed()
    until = time.monotonic() + LONG
    while time.monotonic() < until:
        watchdog.beat()
        assert bus.silent(SILENCE / 4)
    watchdog.disarmed()
    assert bus.silent(LONG), "torque is off: silence means nothing"


def test_without_torque_neither_silence_nor_the_end_of_the_driver_matters(bus: Bus, watchdog: Watchdog) -> None:
    watchdog.beat()
    assert bus.silent(LONG)
    watchdog.close()
    assert bus.silent(SILENCE)


def test_a_driver_that_hangs_loses_torque_once(bus: Bus, watchdog: Watchdog) -> None:
    watchdog.armed()
    assert only_torque_off(bus.packets())
    watchdog.beat()
    assert bus.silent(LONG), "until torque is on again there is nothing to switch off"
    watchdog.armed()
    assert only_torque_off(bus.packets())


def test_a_driver_that_dies_loses_torque(bus: Bus, watchdog: Watchdog) -> None:
    watchdog.armed()
    os.close(watchdog._pipe)  # as the kernel does when it ends
    watchdog._pipe = -1
    assert only_torque_off(bus.packets())


def test_no_torque_without_a_supervisor(watchdog: Watchdog) -> None:
    watchdog._process.kill()
    watchdog._process.wait()
    for tell in (watchdog.armed, watchdog.beat):
        with pytest.raises(Stopped, match="the supervisor process") as stopped:
            tell()
        assert stopped.value.cause == "supervisor"
    watchdog.disarmed()


class Servos(threading.Thread):
    """Servos behind a pseudo-terminal, of which some answer whether their torque is on."""

    def __init__(self, answers: dict[int, int]) -> None:
        super().__init__(daemon=True)
        self.master, self.port = os.openpty()
        tty.setraw(self.port)
        self.answers = answers

    def run(self) -> None:
        stream = Stream()
        while True:
            for packet in stream.feed(os.read(self.master, 4096)):
                if packet.code == READ and packet.id in self.answers:
                    os.write(self.master, Packet(packet.id, 0x20, bytes([self.answers[packet.id]])).encode())


@pytest.mark.parametrize(
    ("answers", "left"),
    [({1: 0, 2: 0}, ""), ({1: 0}, "theta2"), ({1: 1, 2: 0}, "theta1"), ({}, "theta1, theta2")],
    ids=["all are off", "one is silent", "one is on", "nobody answers"],
)
def test_the_supervisor_names_the_joints_that_do_not_confirm(
    answers: dict[int, int], left: str, capfd: pytest.CaptureFixture[str]
) -> None:
    servos = Servos(answers)
    servos.start()
    watchdog = Watchdog(servos.port, PATIENCE, {1: "theta1", 2: "theta2"})
    watchdog.armed()
    os.close(watchdog._pipe)
    watchdog._pipe = -1
    assert watchdog._process.wait(GENEROUS) == 0
    said = capfd.readouterr().err
    assert ("switch the supply off before touching the arm" in said) == bool(left)
    assert f"still be on at {left}:" in said or not left


def test_the_supervisor_leaves_the_session_and_where_it_can_the_control_group(
    watchdog: Watchdog, tmp_path: Path
) -> None:
    assert os.getsid(watchdog._process.pid) == watchdog._process.pid != os.getsid(0)
    own, groups = tmp_path / "own", tmp_path / "groups"
    own.write_text("0::/user.slice/mission.service\n")
    (groups / "user.slice" / "mission.service").mkdir(parents=True)
    (groups / "user.slice" / f"{GROUP_PREFIX}1").mkdir()
    assert leave_control_group(groups, own)
    assert [path.name for path in (groups / "user.slice").glob(f"{GROUP_PREFIX}*")] == [f"{GROUP_PREFIX}{os.getpid()}"]
    for line in ("0::/", "0::/../x", "12:cpu:/docker/1", ""):
        own.write_text(f"{line}\n")
        assert not leave_control_group(groups, own)
