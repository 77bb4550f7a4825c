"""Verdicts of `pipenav certify` on 40 to 130 mm x 40 to 140 deg, mitre and 1.5 D, between boards and in round bores.

    python benchmarks/certify_sweep.py                       # the shipped robots: about 15 minutes on two cores
    python benchmarks/certify_sweep.py --robot basic --step 10 --degrees 20

Prints for each robot the share of undecided pipes, and the processor time per pipe: near the frontier (within 6 mm of a
pipe with another verdict) and elsewhere.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipenav.certify.model import Model
from pipenav.certify.verdict import certify
from pipenav.pipes import PipeCorner
from pipenav.robots import load_robot
from pipenav.storage.atomic_files import atomic_write

ROBOTS = ("basic", "real-setup", "high-fidelity", "pirate")
NEAR = 6.0
"""Distance to the frontier within which a pipe counts as near it [mm]."""


class Row(NamedTuple):
    """Pipes of one angle: their diameters [mm], verdicts and processor times [s]."""

    robot: str
    bend: float
    bore: str
    angle: float
    diameters: list[float]
    verdicts: list[str]
    seconds: list[float]


def row(robot: str, bend: float, bore: str, angle: float, diameters: list[float]) -> Row:
    """Verdicts on the pipes of one angle."""
    spec = load_robot(robot)
    verdicts: list[str] = []
    seconds: list[float] = []
    for diameter in diameters:
        started = time.process_time()
        pipe = PipeCorner.of(diameter, angle, bend_radius_mm=bend * diameter)
        verdicts.append(certify(Model(spec, pipe, bore), None, math.radians(0.25)).kind)
        seconds.append(time.process_time() - started)
    return Row(robot, bend, bore, angle, diameters, verdicts, seconds)


def near_frontier(one: Row) -> list[bool]:
    """Whether each pipe is undecided or within `NEAR` of a pipe with another verdict."""
    every = list(zip(one.diameters, one.verdicts, strict=True))
    return [kind == "undecided" or any(abs(d - at) <= NEAR and kind != k for d, k in every) for at, kind in every]


def told(rows: list[Row]) -> str:
    """Summary of one robot."""
    kinds = [kind for one in rows for kind in one.verdicts]
    near = np.array([flag for one in rows for flag in near_frontier(one)])
    seconds = np.array([second for one in rows for second in one.seconds])
    counts = ", ".join(f"{kinds.count(kind)} {kind}" for kind in ("passable", "impossible", "undecided"))
    text = f"{rows[0].robot}: {len(kinds)} pipes, {counts} ({100 * kinds.count('undecided') / len(kinds):.1f} %)"
    for name, these in (("near the frontier", seconds[near]), ("elsewhere", seconds[~near])):
        if len(these):
            median, most = np.percentile(these, [50, 95])
            text += f"\n  {name}: {len(these)} pipes, "
            text += f"median {median:.2f} s, 95 % within {most:.2f} s, max {max(these):.2f} s"
    return text


def main() -> None:
    """Run the sweep."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", action="append", help="a shipped robot; repeatable; default: all four")
    parser.add_argument("--step", type=float, default=2.5, help="step of the diameter in mm")
    parser.add_argument("--degrees", type=float, default=10.0, help="step of the angle in deg")
    parser.add_argument("--processes", type=int, default=2, help="processes")
    parser.add_argument("--out", type=Path, help="file for every verdict, as JSON; rows in it count as done")
    given = parser.parse_args()
    diameters = np.arange(40.0, 130.0 + 1e-9, given.step).tolist()
    angles = np.arange(40.0, 140.0 + 1e-9, given.degrees).tolist()
    kept = given.out is not None and given.out.is_file()
    found = [Row(**one) for one in json.loads(given.out.read_text())] if kept else []
    with ProcessPoolExecutor(given.processes) as pool:
        for robot in given.robot or ROBOTS:
            done = {one[:4] for one in found}
            every = [(robot, *case) for case in itertools.product((0.0, 1.5), ("plane", "round"), angles)]
            for waiting in [pool.submit(row, *case, diameters) for case in every if case not in done]:
                found.append(waiting.result())
                if given.out is not None:
                    atomic_write(given.out, json.dumps([one._asdict() for one in found]) + "\n")
            print(told([one for one in found if one.robot == robot]), flush=True)


if __name__ == "__main__":
    main()
