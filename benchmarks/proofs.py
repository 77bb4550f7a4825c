"""Policies against proofs: `python benchmarks/proofs.py --episodes 10000`.

For each policy and angle, pipes just below the frontier are proven impossible by `pipenav.certify`, once for rigid
bodies and once with the overlap that the task allows, and the policy tries to pass them in a simulator.

- A success in a pipe that is proven impossible with the overlap contradicts the proof: none may occur.
- In a pipe that is proven impossible for rigid bodies alone, soft contacts may let a robot pass. The success with the
  least overlap of each pipe is held against a proof with just that overlap: if there is one, it is a contradiction.

Ends with exit code 1 where there was a contradiction.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterator, Sequence
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

POLICIES = ("arm", "real-setup", "high-fidelity", "pirate")
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=10_000, help="episodes of all policies together")
    parser.add_argument("--policies", nargs="+", default=POLICIES, help="shipped policies or files")
    parser.add_argument("--angles", nargs="+", type=float, default=ANGLES_DEG, help="interior angles [deg]")
    parser.add_argument("--backend", default="mujoco", help="the simulator")
    parser.add_argument("--seed", type=int, default=0, help="seed of starts and targets")
    given = parser.parse_args()
    share = given.episodes / (2 * len(given.policies) * len(given.angles))
    every = []
    print(
        "policy           proof          angle  bores [mm]     episodes  successes  contradictions  time [s]",
        flush=True,
    )
    for name in given.policies:
        controller = open_controller(name)
        for angle in given.angles:
            largest = WIDEST_MM
            for overlap in (0.0, controller.task.max_penetration):
                began = time.monotonic()
                largest = largest_impossible(controller, overlap, angle, largest)
                pipes = list(impossible_pipes(controller, overlap, angle, largest))
                if not pipes:
                    continue
                each = math.ceil(share / len(pipes))
                found = tried(controller, pipes, each, given.seed, overlap, SimulatorSettings(given.backend, {}))
                every.append(found)
                bores = f"{m_to_mm(pipes[-1].diameter):.1f}-{m_to_mm(pipes[0].diameter):.1f}"
                proof = f"{m_to_mm(overlap):g} mm overlap" if overlap else "rigid"
                print(
                    f"{name:16} {proof:14} {angle:5g}  {bores:13} {found.episodes:9,} {found.successes:10,} "
                    f"{found.contradictions:15,} {time.monotonic() - began:9.0f}",
                    flush=True,
                )
    total = Count(*map(sum, zip(*every, strict=True)))
    most = 100 * wilson(total.contradictions, total.episodes).high
    print(
        f"{total.episodes:,} episodes in {total.pipes} pipes: {total.successes:,} successes, "
        f"{total.contradictions:,} contradictions (at most {most:.3f} % of the episodes, 95 % interval)"
    )
    sys.exit(1 if total.contradictions else 0)


def impossible(controller: AnyController, pipe: PipeCorner, overlap: float) -> bool:
    """Whether a pipe is proven impossible for all starts and targets, with an overlap of so much [m]."""
    model, task = Model(controller.robot, pipe, "plane", overlap), controller.task
    ends = Ends.of_task(model, task) if isinstance(task, ReachConfig) else None
    return certify(model, ends, RESOLUTION).kind == "impossible"


def largest_impossible(controller: AnyController, overlap: float, angle: float, high: float) -> float:
    """Largest bore of an angle [deg] that is proven impossible, up to the step, below one that is not [mm]."""
    low = narrowest_mm(controller)
    while high - low > STEP_MM:
        middle = low + STEP_MM * round((high - low) / (2 * STEP_MM))
        if impossible(controller, PipeCorner.of(middle, angle), overlap):
            low = middle
        else:
            high = middle
    return low


def impossible_pipes(controller: AnyController, overlap: float, angle: float, largest: float) -> Iterator[PipeCorner]:
    """Pipes of an angle [deg] below the frontier, widest first, turns in alternation, each proven impossible."""
    for number, below in enumerate(BELOW_MM):
        if largest - below >= narrowest_mm(controller):
            pipe = PipeCorner.of(largest - below, angle, "right" if number % 2 else "left")
            if impossible(controller, pipe, overlap):
                yield pipe


def narrowest_mm(controller: AnyController) -> float:
    """Smallest bore [mm] in which the robot fits at rest, or that a pipe may have."""
    bore = 40.0
    while True:
        try:
            check_fits(controller.robot, [PipeCorner.of(bore, 90)])
            return bore
        except PipenavError:
            bore += STEP_MM


def tried(
    controller: AnyController,
    pipes: Sequence[PipeCorner],
    episodes: int,
    seed: int,
    overlap: float,
    simulator: SimulatorSettings,
) -> Count:
    """The policy's episodes in pipes that are proven impossible."""
    results = run_task(controller, pipes, episodes, seed, simulator)
    passed = (results.outcome == Outcome.REACHED).reshape(len(pipes), episodes)
    sank = results.penetration.reshape(len(pipes), episodes)
    if overlap:
        contradictions = int(passed.sum())
    else:
        contradictions = 0
        for pipe, through, deep in zip(pipes, passed, sank, strict=True):
            if through.any():
                least = float(np.min(deep[through])) + LEAST_OVERLAP
                contradictions += impossible(controller, pipe, least)
    return Count(len(pipes), passed.size, int(passed.sum()), contradictions)


if __name__ == "__main__":
    main()
