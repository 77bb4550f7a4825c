"""Speed of robots in space, as ratios measured in one go: `python benchmarks/space.py`.

(a) bare physics: the same models in MuJoCo's Batch on all cores, nothing else
(b) the backend: sensors and truth as well
(c) the traverse task in space: pilots, outcomes and resets as well
(d) the same task in turns of two shares, as a training steps it

64 robots move in the 24 routes of `runs-rolled`, driven by the shipped policy `pirate-strong`, whose own time does not
count. In every control step (a) steps the states from which (b) and (c) went on, so that all three share the machine
alike. After some steps the robots of (d) repeat them, in the same episodes with the same actions and results.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"  # before numpy is imported; physics has the cores

import mujoco
import mujoco.batch
import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.simulators import open_space
from pipenav.backends.spatial import SpaceBackend, SpaceReading, SpaceTruth
from pipenav.envs.sb3_env import TaskVecEnv
from pipenav.pipes.route import PipeRoute
from pipenav.pipes.route_sets import parse_routes
from pipenav.policies.controller import actions_of
from pipenav.policies.named import open_controller
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.rolling.batch import RollingBatch
from pipenav.tasks.traverse.episode import TraverseEpisodes, sample

ROBOTS = 64

BLOCK = 20
"""Control steps after which the robots of (d) repeat them."""


class Timed(SpaceBackend):
    """A backend that knows how long its calls took, but for resets.

    Attributes:
        seconds: duration of all calls so far [s].
        before: state of the batch before the last step, with the commands of that step.
    """

    def __init__(self, inner: SpaceBackend) -> None:
        self.inner, self.seconds = inner, 0.0
        self.before = np.zeros(0)

    def incline(self, indices: Ints, gravity: Floats) -> None:
        self.inner.incline(indices, gravity)

    def reset(self, indices: Ints, routes: Sequence[PipeRoute], q: Floats, base: Floats, plane: Floats) -> SpaceReading:
        return self.inner.reset(indices, routes, q, base, plane)

    def pull(self, forces: Floats) -> None:
        self.inner.pull(forces)

    def step(self, set_points: Floats, roll: Floats) -> None:
        live: Any = self.inner._batch.views  # type: ignore[attr-defined]
        live.ctrl[:, :-1], live.ctrl[:, -1] = set_points, roll
        self.before = live.batch.state.copy()
        begin = time.perf_counter()
        self.inner.step(set_points, roll)
        self.seconds += time.perf_counter() - begin

    def read(self) -> SpaceReading:
        begin = time.perf_counter()
        reading = self.inner.read()
        self.seconds += time.perf_counter() - begin
        return reading

    def truth(self) -> SpaceTruth:
        begin = time.perf_counter()
        truth = self.inner.truth()
        self.seconds += time.perf_counter() - begin
        return truth

    def close(self) -> None:
        self.inner.close()


class Bare:
    """Physics alone of the robots of a backend: their models, states and commands in a batch of their own."""

    def __init__(self, backend: Any) -> None:
        self._live, self._batch = backend._batch, None

    def seconds(self, substeps: int, state: Floats) -> float:
        """Duration of a control period from a state [s]."""
        live = self._live.views.batch
        if self._batch is None or self._batch.nstate != live.nstate:
            self._batch = mujoco.batch.Batch(live.model, live.nsim, persistent=True)  # as the models' sleep asks for
        self._batch.set_models(live.models)
        self._batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)  # places the walls
        self._batch.state[:] = state
        begin = time.perf_counter()
        self._batch.rollout(substeps, record=())
        return time.perf_counter() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=300, help="control steps that are measured")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    arguments = parser.parse_args()
    measured = measure(arguments.steps)
    if arguments.json:
        print(json.dumps(measured))
    else:
        print("\n".join(f"{name:34} {value:g}" for name, value in measured.items()))


class InTurns:
    """The robots of (d): two shares that go through the episodes of another batch, with the same actions.

    Args:
        open_share: makes a share of n robots with the source of its episodes.
    """

    def __init__(self, open_share: Callable[[int, Callable[[Ints], TraverseEpisodes]], RollingBatch]) -> None:
        self._episodes = [deque[TraverseEpisodes]() for _ in range(ROBOTS)]
        half = ROBOTS // 2
        self.env = TaskVecEnv(*(open_share(half, lambda ids, first=i * half: self._next(ids + first)) for i in (0, 1)))

    def note(self, indices: Ints, episodes: TraverseEpisodes) -> None:
        """Take in the episodes that some robots begin."""
        for k, i in enumerate(indices):
            self._episodes[i].append(episodes.part(slice(k, k + 1)))

    def _next(self, indices: Ints) -> TraverseEpisodes:
        first, *rest = zip(*(self._episodes[i].popleft() for i in indices), strict=True)
        return TraverseEpisodes(sum(first, ()), *map(np.concatenate, rest))

    def seconds(self, actions: list[Floats], expected: Floats) -> float:
        """Time that the control steps with these actions take [s]; they end with the observations `expected`."""
        begin = time.perf_counter()
        for k in range(len(actions) + 1):
            steps = []
            for share in self.env.shares:
                if k:
                    steps.append(self.env.receive(share))
                if k < len(actions):
                    share.send(actions[k][share.rows])
        taken = time.perf_counter() - begin
        assert np.array_equal(np.concatenate([step.observation for step in steps]), expected.astype(np.float32))
        return taken


def measure(steps: int) -> dict[str, float]:
    """Rates of (a) to (d) and their ratios, by their names in the output."""
    controller, rng = open_controller("pirate-strong"), np.random.default_rng(0)
    robot, task, routes = controller.robot, controller.task, parse_routes(["runs-rolled"])
    drawn = iter(range(10**9))

    def source(indices: Ints) -> TraverseEpisodes:
        episodes = sample(robot, task, [routes[next(drawn) % len(routes)] for _ in indices], rng)
        in_turns.note(indices, episodes)
        return episodes

    in_turns = InTurns(lambda n, own: RollingBatch(robot, task, open_space("mujoco", robot, n, {}), n, own))
    backend = Timed(open_space("mujoco", robot, ROBOTS, {}))
    batch, bare = RollingBatch(robot, task, backend, ROBOTS, source), Bare(backend.inner)
    observation, rows, turns, told = batch.reset(), [], [], []
    in_turns.env.reset()
    substeps = backend.inner._settings.substeps  # type: ignore[attr-defined]
    for _ in range(steps):
        told.append(actions_of(controller, observation, batch))
        before, begin = backend.seconds, time.perf_counter()
        step = batch.step(told[-1])
        taken = time.perf_counter() - begin
        alone, begin = bare.seconds(substeps, backend.before), time.perf_counter()
        observation, ended = step.observation, np.flatnonzero(step.outcome != Outcome.RUNNING)
        if len(ended):
            observation = batch.reset(ended)
        rows.append((alone, backend.seconds - before, taken, taken + time.perf_counter() - begin))
        if len(told) == BLOCK:
            turns.append((sum(row[0] for row in rows[-BLOCK:]), in_turns.seconds(told, observation)))
            told = []
    batch.close()
    in_turns.env.close()
    return rates(np.array(rows[BLOCK:]), np.array(turns[1:]))


def rates(rows: Floats, turns: Floats) -> dict[str, float]:
    """What was measured, by its name in the output.

    Args:
        rows: duration of each control step in (a), (b), (c) and in (c) with its resets, (steps, 4) [s].
        turns: duration of each block of control steps in (a) and (d), (blocks, 2) [s].
    """
    a, b, c, _ = ROBOTS / np.median(rows, axis=0)
    return {
        "bare physics [control steps/s]": round(a),
        "backend [control steps/s]": round(b),
        "task [control steps/s]": round(c),
        "task in turns [control steps/s]": round(BLOCK * ROBOTS / np.median(turns[:, 1])),
        "b/a": round(b / a, 3),
        "c/a": round(c / a, 3),
        "c/a with all resets": round(rows[:, 0].sum() / rows[:, 3].sum(), 3),
        "d/a with all resets": round(float(np.median(turns[:, 0] / turns[:, 1])), 3),
    }


if __name__ == "__main__":
    main()
