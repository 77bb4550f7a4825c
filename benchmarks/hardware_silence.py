"""Cost of a servo that falls silent, judged by the bytes that reached the emulated servos.

    python benchmarks/hardware_silence.py               # 20 times each of the four servos, 2 minutes

A servo that answers no more must not use up the others' tick (40 ms of 100), and stops the arm in the second one. Exits
with 1 if the arm stopped for another reason, or torque stayed on.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pipenav_hardware import packets
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Command
from pipenav.backends.real_robot import load_real_robot
from pipenav.backends.registry import open_backend
from pipenav.backends.safety import Stopped
from pipenav.deployment.guard import guarded
from pipenav.robots.robot import load_robot

ROBOT = load_robot("real-setup")
WHOLE_TICKS = 3
"""Number of ticks before the servo falls silent."""

LATEST = 0.07
"""Latest moment of a tick's idle part at which the servo falls silent [s]."""


class Silence(NamedTuple):
    """Time until torque was off [s].

    Attributes:
        tick: time since the first question of the tick that stopped the arm.
        whole: time since the silence began.
    """

    tick: float
    whole: float


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=20, help="of each servo")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--patience", type=float, default=1.0, help="factor on every time limit, on a busy machine")
    given = parser.parse_args()
    rng = random.Random(given.seed)
    causes: Counter[str] = Counter()
    with Emulator(ROBOT, EmulatorSettings(boot_time=0.0)) as emulator:
        for servo in [servo for servo in emulator.arm.ids for _ in range(given.trials)]:
            causes[fall_silent(emulator, servo, rng.uniform(0.0, LATEST), given.patience)] += 1
        time.sleep(0.3)
        silences = list(measured(emulator.log_path))
    print(f"{causes.total()} silent servos, stopped by {dict(causes)}, torque off in {len(silences)}")
    for name, what in {"tick": "the tick that stops, to torque off", "whole": "silence to torque off"}.items():
        times = 1e3 * np.array([getattr(silence, name) for silence in silences])
        print(f"{what:36} median {np.median(times):6.1f} ms, worst {times.max():6.1f} ms")
    return int(len(silences) < causes.total() or set(causes) != {"comms"})


def fall_silent(emulator: Emulator, servo: int, moment: float, patience: float) -> str:
    """Drive until a servo has fallen silent, and the arm has stopped.

    Args:
        emulator: the emulated arm.
        servo: id of the servo.
        moment: time from a tick's goals to the silence [s].
        patience: factor on every time limit.

    Returns:
        The cause of the stop.
    """
    emulator.order(clear=True)
    arm = open_backend("hardware", ROBOT, 1, {"arm": str(emulator.arm_path), "patience": patience})
    assert isinstance(arm, load_real_robot())
    try:
        with guarded(arm):
            start = arm.read().q
            arm.reset(np.array([0]), [], start, np.zeros(1))
            tick = 0
            while True:
                arm.read()
                if arm.complete:
                    arm.send(Command("position", start))
                else:
                    arm.hold()
                tick += 1
                if tick == WHOLE_TICKS:
                    time.sleep(moment)
                    emulator.order(fault="dead", servo=servo)
                arm.wait()
    except Stopped as stopped:
        return stopped.cause
    finally:
        arm.close()


def measured(log: Path) -> list[Silence]:
    """Every silence that ended with torque off."""
    begins = [r["t"] for r in byte_log.records(log) if r.get("event") == "order" and r["order"].get("fault") == "dead"]
    heard = byte_log.instructions(log)
    asked = [one.time for one in heard if one.packet.code == packets.READ]
    ticks = [after for before, after in pairwise(asked) if after - before > CONTROL_PERIOD / 3]
    offs = [one.time for one in heard if one.packet.encode() == packets.TORQUE_OFF_ALL]
    found = []
    for begin, end in zip(begins, [*begins[1:], float("inf")], strict=True):
        off = min((off for off in offs if begin < off < end), default=None)
        if off is not None:
            found.append(Silence(off - max(tick for tick in ticks if tick < off), off - begin))
    return found


if __name__ == "__main__":
    sys.exit(main())
