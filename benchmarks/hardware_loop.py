"""How long each part of a tick takes on an emulated arm in real time, over passage after passage.

    python benchmarks/hardware_loop.py                  # 10,000 ticks: 17 minutes
    python benchmarks/hardware_loop.py --ticks 600 --latency 0.004

The bus is as slow as a real one: 10 bits a byte at 1 Mbaud, and the adapter's latency on every answer. Exits with 1 if
a deadline was missed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from pipenav_hardware.emulator.client import Emulator

from pipenav.deploy import drive, guarded
from pipenav.machine import load_machine
from pipenav.pipe import Pipe
from pipenav.real_run import policy_for, rehearse, run_settings
from pipenav.registry import open_backend
from pipenav.replay import run_of
from pipenav.task import episode
from pipenav.telemetry import Telemetry

PARTS = {
    "taken": "whole tick, due to goals sent",
    "bus": "four servos read",
    "read": "all sensors read and judged",
    "decide": "observation and decision",
    "send": "limits and goals",
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ticks", type=int, default=10_000)
    parser.add_argument("--latency", type=float, default=0.001, help="of the USB adapter, per answer [s]")
    parser.add_argument("--policy", default=None, help="policy file or name; default the shipped one for the arm")
    parser.add_argument("--patience", type=float, default=1.0, help="factor on every time limit, on a busy machine")
    given = parser.parse_args()
    policy = policy_for(given.policy, None)
    robot, pipe = policy.header.robot, Pipe.of(130, 90)
    settings = run_settings("left", None, retreat=True)
    start = episode.sample(robot, policy.header.task, [pipe], np.random.default_rng(0))
    records: list[dict[str, Any]] = []
    outcomes: dict[str, int] = {}
    with (
        tempfile.TemporaryDirectory() as folder,
        Emulator(robot, pipe, q=start.q[0], base=float(start.base[0]), adapter_latency=given.latency) as emulator,
        Telemetry(Path(folder) / "telemetry.jsonl", {}) as telemetry,
    ):
        machine = open_backend("hardware", robot, 1, {"arm": str(emulator.arm_path), "patience": given.patience})
        assert isinstance(machine, load_machine())
        with guarded(machine):
            first = machine.read()
            rehearse(policy, settings, first)
            machine.reset(np.array([0]), [], first.q, np.zeros(1))
            while (left := given.ticks - len(records)) > 0:
                run = run_of(policy, settings)
                outcome = drive(machine, run, telemetry, records.append, Path(folder) / "STOP", left)
                outcomes[outcome] = outcomes.get(outcome, 0) + 1
                machine.wait()
        machine.close()
    return report(records, outcomes)


def report(records: list[dict[str, Any]], outcomes: dict[str, int]) -> int:
    """Print the table; 1 if a tick was late."""
    late = max(record["raw"]["late"] for record in records if "raw" in record)
    print(f"{len(records)} ticks, runs {outcomes}, missed deadlines {late}")
    print(f"{'ms':32} median   99 %  worst")
    for name, what in PARTS.items():
        times = 1e3 * np.array([r["seconds"][name] for r in records if name in r.get("seconds", {})])
        print(f"{what:32} {np.median(times):6.2f} {np.quantile(times, 0.99):6.2f} {times.max():6.2f}")
    return int(late > 0)


if __name__ == "__main__":
    sys.exit(main())
