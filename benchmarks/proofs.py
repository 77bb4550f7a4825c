"""Policies against proofs, 10,000 episodes unless told otherwise.

    python benchmarks/proofs.py                     # one process
    python benchmarks/proofs.py --processes 16      # the same lines in the same order, one policy and angle each

For each policy and angle, pipes just below the frontier are proven impossible by `pipenav.certify`, once for rigid
bodies and once with the overlap that the task allows, and the policy tries to pass them in a simulator.

The pipes are proven first, so that the episodes can be shared evenly by the proofs that there are.

- A success in a pipe that is proven impossible with the overlap contradicts the proof: none may occur.
- In a pipe that is proven impossible for rigid bodies alone, soft contacts may let a robot pass. The success with the
  least overlap of each pipe is held against a proof with just that overlap: if there is one, it is a contradiction.

Ends with exit code 1 where there was a contradiction.
"""

from __future__ import annotations

import argparse
import itertools
import math
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from multiprocessing import get_context
from multiprocessing.queues import SimpleQueue
from typing import NamedTuple

import numpy as np

from pipenav.backends.simulators import SimulatorSettings
from pipenav.certify.arm import Ends
from pipenav.certify.model import Model
from pipenav.certify.verdict import certify
from pipenav.errors import PipenavError
from pipenav.evaluation.interval import wilson
from pipenav.evaluation.passage import run_task
from pipenav.pipes.corner import PipeCorner
from pipenav.policies.controller import AnyController
from pipenav.policies.named import open_controller
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import check_fits
from pipenav.units import m_to_mm

POLICIES = ("arm", "real-setup", "high-fidelity", "pirate", "pirate-strong")
ANGLES_DEG = (45, 60, 90, 120, 135)
BELOW_MM = (0.0, 0.5, 1.0, 2.0, 4.0)
"""Distances of the bores below the largest one that is proven impossible."""
WIDEST_MM, STEP_MM = 80.0, 1.0
RESOLUTION = math.radians(0.5)
LEAST_OVERLAP = 1e-6
"""Slack of the overlap of a success, in which a proof with that overlap is asked for [m]."""


class Count(NamedTuple):
    """Episodes in pipes that are proven impossible, successes, and contradictions of a proof."""

    pipes: int
    episodes: int
    successes: int
    contradictions: int


class Proof(NamedTuple):
    """Pipes of one angle that are proven impossible for a policy's robot.

    Attributes:
        policy: name or file of the policy.
        angle: interior angle [deg].
        overlap: overlap with the walls that the proof allows [m].
        bores: bores below the frontier, widest first, turns in alternation, each proven impossible [mm].
        seconds: time that finding them took [s].
    """

    policy: str
    angle: float
    overlap: float
    bores: list[float]
    seconds: float

    def pipes(self) -> list[PipeCorner]:
        """The pipes."""
        return [turned(bore, self.angle, number) for number, bore in enumerate(self.bores)]


class Trial(NamedTuple):
    """A policy's episodes in the pipes of one proof, and the time that they took [s]."""

    tries: Count
    seconds: float


def main() -> None:
    """Prove, try, and print a line for each proof."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=10_000, help="episodes of all policies together, at least")
    parser.add_argument("--policies", nargs="+", default=POLICIES, help="shipped policies or files")
    parser.add_argument("--angles", nargs="+", type=float, default=ANGLES_DEG, help="interior angles [deg]")
    parser.add_argument("--backend", default="mujoco", help="the simulator")
    parser.add_argument("--seed", type=int, default=0, help="seed of starts and targets")
    parser.add_argument("--processes", type=int, default=1, help="processes; each has one policy and angle at a time")
    given = parser.parse_args()
    cases = list(itertools.product(given.policies, given.angles))
    spawn = get_context("spawn")
    shares = spawn.SimpleQueue()
    for share in shares_of_cores(given.processes):
        shares.put(share)
    with ProcessPoolExecutor(given.processes, spawn, keep_to_cores, (shares,)) as pool:
        proofs = []
        for found in pool.map(proven, *zip(*cases, strict=True)):
            proofs += found
            print(f"proofs of {found[0].policy} at {found[0].angle:g} deg", file=sys.stderr, flush=True)
        proofs = [proof for proof in proofs if proof.bores]
        if not proofs:
            sys.exit("no pipe is proven impossible")
        each = math.ceil(given.episodes / len(proofs))
        print("policy           proof          angle  bores [mm]     episodes  successes  contradictions  time [s]")
        every = []
        for proof, trial in zip(
            proofs,
            pool.map(tried, proofs, repeat(each), repeat(given.seed), repeat(given.backend)),
            strict=True,
        ):
            every.append(trial.tries)
            print(line(proof, trial), flush=True)
    total = Count(*map(sum, zip(*every, strict=True)))
    most = 100 * wilson(total.contradictions, total.episodes).high
    print(
        f"{total.episodes:,} episodes in {total.pipes} pipes: {total.successes:,} successes, "
        f"{total.contradictions:,} contradictions (at most {most:.3f} % of the episodes, 95 % interval)"
    )
    sys.exit(1 if total.contradictions else 0)


def line(proof: Proof, trial: Trial) -> str:
    """Line of the table for one proof."""
    kind = f"{m_to_mm(proof.overlap):g} mm overlap" if proof.overlap else "rigid"
    bores = f"{proof.bores[-1]:.1f}-{proof.bores[0]:.1f}"
    tries = trial.tries
    return (
        f"{proof.policy:16} {kind:14} {proof.angle:5g}  {bores:13} {tries.episodes:9,} {tries.successes:10,} "
        f"{tries.contradictions:15,} {proof.seconds + trial.seconds:9.0f}"
    )


def keep_to_cores(shares: SimpleQueue[set[int]]) -> None:
    """Keep a process to its share of the cores, so that simulators and networks start no threads beyond it."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, shares.get())


