"""Time that each part of a tick takes on an emulated arm in real time, over mission after mission.

    python benchmarks/hardware_loop.py                  # 10,000 ticks: 17 minutes
    python benchmarks/hardware_loop.py --ticks 600 --latency 0.004

The bus is as slow as a real one: 10 bits a byte at 1 Mbaud, and the adapter's latency on every answer. In the idle part
of every tick the same four questions go to a process that does nothing but wait as long and answer: the time that these
take longer than they should is the computer's own. Exits with 1 if a deadline was missed.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import tempfile
import time
import tty
from pathlib import Path
from typing import Any

import numpy as np
from pipenav_hardware import table
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.config import EmulatorSettings

from pipenav.arrays import Floats
from pipenav.backends.real_robot import load_real_robot
from pipenav.backends.registry import open_backend
from pipenav.deployment.arm_policy import policy_for
from pipenav.deployment.emulation import draw_start
from pipenav.deployment.guard import guarded
from pipenav.deployment.loop import control_loop
from pipenav.deployment.mission import mission_of, mission_settings
from pipenav.deployment.session import switch_on
from pipenav.deployment.telemetry import Telemetry
from pipenav.locating.locator import Exit
from pipenav.pipes.corner import PipeCorner

ANSWER = table.SETTINGS_SIZE + table.STATE_SIZE + 6
"""Number of bytes of a servo's answer."""

QUESTION = 8
"""Number of bytes of the question for it."""

WANTED = 10.0
"""Longest time that a tick is wanted to take [ms]."""

QUIET = 0.02
"""Time from a tick to the bare questions [s]: the emulator has computed the arm's motion by then."""

STAGES = {"reach": "policy and its observation", "locate": "locating", "back": "backing out"}


class Bare:
    """A terminal with a process at its other end that waits as long as a servo does, and answers.

    Attributes:
        least: time that all questions would take if the computer took none [s].
        times: times that they took [s].
    """

    def __init__(self, count: int, latency: float, baud: int) -> None:
        self._count = count
        wait = latency + 10 * (QUESTION + ANSWER) / baud
        self.least = count * wait
        self.times: list[float] = []
        far, self._near = os.openpty()
        tty.setraw(self._near)
        self._process = os.fork()
        if not self._process:
            os.close(self._near)
            with contextlib.suppress(OSError):  # the other end was closed
                while os.read(far, QUESTION):
                    time.sleep(wait)
                    os.write(far, bytes(ANSWER))
            os._exit(0)
        os.close(far)

    def ask(self) -> None:
        """Ask as many questions as there are servos, one after the other."""
        begun = time.monotonic()
        for _ in range(self._count):
            os.write(self._near, bytes(QUESTION))
            heard = 0
            while heard < ANSWER:
                heard += len(os.read(self._near, ANSWER - heard))
        self.times.append(time.monotonic() - begun)

    def close(self) -> None:
        os.close(self._near)
        os.waitpid(self._process, 0)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ticks", type=int, default=10_000)
    parser.add_argument("--latency", type=float, default=0.001, help="of the USB adapter, per answer [s]")
    parser.add_argument("--policy", default=None, help="policy file or name; default the shipped one for the arm")
    parser.add_argument("--patience", type=float, default=1.0, help="factor on every time limit, on a busy machine")
    given = parser.parse_args()
    policy = policy_for(given.policy, None)
    robot, pipe = policy.header.robot, PipeCorner.of(130, 90)
    settings = mission_settings(Exit("left"), None, retreat=True)
    start = draw_start(robot, pipe, 0)
    records: list[dict[str, Any]] = []
    outcomes: dict[str, int] = {}

    def show(record: dict[str, Any]) -> None:
        records.append(record)
        time.sleep(QUIET)
        bare.ask()

    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.closing(Bare(len(robot.joints), given.latency, 1_000_000)) as bare,
        Emulator(robot, EmulatorSettings(adapter_latency=given.latency), pipe, start) as emulator,
        Telemetry(Path(folder) / "telemetry.jsonl") as telemetry,
    ):
        telemetry.begin({})
        arm = open_backend("hardware", robot, 1, {"arm": str(emulator.arm_path), "patience": given.patience})
        assert isinstance(arm, load_real_robot())
        with guarded(arm):
            switch_on(arm, policy, settings)
            while (left := given.ticks - len(records)) > 0:
                mission = mission_of(policy, settings)
                outcome = control_loop(arm, mission, telemetry, show, Path(folder) / "STOP", left)
                outcomes[outcome] = outcomes.get(outcome, 0) + 1
                arm.wait()
        arm.close()
    return report(records, outcomes, bare)


def report(records: list[dict[str, Any]], outcomes: dict[str, int], bare: Bare) -> int:
    """Print the table.

    Returns:
        1 if a tick was late, else 0.
    """
    late = max(record["raw"]["late"] for record in records if "raw" in record)
    timed = [record for record in records if "taken" in record.get("seconds", {})]
    taken, bus = (1e3 * np.array([record["seconds"][part] for record in timed]) for part in ("taken", "bus"))
    alone = 1e3 * np.array(bare.times)
    print(f"{len(records)} ticks, missions {outcomes}, missed deadlines {late}")
    print(f"{'ms':36} median   99 % 99.9 %  worst")
    row("whole tick, due to goals sent", taken)
    row("servos read", bus)
    row(f"bare answers, {1e3 * bare.least:.1f} ms at least", alone)
    row("limits and goals", 1e3 * np.array([record["seconds"]["send"] for record in timed]))
    for stage, what in STAGES.items():
        row(what, 1e3 * np.array([r["seconds"]["decide"] for r in timed if r["stage"] == stage]))
    others = float(np.median(taken - bus))
    print(
        f"{(taken > WANTED).sum()} ticks took more than {WANTED:g} ms; with bare answers for the servos', and "
        f"{others:.1f} ms for all else, {(alone + others > WANTED).sum()} would have"
    )
    return int(late > 0)


def row(what: str, times: Floats) -> None:
    """Print a line of the table [ms]."""
    if len(times):
        print(
            f"{what:36}" + "".join(f"{value:7.2f}" for value in (*np.quantile(times, [0.5, 0.99, 0.999]), times.max()))
        )


if __name__ == "__main__":
    sys.exit(main())
