"""Stuck starts: poses in which a robot got stuck, drawn by random search and from failed episodes, as a set of starts.

In the random search a policy drives a robot into a corner, each in its pipe. At a random moment it is interrupted:
random actions, each held for a while, drive the robot until it is stuck: it has not advanced for 3 s, by a jam, slip,
limit or fold. `--failures` also takes the poses of failed episodes from folders of `pipenav eval`; their pipes must be
among those of the set. Joints press with the set-points that they had; those of failed episodes are at rest.

    python benchmarks/draw_stuck_starts.py --out pipes/starts/stuck-starts.json
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.simulators import open_simulator
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.failures import read_failures
from pipenav.evaluation.results import read_evaluation
from pipenav.evaluation.starts import PipeStarts, Start, StartSet
from pipenav.pipes.route_sets import parse_pipes
from pipenav.policies.named import open_controller
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.registry import task_of
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.episode import TraverseEpisodes

DIAMETERS, ANGLES = (70, 80, 90, 100, 110, 120), (55, 90, 125)
"""Bores [mm] and angles [deg] of the pipes, which turn left and right alternately."""

STUCK = {Outcome.JAM, Outcome.SLIP, Outcome.LIMIT, Outcome.FOLD}
"""Ends of episodes whose poses are starts."""

INTERRUPTED = (5, 70)
"""Control steps after which a policy is interrupted: until its robot is about through."""

PATIENCE = 20
"""Control steps without an advance, for a robot of full speed, after which random actions have got a robot stuck: 3 s
for `pirate`. The task waits five times as long for a policy, which may find a way out; random actions rarely do."""

SPARE = 1.25
"""Robots for each start that is wanted: some pass, sink into a wall or run out of time instead."""

HELD = (5, 60)
"""Control steps for which a random action is held."""


class Interrupter:
    """Random actions in place of a policy's, for n robots from a moment on.

    Args:
        n: number of robots.
        actions: number of values of an action.
        rng: source of randomness.
    """

    def __init__(self, n: int, actions: int, rng: np.random.Generator) -> None:
        self._rng = rng
        self._from, self._until = rng.integers(*INTERRUPTED, n), np.zeros(n, int)
        self._held = np.zeros((n, actions))

    def restart(self, rows: Ints) -> None:
        """Begin anew with some robots."""
        self._from[rows], self._until[rows] = self._rng.integers(*INTERRUPTED, len(rows)), 0

    def act(self, steps: Ints, wanted: Floats) -> Floats:
        """Actions at some ages of the episodes, (n, actions): the wanted ones, or random ones that are held."""
        interrupted = steps >= self._from
        renewed = np.flatnonzero(interrupted & (steps >= self._until))
        self._held[renewed] = self._rng.uniform(-1.0, 1.0, (len(renewed), self._held.shape[1]))
        self._until[renewed] = steps[renewed] + self._rng.integers(*HELD, len(renewed))
        return np.where(interrupted[:, None], self._held, wanted)


def searched(policy: str, names: list[str], each: int, seed: int, timestep: float) -> list[list[Start]]:
    """Starts found by random search, so many in each pipe, with this physics step [s]."""
    controller, rng = open_controller(policy, None, seed), np.random.default_rng(seed)
    config = controller.task.model_copy(update={"patience": PATIENCE})
    task, pipes, robot = task_of(config), parse_pipes(names), controller.robot
    robots, found = round(SPARE * each), [list[Start]() for _ in pipes]
    n = len(pipes) * robots

    def source(indices: Ints) -> TraverseEpisodes:
        return task.sample(robot, [pipes[i // robots] for i in indices], rng)

    simulator = open_simulator("mujoco", robot, n, {"timestep": timestep}, max(len(pipe.segments) for pipe in pipes))
    with closing(TraverseBatch(robot, config, simulator, n, source)) as batch:
        blunders = Interrupter(n, batch.action_size, rng)
        observation = batch.reset()
        while min(len(starts) for starts in found) < each:
            print(f"\r{sum(map(len, found))} of {len(pipes) * each} starts", end="", flush=True)
            step = batch.step(blunders.act(batch.steps, controller.act(observation)))
            observation = step.observation
            ended = np.flatnonzero(step.outcome != Outcome.RUNNING)
            for i in ended:
                if step.outcome[i] in STUCK and len(starts := found[i // robots]) < each:
                    starts.append(stuck_start(batch, int(i), Outcome(step.outcome[i])))
            if len(ended):
                blunders.restart(ended)
                observation = batch.reset(ended)
    print()
    return found


def stuck_start(batch: TraverseBatch, i: int, outcome: Outcome) -> Start:
    """The pose of a robot that is stuck, with the base in the pipe's frame."""
    q = batch.q[i]
    q[:2] = batch.points[i, 0]  # the base is the rear end
    press = batch.set_points[i] - batch.q[i, -batch.set_points.shape[1] :]
    return Start(stuck=outcome.label, q=rounded(q), press=rounded(press))


def rounded(values: Floats) -> tuple[float, ...]:
    return tuple(round(value, 5) for value in values.tolist())


def failed(folders: list[Path], names: list[str]) -> Iterator[tuple[int, Start]]:
    """Starts from failed episodes, with the number of the pipe that each is in."""
    at = {repr(pipe): number for number, pipe in enumerate(parse_pipes(names))}
    for folder in folders:
        plan = CheckedEvaluation(read_evaluation(folder).config).parts.episodes
        start_of = plan.numbered()
        for number, failure in (read_failures(folder) or {}).items():
            pipe = at.get(repr(plan.pipes[number // plan.episodes]))
            if pipe is None or failure.pose is None or failure.outcome not in {stuck.label for stuck in STUCK}:
                continue
            q = np.array(failure.pose.q)
            q[0] += float(start_of(number).base[0])
            yield pipe, Start(stuck=failure.outcome, q=rounded(q), press=(0.0,) * len(plan.robot.joints))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policy", default="pirate", help="policy that is interrupted")
    parser.add_argument("--each", type=int, default=12, help="starts in each pipe")
    parser.add_argument("--timestep", type=float, default=0.005, help="physics step of the search [s]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--failures", type=Path, nargs="*", default=[], help="evaluation folders with failures.json")
    parser.add_argument("--out", type=Path, required=True, help="set of starts, FILE.json")
    given = parser.parse_args()
    corners = [(d, angle) for d in DIAMETERS for angle in ANGLES]
    names = [f"d={d},angle={angle},turn={('left', 'right')[i % 2]}" for i, (d, angle) in enumerate(corners)]
    found = searched(given.policy, names, given.each, given.seed, given.timestep)
    real = list(failed(given.failures, names))
    for number, start in real:
        found[number] = [start, *found[number]]
    pipes = tuple(PipeStarts(pipe=name, starts=tuple(s[: given.each])) for name, s in zip(names, found, strict=True))
    drawn = f"random search with {given.policy}, seed {given.seed}; {len(real)} of failed episodes"
    starts = StartSet(schema=1, robot=open_controller(given.policy, None, 0).robot.name, drawn=drawn, pipes=pipes)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(starts.to_json())
    print(f"{given.out}: {len(pipes)} pipes x {starts.each} starts; {drawn}")


if __name__ == "__main__":
    main()
