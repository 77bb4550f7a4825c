"""Whether this tree computes what another revision computes: `python benchmarks/same_results.py REVISION`.

For a change that must not change results. Both trees evaluate the shipped policies, locate targets, train a little and
make pipes, with the same commands. Numbers of eval.json must be equal, weights and pipe folders equal to the last bit.
About 10 minutes for each tree on 2 cores; `--earlier FOLDER` takes the results of the other revision from a run before.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parent))  # also where PYTHONSAFEPATH is set

from revisions import ROOT, run_pipenav, tree_of

RENAMED = {"run": "route", "min_clearance_m": "min_range_m", "front": "reach", "front-rear": "reach-rear"}
"""Keys and values of eval.json that have had another name: the older one, then today's."""


class Job(NamedTuple):
    """A command, and the file or folder under its output folder that is compared."""

    command: str
    result: str


def passage(policy: str) -> Job:
    return Job(f"eval --policy {policy} --stage passage --pipes working-range --episodes 5 --out .", "eval.json")


def traverse(policy: str, pipes: str, episodes: int) -> Job:
    return Job(f"eval --policy {policy} --pipes {pipes} --episodes {episodes} --out .", "eval.json")


def locate(robot: str) -> Job:
    return Job(f"eval --stage locate --robot {robot} --pipes thesis --episodes 5 --out .", "eval.json")


JOBS = {
    "gen-pipe": Job("gen-pipe --d 100 --angle 75 --turn right --bend-radius 30", "corner-d100-a75-r30-right"),
    "train": Job("train --preset thesis-torque --steps 20000 --out .", "last.zip"),
    "locate-basic": locate("basic"),
    "locate-high-fidelity": locate("high-fidelity"),
    "locate-real-setup": locate("real-setup"),
    "arm": passage("arm"),
    "high-fidelity": passage("high-fidelity"),
    "real-setup": passage("real-setup"),
    "pirate-strong": traverse("pirate-strong", "working-range", 5),
    "pirate-strong-gravity": traverse("pirate-strong-gravity", "working-range", 5),
    "pirate-runs-level": traverse("pirate-strong", "runs-level", 1),
    "pirate-runs-rolled": traverse("pirate-strong", "runs-rolled", 1),
    "centreline": Job("eval --policy baseline:centreline --pipes thesis --episodes 1 --out .", "eval.json"),
    "sequence": Job("eval --policy baseline:sequence --pipes thesis --episodes 1 --out .", "eval.json"),
    "disturbed": Job("eval --policy arm --pipes thesis --episodes 2 --disturb real-world --out .", "eval.json"),
    "pybullet": Job("eval --policy arm --backend pybullet --pipes thesis --episodes 1 --out .", "eval.json"),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("revision", help="the revision to compare with, as git names it")
    parser.add_argument("--only", choices=JOBS, action="append", help="run this job alone; repeatable")
    parser.add_argument("--earlier", type=Path, help="folder of that revision's results; made where there is none")
    given = parser.parse_args()
    names = given.only or list(JOBS)
    with tempfile.TemporaryDirectory() as scratch:
        earlier, now = given.earlier or Path(scratch, "earlier"), Path(scratch, "now")
        missing = [name for name in names if not (earlier / name / "done").exists()]
        if missing:
            with tree_of(given.revision) as tree:
                run_jobs(tree, missing, earlier)
        run_jobs(ROOT, names, now)
        found = [f"{name}: {problem}" for name in names for problem in differences(name, earlier, now)]
    print(*found, f"{len(names)} jobs, {len(found)} differences", sep="\n")
    sys.exit(bool(found))


def run_jobs(tree: Path, names: list[str], results: Path) -> None:
    """Run jobs with the code of a tree, each in a folder of its own under `results`."""
    for name in names:
        folder = results / name
        folder.mkdir(parents=True, exist_ok=True)
        started = time.monotonic()
        run_pipenav(tree, JOBS[name].command, folder)
        (folder / "done").touch()
        print(f"{time.monotonic() - started:6.1f} s  {tree.name}: {name}", file=sys.stderr)


def differences(name: str, earlier: Path, now: Path) -> Iterator[str]:
    """Differences between a job's two results, in words."""
    before, after = (results / name / JOBS[name].result for results in (earlier, now))
    if before.suffix == ".json":
        yield from changed_values(json.loads(before.read_bytes()), json.loads(after.read_bytes()))
    elif before.suffix == ".zip":
        if weights(before) != weights(after):
            yield "the weights differ"
    else:
        for file in sorted(before.iterdir()):
            if file.suffix != ".png" and file.read_bytes() != (after / file.name).read_bytes():
                yield f"{file.name} differs"


def weights(policy: Path) -> bytes:
    with zipfile.ZipFile(policy) as archive:
        return archive.read("policy.safetensors")


def changed_values(before: Any, after: Any, place: str = "") -> Iterator[str]:
    """Values of `before` that `after` does not have; `after` may hold more."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key, value in before.items():
            key = key if key in after else RENAMED.get(key, key.replace("front_", "reach_"))
            if key not in after:
                yield f"{place}{key} is missing"
            elif place or key != "schema":
                yield from changed_values(value, after[key], f"{place}{key}.")
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for i, (one, other) in enumerate(zip(before, after, strict=True)):
            yield from changed_values(one, other, f"{place}{i}.")
    elif before != after and RENAMED.get(str(before)) != after:
        yield f"{place.rstrip('.')} is {after}, was {before}"


if __name__ == "__main__":
    main()
