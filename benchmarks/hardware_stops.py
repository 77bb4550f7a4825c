"""Whether torque goes off whatever ends the driver, judged by the bytes that reached the emulated servos.

    python benchmarks/hardware_stops.py                     # 200 random moments of each ending, at most 0.1 and 0.2 s
    python benchmarks/hardware_stops.py --trials 5 --only SIGKILL segfault
    python benchmarks/hardware_stops.py --by-hand           # driven as by pipenav drive

Every trial is a process of its own that connects, switches torque on and swings the arm until it is ended at a random
moment: while it connects, while it switches on, or in any part of its loop. Exits with 1 if torque stayed on, or was on
for longer than promised.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import math
import os
import random
import signal
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import FrameType
from typing import NamedTuple

import numpy as np
from pipenav_hardware import packets, table
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings

from pipenav.backends.messages import Command
from pipenav.backends.real_robot import RealRobot, load_real_robot
from pipenav.backends.registry import open_backend
from pipenav.deployment.guard import guarded
from pipenav.driving.arm_session import ArmScene, HandMission, drive_by_hand
from pipenav.driving.ask import Ask, Seen
from pipenav.driving.door import Door, Scene
from pipenav.robots.robot import load_robot

ROBOT = load_robot("real-setup")
ENDINGS = {
    "SIGINT": 0.1,
    "SIGTERM": 0.1,
    "SIGHUP": 0.1,
    "exception": 0.1,
    "second-ctrl-c": 0.1,
    "SIGKILL": 0.2,
    "segfault": 0.2,
}
"""Endings of the driver, and the time within which torque must be off on every servo [s]."""

LONGEST_END = 5.0
"""Longest time until a driver has ended after its ending [s]; one that goes on is killed and counts as failed."""

SECOND = 0.03
"""Longest time from the first Ctrl-C to the second [s]."""


class Trial(NamedTuple):
    """Times at which a driver was started, and ended [s]."""

    started: float
    ended: float


class Torque(NamedTuple):
    """A write of a servo's torque register that arrived, at a time [s]."""

    time: float
    on: bool


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=200, help="of each ending")
    parser.add_argument("--only", nargs="+", choices=ENDINGS, default=list(ENDINGS), help="these endings")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--patience", type=float, default=1.0, help="factor on every time limit, on a busy machine")
    parser.add_argument("--life", type=float, default=1.2, help="longest time from a driver's start to its end [s]")
    parser.add_argument("--by-hand", action="store_true", help="driven through the door of pipenav drive")
    given = parser.parse_args()
    failures = 0
    for name in given.only:
        left_on, times = measure(name, given)
        slowest = max(times, default=0.0)
        late = slowest > ENDINGS[name] * given.patience
        failures += left_on + late
        print(
            f"{name}: {given.trials} trials, torque was on in {len(times)}, left on {left_on}, off after "
            f"{1e3 * statistics.median(times or [0.0]):.1f} ms (median), {1e3 * slowest:.1f} ms (slowest)",
            flush=True,
        )
    return int(failures > 0)


class Measured(NamedTuple):
    """The drivers that one ending ended.

    Attributes:
        left_on: number of those that left torque on.
        times: how long torque was still on after those that were ended with torque on [s].
    """

    left_on: int
    times: list[float]


def measure(name: str, given: argparse.Namespace) -> Measured:
    """End that many drivers by one ending."""
    rng = random.Random(f"{given.seed} {name}")
    with Emulator(ROBOT, EmulatorSettings(boot_time=0.0)) as emulator:
        lives = [rng.uniform(0.0, given.life) for _ in range(given.trials)]
        driver = by_hand if given.by_hand else swing
        done = [
            run_trial(name, partial(driver, name, emulator.arm_path), life, given.patience, rng.uniform(0.0, SECOND))
            for life in lives
        ]
        time.sleep(0.3)
        writes = {servo: torque_writes(emulator.log_path, servo) for servo in emulator.arm.ids}
    left_on, times = 0, []
    for trial, after in zip(done, [*(trial.started for trial in done[1:]), math.inf], strict=True):
        offs = [off_time([w for w in writes[servo] if trial.started <= w.time < after]) for servo in writes]
        left_on += any(off == math.inf for off in offs)
        still = [off - trial.ended for off in offs if off is not None and trial.ended < off < math.inf]
        if still:
            times.append(max(still))
    return Measured(left_on, times)


