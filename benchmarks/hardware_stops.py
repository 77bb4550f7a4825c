"""Whether torque goes off whatever ends the driver, judged by the bytes that reached the emulated servos.

    python benchmarks/hardware_stops.py                     # 200 random moments of each ending, at most 0.1 and 0.2 s
    python benchmarks/hardware_stops.py --trials 5 --only SIGKILL segfault
    python benchmarks/hardware_stops.py --by-hand           # driven as by pipenav drive
    python benchmarks/hardware_stops.py --by-hand --policy real-setup --driving     # as by pipenav drive --policy

Every trial is a process of its own that connects, switches torque on and swings the arm until it is ended at a random
moment: while it connects, while it switches on, or in any part of its loop; with `--driving` in the loop alone. With a
policy, it and a person drive in turn. Exits with 1 if torque stayed on, or was on for longer than promised.
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
from multiprocessing.sharedctypes import RawValue
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

import numpy as np
from pipenav_hardware import packets, table
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings

from pipenav.backends.messages import Command
from pipenav.backends.real_robot import ArmStart, RealRobot, load_real_robot
from pipenav.backends.registry import open_backend
from pipenav.deployment.arm_policy import policy_for
from pipenav.deployment.guard import guarded
from pipenav.deployment.mission import mission_settings
from pipenav.driving.arm_session import ArmScene, Beside, HandMission, drive_by_hand
from pipenav.driving.ask import NOTHING, PERSON, POLICY, Ask, Seen
from pipenav.driving.door import Door, Scene
from pipenav.locating.locator import Exit
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.config import ReachConfig

ROBOT = load_robot("real-setup")
PIPE = PipeCorner.of(130, 90)
"""The pipe around the arm where a policy drives, which looks for its way."""

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

SUPERVISED = 0.15
"""Time for the supervisor of a driver that is dead, before the next one starts [s]: what it sends later counts as left
on."""

SECOND = 0.03
"""Longest time from the first Ctrl-C to the second [s]."""

TURN = 4
"""Control steps for which a policy drives, and then a person, in turn."""

DRIVERS = ("", PERSON, POLICY)
"""Who may drive when a driver is ended: nobody before its loop, a person, or a policy."""


class Trial(NamedTuple):
    """Times at which a driver was started, and ended [s], and who drove then; see `DRIVERS`."""

    started: float
    ended: float
    who: str


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
    parser.add_argument("--driving", action="store_true", help="end drivers in their loops alone, for --by-hand")
    parser.add_argument("--policy", help="a policy of real-setup that drives in turn with the person, for --by-hand")
    given = parser.parse_args()
    if (given.policy or given.driving) and not given.by_hand:
        parser.error("--policy and --driving are for --by-hand")
    failures = 0
    for name in given.only:
        left_on, times, drove = measure(name, given)
        slowest = max(times, default=0.0)
        late = slowest > ENDINGS[name] * given.patience
        failures += left_on + late
        by_whom = f", {drove.count(PERSON)} while a person drove and {drove.count(POLICY)} while a policy did"
        print(
            f"{name}: {given.trials} trials{by_whom if given.by_hand else ''}, torque was on in {len(times)}, "
            f"left on {left_on}, off after {1e3 * statistics.median(times or [0.0]):.1f} ms (median), "
            f"{1e3 * slowest:.1f} ms (slowest)",
            flush=True,
        )
    return int(failures > 0)


class Measured(NamedTuple):
    """The drivers that one ending ended.

    Attributes:
        left_on: number of those that left torque on.
        times: how long torque was still on after those that were ended with torque on [s].
        drove: who drove at the end of each.
    """

    left_on: int
    times: list[float]
    drove: list[str]


class Life:
    """A driver's life, as it and its parent see it.

    Args:
        name: its ending.
        seconds: time from its start to its end, or with `driving` from its first control step [s].
        driving: whether the time counts from the first control step.
        patience: factor on every time limit.
        second: time from the first Ctrl-C to a second one [s].
    """

    def __init__(self, name: str, seconds: float, driving: bool, patience: float, second: float) -> None:
        self.name, self.seconds, self.driving, self.patience = name, seconds, driving, patience
        self.second = second
        self._who: Any = RawValue("i", 0)  # in memory that parent and child share
        self.report = -1

    @property
    def who(self) -> str:
        """Who drives; empty before the first control step."""
        return DRIVERS[self._who.value]

    @property
    def from_within(self) -> bool:
        """Whether the driver brings about its ending itself."""
        return self.name in ("exception", "segfault")

    def step(self, record: dict[str, Any]) -> None:
        """Note a control step's record, in the driver."""
        if not self.who and self.driving and self.from_within:
            signal.setitimer(signal.ITIMER_REAL, max(self.seconds, 1e-3))
        self._who.value = DRIVERS.index(record["stage"]) if record["stage"] in DRIVERS else self._who.value


