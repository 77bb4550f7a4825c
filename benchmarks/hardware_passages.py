"""Share of missions in which `pipenav run-real --emulate` takes the arm around a corner with the thesis's bad scanner.

    python benchmarks/hardware_passages.py             # 130 mm, 60, 90 and 120 deg, 50 missions each: about 20 minutes
    python benchmarks/hardware_passages.py --runs 5 --angles 60

Every mission is the whole command in real time: check, locate, reach, back out. Left and right turns alternate. Exits
with 1 if fewer than 98 % of any angle's missions passed; the thesis located less than 60 % of its targets.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from pipenav.deployment.plan import TELEMETRY
from pipenav.deployment.telemetry import read_telemetry

PROMISED = 0.98


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--angles", type=int, nargs="+", default=[60, 90, 120])
    parser.add_argument("--diameter", type=float, default=130.0)
    parser.add_argument("--runs", type=int, default=50, help="at each angle")
    parser.add_argument("--faults", default="thesis", help="as of run-real; none for a healthy scanner")
    parser.add_argument("--policy", default=None, help="policy file or name; default the shipped one for the arm")
    parser.add_argument("--jobs", type=int, default=1, help="arms at the same time")
    parser.add_argument("--keep", type=Path, default=None, help="folder for the mission folders")
    given = parser.parse_args()
    missed = 0
    for angle in given.angles:
        with ThreadPoolExecutor(given.jobs) as pool:
            ended = list(pool.map(lambda seed, angle=angle: one_mission(given, angle, seed), range(given.runs)))
        outcomes = Counter(one.outcome for one in ended)
        share = outcomes["passed"] / given.runs
        missed += share < PROMISED
        located = sum(one.located for one in ended) / given.runs
        where = f"{given.diameter:g} mm, {angle} deg"
        print(f"{where}: located {located:.0%}, passed {share:.0%}, {dict(outcomes)}", flush=True)
    return int(missed > 0)


class Ended(NamedTuple):
    """End of a mission, and whether a target was found."""

    outcome: str
    located: bool


def one_mission(given: argparse.Namespace, angle: int, seed: int) -> Ended:
    """Carry out a mission in a process of its own."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "run" if given.keep is None else given.keep / f"{angle}-{seed}"
        command = [sys.executable, "-m", "pipenav", "run-real", "--emulate", "--d", f"{given.diameter:g}"]
        command += ["--angle", str(angle), "--turn", ("left", "right")[seed % 2], "--seed", str(seed)]
        command += ["--out", str(folder)]
        command += [] if given.policy is None else ["--policy", given.policy]
        command += [] if given.faults == "none" else ["--faults", given.faults]
        ended = subprocess.run(command, capture_output=True, text=True)
        if not (folder / TELEMETRY).exists():
            return Ended((ended.stderr.strip().splitlines() or ["no telemetry"])[-1], False)
        recording = read_telemetry(folder / TELEMETRY)
        end = recording.end or {"end": "killed", "cause": None}
        return Ended(str(end["cause"] or end["end"]), any(tick.get("target") for tick in recording.ticks))


if __name__ == "__main__":
    sys.exit(main())
