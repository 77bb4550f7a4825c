"""Episodes of `pipenav drive` without a person, divided over many processes: how many passed, and which did not.

    python benchmarks/driven.py --robot pirate --episodes 10 --processes 16    # the whole robot by the steps (a) to (e)
    python benchmarks/driven.py --robot basic --episodes 10 --processes 16     # the arm by its tip
    python benchmarks/driven.py --policy high-fidelity --pipes thesis --disturb real-world --seed 1 --out shared

An episode depends on the seed, its pipe and its number in it alone: the results are the same for every number of
processes, and those of `pipenav drive --operator scripted` with the same arguments. An episode of `pirate` takes about
0.45 s of a processor (1,800 of them 13 minutes, 1 minute on 16 cores), one of `basic` 0.09 s (1,800 of them 3 minutes).
Exits with 1 if the share of the passed episodes is below `--least`.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

from pipenav.driving.plans import DrivePlan, free_drive_folder, make_plan
from pipenav.driving.records import DriveRecords, EpisodeRecord, write_records
from pipenav.driving.scripted import script_for
from pipenav.driving.sessions import Session
from pipenav.evaluation.interval import wilson
from pipenav.storage.atomic_files import used_folder

PIPES_AT_ONCE = 2
"""Pipes of a piece of work: few enough that the last pieces keep every processor busy."""

SCHEMA = 1


def plan_of(given: argparse.Namespace) -> DrivePlan:
    """The plan of all episodes."""
    plan = make_plan(given.policy, given.robot, given.pipes, given.episodes, given.seed)
    return plan.on("mujoco", {"threads": 1}, given.disturb, None)


def driven(given: argparse.Namespace, first: int) -> tuple[EpisodeRecord, ...]:
    """The episodes in a piece's pipes, from the number of the first pipe on."""
    plan = plan_of(given)
    part = slice(first, first + PIPES_AT_ONCE)
    plan = replace(plan, pipes=plan.pipes[part], names=plan.names[part])
    shared = plan.controller is not None
    scripted = given.operator == "scripted"
    session = Session(plan, (lambda _: script_for(plan.robot, plan.seed, shared)) if scripted else None)
    session.run()
    return tuple(session.records)


def in_processes(given: argparse.Namespace, pipes: int) -> list[EpisodeRecord]:
    """The episodes in all pipes, in no order."""
    records: list[EpisodeRecord] = []
    with ProcessPoolExecutor(given.processes, get_context("spawn")) as pool:
        pieces = [pool.submit(driven, given, first) for first in range(0, pipes, PIPES_AT_ONCE)]
        for done, piece in enumerate(as_completed(pieces), 1):
            records += piece.result()
            if sys.stderr.isatty() or done == len(pieces):
                passed = sum(record.passed for record in records)
                print(f"{done} of {len(pieces)} pieces, {passed} of {len(records)} passed", file=sys.stderr)
    return records


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot")
    parser.add_argument("--policy", help="shared control with this policy")
    parser.add_argument("--operator", choices=["scripted", "none"], default="scripted")
    parser.add_argument("--pipes", nargs="+", default=["working-range"])
    parser.add_argument("--episodes", type=int, default=1, help="in each pipe")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--disturb")
    parser.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--least", type=float, default=0.95, help="share that must pass")
    parser.add_argument("--out", type=Path, help="folder for drive.json, as pipenav compare reads it")
    given = parser.parse_args()
    folder = None if given.out is None else free_drive_folder(given.out)
    plan, begun = plan_of(given), time.monotonic()
    order = {name: number for number, name in enumerate(plan.names)}
    found = sorted(in_processes(given, len(plan.pipes)), key=lambda one: (order[one.pipe], one.number))
    records = DriveRecords(
        schema=SCHEMA,
        robot=plan.robot.name,
        policy=given.policy,
        operator=given.operator,
        input=None,
        backend="mujoco",
        seed=given.seed,
        disturb=given.disturb,
        episodes=tuple(found),
    )
    if folder is not None:
        with used_folder(folder):
            write_records(folder, records)
    seconds = time.monotonic() - begun
    return show(records, given.least, f"{seconds:.0f} s in {given.processes} processes")


def show(records: DriveRecords, least: float, took: str) -> int:
    """Print the counts and every failure; 1 if too few passed."""
    episodes = records.episodes
    passed, n = sum(one.passed for one in episodes), len(episodes)
    low, high = wilson(passed, n)
    for one in episodes:
        if not one.passed:
            print(
                f"  failed: {one.pipe}, seed {records.seed}, episode {one.number}: {one.outcome}, {one.seconds:.1f} s"
            )
    for outcome, count in Counter(one.outcome for one in episodes).most_common():
        print(f"  {outcome}: {count}")
    print(
        f"{records.robot}, {records.driver}{', ' + records.disturb if records.disturb else ''}: {passed} of {n} "
        f"episodes passed, {passed / n:.2%} (95 % interval {low:.2%} to {high:.2%}), "
        f"{sum(one.seconds for one in episodes) / n:.1f} s each, {sum(one.takeovers for one in episodes)} take-overs, "
        f"largest jump {max(one.largest_jump for one in episodes):.3f} of a step's limit; {took}"
    )
    return int(passed < least * n)


if __name__ == "__main__":
    sys.exit(main())