def torque_writes(log: Path, servo: int) -> list[Torque]:
    """Every write of a servo's torque register, to it alone and to all servos."""
    register = table.TORQUE_ENABLE.address
    return [
        Torque(heard.time, bool(heard.packet.parameters[1]))
        for heard in byte_log.instructions(log)
        if heard.packet.code == packets.WRITE
        and heard.packet.parameters[0] == register
        and heard.packet.id in (servo, packets.BROADCAST)
    ]


def off_time(writes: list[Torque]) -> float | None:
    """Time at which torque went off for good [s]: None if it never was on, infinity if it stayed on."""
    last_on = max((i for i, write in enumerate(writes) if write.on), default=None)
    if last_on is None:
        return None
    return writes[last_on + 1].time if last_on + 1 < len(writes) else math.inf


def run_trial(name: str, driver: Callable[..., None], life: float, patience: float, second: float) -> Trial:
    """Start a driver and end it.

    Args:
        name: the ending.
        driver: drives the arm for ever, called with its life, a pipe's end and the patience.
        life: time from its start to its end [s].
        patience: factor on every time limit.
        second: time from the first Ctrl-C to a second one [s].
    """
    reading, writing = os.pipe()
    started = time.monotonic()
    child = os.fork()
    if not child:
        os.close(reading)
        with contextlib.suppress(BaseException):
            driver(life, writing, patience)
        os._exit(0)
    os.close(writing)
    ended = math.nan
    if name in ("exception", "segfault"):
        ended = float(os.read(reading, 64).decode() or "nan")
    else:
        time.sleep(life)
        ended = time.monotonic()
        os.kill(child, signal.SIGINT if name == "second-ctrl-c" else signal.Signals[name])
        if name == "second-ctrl-c":
            time.sleep(second)
            os.kill(child, signal.SIGINT)
    os.close(reading)
    give_up = time.monotonic() + LONGEST_END
    while os.waitpid(child, os.WNOHANG) == (0, 0):
        time.sleep(0.01)
        if time.monotonic() > give_up:  # torque stays on until then, which the log shows
            os.kill(child, signal.SIGKILL)
    time.sleep(0.15)  # for the supervisor of a driver that is dead
    return Trial(started, ended)


def swing(name: str, arm: Path, life: float, report: int, patience: float) -> None:
    """Be the driver: swing the arm to and fro for ever, or until an ending that comes from within."""
    real_robot = connected(name, arm, life, report, patience)
    with contextlib.closing(real_robot), guarded(real_robot):
        start = real_robot.read().q
        real_robot.reset(np.array([0]), [], start, np.zeros(1))
        begun = time.monotonic()
        while True:
            real_robot.read()
            away = np.array([0.0, 0.3, -0.3, 0.3]) * math.sin(3 * (time.monotonic() - begun))
            real_robot.step(Command("position", start + away))


class Waver:
    """A person who bends the arm's joints to and fro."""

    def ask(self, seen: Seen) -> Ask:
        share = math.sin(0.3 * seen.tick)
        return Ask(active=True, joints={"theta1": share, "theta2": -share, "theta3": share})


def by_hand(name: str, arm: Path, life: float, report: int, patience: float) -> None:
    """Be the driver, as `pipenav drive` is: a person bends the arm's joints for ever."""
    real_robot = connected(name, arm, life, report, patience)
    with tempfile.TemporaryDirectory() as folder, contextlib.closing(real_robot):
        given = ArmScene(Scene(None, 0.0, None), 0.0, Path(folder), Path(folder) / "STOP", None)
        mission = HandMission(ROBOT, Door(ROBOT, Waver(), False), given, None)
        drive_by_hand(real_robot, mission, given, lambda _: None, {})


def connected(name: str, arm: Path, life: float, report: int, patience: float) -> RealRobot:
    """The arm, and an ending that comes from within after a time."""

    def end(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  # the signature of a handler
        os.write(report, str(time.monotonic()).encode())
        if name == "segfault":
            ctypes.string_at(0)
        raise RuntimeError("an exception somewhere in the program")

    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs start with it ignored,
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # and those of nohup with this one
    if name in ("exception", "segfault"):
        signal.signal(signal.SIGALRM, end)
        signal.setitimer(signal.ITIMER_REAL, max(life, 1e-3))
    real_robot = open_backend("hardware", ROBOT, 1, {"arm": str(arm), "patience": patience})
    assert isinstance(real_robot, load_real_robot())
    return real_robot


if __name__ == "__main__":
    sys.exit(main())