def shares_of_cores(processes: int) -> list[set[int]]:
    """Cores for each process; processes beyond the cores share them."""
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else [0]
    each = max(1, len(cores) // processes)
    return [{cores[(number * each + i) % len(cores)] for i in range(each)} for number in range(processes)]


def impossible(controller: AnyController, pipe: PipeCorner, overlap: float) -> bool:
    """Whether a pipe is proven impossible for all starts and targets, with an overlap of so much [m]."""
    model, task = Model(controller.robot, pipe, "plane", overlap), controller.task
    ends = Ends.of_task(model, task) if isinstance(task, ReachConfig) else None
    return certify(model, ends, RESOLUTION).kind == "impossible"


def proven(policy: str, angle: float) -> list[Proof]:
    """Proofs of one policy and angle [deg]: for rigid bodies, and with the overlap that the task allows."""
    controller, largest, proofs = open_controller(policy), WIDEST_MM, []
    narrowest = narrowest_mm(controller)
    for overlap in (0.0, controller.task.max_penetration):
        began = time.monotonic()
        largest = largest_impossible(controller, overlap, angle, (narrowest, largest))
        below = [largest - less for less in BELOW_MM if largest - less >= narrowest]
        bores: list[float] = []
        for bore in below:
            if impossible(controller, turned(bore, angle, len(bores)), overlap):
                bores.append(bore)
        proofs.append(Proof(policy, angle, overlap, bores, time.monotonic() - began))
    return proofs


def turned(bore: float, angle: float, number: int) -> PipeCorner:
    """A pipe of a bore [mm] and an angle [deg]; it turns left or right as its number is even or odd."""
    return PipeCorner.of(bore, angle, "right" if number % 2 else "left")


def largest_impossible(controller: AnyController, overlap: float, angle: float, bounds: tuple[float, float]) -> float:
    """Largest bore of an angle [deg] that is proven impossible, up to the step, below one that is not [mm]."""
    low, high = bounds
    while high - low > STEP_MM:
        middle = low + STEP_MM * round((high - low) / (2 * STEP_MM))
        if impossible(controller, turned(middle, angle, 0), overlap):
            low = middle
        else:
            high = middle
    return low


def narrowest_mm(controller: AnyController) -> float:
    """Smallest bore [mm] in which the robot fits at rest, or that a pipe may have."""
    bore = 40.0
    while True:
        try:
            check_fits(controller.robot, [PipeCorner.of(bore, 90)])
            return bore
        except PipenavError:
            bore += STEP_MM


def tried(proof: Proof, share: int, seed: int, backend: str) -> Trial:
    """The policy's episodes in pipes that are proven impossible, at least a share of so many."""
    began, controller, pipes = time.monotonic(), open_controller(proof.policy), proof.pipes()
    episodes = math.ceil(share / len(pipes))
    results = run_task(controller, pipes, episodes, seed, SimulatorSettings(backend, {}))
    passed = (results.outcome == Outcome.REACHED).reshape(len(pipes), episodes)
    sank = results.penetration.reshape(len(pipes), episodes)
    if proof.overlap:
        contradictions = int(passed.sum())
    else:
        contradictions = 0
        for pipe, through, deep in zip(pipes, passed, sank, strict=True):
            if through.any():
                least = float(np.min(deep[through])) + LEAST_OVERLAP
                contradictions += impossible(controller, pipe, least)
    tries = Count(len(pipes), passed.size, int(passed.sum()), contradictions)
    return Trial(tries, time.monotonic() - began)


if __name__ == "__main__":
    main()