def measure(name: str, given: argparse.Namespace) -> Measured:
    """End that many drivers by one ending."""
    rng = random.Random(f"{given.seed} {name}")
    start = episode.sample(ROBOT, ReachConfig(), [PIPE], np.random.default_rng(given.seed))
    around = {"pipe": PIPE, "start": ArmStart(start.q[0], float(start.base[0]))} if given.policy else {}
    beside = None
    if given.policy:
        beside = Beside(policy_for(given.policy, ROBOT.name), mission_settings(Exit.of(PIPE), None, False))
    with Emulator(ROBOT, EmulatorSettings(boot_time=0.0), **around) as emulator:
        seconds = [rng.uniform(0.0, given.life) for _ in range(given.trials)]
        lives = [Life(name, one, given.driving, given.patience, rng.uniform(0.0, SECOND)) for one in seconds]
        driver = partial(by_hand, beside) if given.by_hand else swing
        done = [run_trial(life, partial(driver, emulator.arm_path)) for life in lives]
        time.sleep(0.3)
        writes = {servo: torque_writes(emulator.log_path, servo) for servo in emulator.arm.ids}
    left_on, times = 0, []
    for trial, after in zip(done, [*(trial.started for trial in done[1:]), math.inf], strict=True):
        offs = [off_time([w for w in writes[servo] if trial.started <= w.time < after]) for servo in writes]
        left_on += any(off == math.inf for off in offs)
        still = [off - trial.ended for off in offs if off is not None and trial.ended < off < math.inf]
        if still:
            times.append(max(still))
    return Measured(left_on, times, [trial.who for trial in done])


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


def run_trial(life: Life, driver: Callable[[Life], None]) -> Trial:
    """Start a driver, which drives the arm for ever, and end it."""
    reading, life.report = os.pipe()
    started = time.monotonic()
    child = os.fork()
    if not child:
        os.close(reading)
        with contextlib.suppress(BaseException):
            driver(life)
        os._exit(0)
    os.close(life.report)
    if life.from_within:
        ended = float(os.read(reading, 64).decode() or "nan")
        who = life.who
    else:
        await_loop(life, started)
        time.sleep(life.seconds)
        ended, who = time.monotonic(), life.who
        os.kill(child, signal.SIGINT if life.name == "second-ctrl-c" else signal.Signals[life.name])
        if life.name == "second-ctrl-c":
            time.sleep(life.second)
            os.kill(child, signal.SIGINT)
    os.close(reading)
    give_up = time.monotonic() + LONGEST_END
    while os.waitpid(child, os.WNOHANG) == (0, 0):
        time.sleep(0.01)
        if time.monotonic() > give_up:  # torque stays on until then, which the log shows
            os.kill(child, signal.SIGKILL)
    time.sleep(SUPERVISED * life.patience)
    return Trial(started, ended, who)


def await_loop(life: Life, started: float) -> None:
    """Wait for a driver's first control step, where its time counts from there."""
    while life.driving and not life.who and time.monotonic() - started < LONGEST_END * life.patience:
        time.sleep(0.005)


def swing(arm: Path, life: Life) -> None:
    """Be the driver: swing the arm to and fro for ever, or until an ending that comes from within."""
    real_robot = connected(arm, life)
    with contextlib.closing(real_robot), guarded(real_robot):
        start = real_robot.read().q
        real_robot.reset(np.array([0]), [], start, np.zeros(1))
        begun = time.monotonic()
        while True:
            real_robot.read()
            away = np.array([0.0, 0.3, -0.3, 0.3]) * math.sin(3 * (time.monotonic() - begun))
            real_robot.step(Command("position", start + away))


class Waver:
    """A person who bends the arm's joints to and fro, and leaves it to a policy in turn where there is one."""

    def __init__(self, shared: bool) -> None:
        self._shared = shared

    def ask(self, seen: Seen) -> Ask:
        if self._shared and seen.tick // TURN % 2 == 0:
            return NOTHING
        share = math.sin(0.3 * seen.tick)
        return Ask(active=True, joints={"theta1": share, "theta2": -share, "theta3": share})


def by_hand(beside: Beside | None, arm: Path, life: Life) -> None:
    """Be the driver, as `pipenav drive` is: a person bends the arm's joints for ever, in turn with a policy."""
    real_robot = connected(arm, life)
    pipe = None if beside is None else PIPE
    with tempfile.TemporaryDirectory() as folder, contextlib.closing(real_robot):
        given = ArmScene(Scene(pipe, 0.08, None), 0.0, Path(folder), Path(folder) / "STOP", None)
        mission = HandMission(ROBOT, Door(ROBOT, Waver(beside is not None), beside is not None), given, beside)
        drive_by_hand(real_robot, mission, given, life.step, {})


def connected(arm: Path, life: Life) -> RealRobot:
    """The arm, and an ending that comes from within after a time."""

    def end(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  # the signature of a handler
        os.write(life.report, str(time.monotonic()).encode())
        if life.name == "segfault":
            ctypes.string_at(0)
        raise RuntimeError("an exception somewhere in the program")

    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs start with it ignored,
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # and those of nohup with this one
    if life.from_within:
        signal.signal(signal.SIGALRM, end)
        if not life.driving:
            signal.setitimer(signal.ITIMER_REAL, max(life.seconds, 1e-3))
    real_robot = open_backend("hardware", ROBOT, 1, {"arm": str(arm), "patience": life.patience})
    assert isinstance(real_robot, load_real_robot())
    return real_robot


if __name__ == "__main__":
    sys.exit(main())
