"""Durations of whole commands, as ratios to another revision's: `benchmarks/compare.sh REVISION`.

Each command is run by the code of either tree in turn, in new folders, so that both share the machine alike; medians
are compared. What takes minutes runs only when it is named with `--only`. Nothing else should run beside it.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parent))  # also where PYTHONSAFEPATH is set

from revisions import ROOT, run_pipenav, tree_of


class Command(NamedTuple):
    """A command line without its first word, and whether it is run where none is named."""

    line: str
    usual: bool


COMMANDS = {
    "help": Command("--help", True),
    "gen-pipe": Command("gen-pipe --d 100 --angle 75 --out pipe", True),
    "eval-one": Command("eval --policy arm --pipes d=100,angle=75 --episodes 20 --out evaluated", True),
    "view-one": Command("view --policy arm --pipes d=100,angle=75 --out seen.png", True),
    "eval": Command("eval --policy arm --pipes working-range --episodes 20 --out evaluated", True),
    "eval-pirate-strong": Command(
        "eval --policy pirate-strong --pipes working-range --episodes 5 --out evaluated", True
    ),
    "train": Command("train --backend mujoco --out trained", True),
    "thesis": Command("train --preset thesis-torque --out trained", False),
    "pirate-strong": Command("train --preset pirate-strong --out trained", False),
    "experiment": Command("experiment all --seeds 3 --out tried", False),
}


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="benchmarks/compare.sh", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("revision", help="the revision to compare with, as git names it")
    parser.add_argument("--only", choices=COMMANDS, action="append", help="time this command alone; repeatable")
    parser.add_argument("--repeats", type=int, default=3, help="runs of each command in each tree")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    names = given.only or [name for name, command in COMMANDS.items() if command.usual]
    with tree_of(given.revision) as tree:
        measured = {name: durations(COMMANDS[name].line, tree, given.repeats) for name in names}
    if given.json:
        print(json.dumps({"revision": given.revision, "commands": measured}))
    else:
        print(f"{'command':12} {given.revision[:12]:>12} {'this tree':>12} {'ratio':>8}")
        for name, seconds in measured.items():
            print(f"{name:12} {seconds['before_s']:10.2f} s {seconds['now_s']:10.2f} s {seconds['ratio']:8.2f}")


def durations(line: str, tree: Path, repeats: int) -> dict[str, float]:
    """Median durations [s] of a command in another tree and in this one, and their ratio."""
    seconds: dict[Path, list[float]] = {tree: [], ROOT: []}
    for _ in range(repeats):
        for side, taken in seconds.items():
            with tempfile.TemporaryDirectory() as folder:
                begin = time.perf_counter()
                run_pipenav(side, line, Path(folder))
                taken.append(time.perf_counter() - begin)
    before, now = (statistics.median(taken) for taken in seconds.values())
    return {"before_s": round(before, 3), "now_s": round(now, 3), "ratio": round(now / before, 3)}


if __name__ == "__main__":
    main()
