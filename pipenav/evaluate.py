"""Many episodes of one controller in many pipes, and what came of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.batch import CornerBatch, StepResult
from pipenav.controller import Controller
from pipenav.pipe import Pipe
from pipenav.records import Evaluation, PipeRecord
from pipenav.registry import open_backend
from pipenav.robot import RobotSpec
from pipenav.task import episode
from pipenav.task.config import TaskConfig
from pipenav.task.episode import Episodes, Verdict
from pipenav.thesis import thesis_best
from pipenav.units import m_to_mm, rad_to_deg

Array = NDArray[np.float64]

MAX_ROBOTS = 256
"""Robots stepped together: enough to keep every core busy, few enough that the last ones to finish cost little."""

EPISODES_PER_ROBOT = 4
"""With fewer each, most robots would wait for the last ones, whose episodes may be ten times longer than the mean."""


class EpisodeResults(NamedTuple):
    """One entry per episode, in order: all episodes of the first pipe, then of the next.

    Attributes:
        verdict: a `Verdict` each, (k,).
        steps: control steps, (k,).
        clearance: smallest laser reading, (k,) [m].
        penetration: deepest overlap with the wall, (k,) [m].
        force: peak contact force, (k,) [N].
        contact_share: share of the time in contact, (k,).
    """

    verdict: NDArray[np.int8]
    steps: NDArray[np.intp]
    clearance: Array
    penetration: Array
    force: Array
    contact_share: Array

    def part(self, start: int, stop: int) -> EpisodeResults:
        """The episodes from `start` to before `stop`."""
        numbers = (self.clearance, self.penetration, self.force, self.contact_share)
        return EpisodeResults(
            self.verdict[start:stop], self.steps[start:stop], *(column[start:stop] for column in numbers)
        )


class _Queue:
    """Hands out the episodes of all pipes one after another and remembers which robot runs which.

    Start and target of an episode depend on the seed, the pipe and the episode's number alone, so that results do not
    depend on how many robots run at once, nor on the other pipes of the set.
    """

    def __init__(
        self, robot: RobotSpec, task: TaskConfig, pipes: Sequence[Pipe], episodes: int, seed: int, n: int
    ) -> None:
        self._robot, self._task = robot, task
        self._pipes, self._episodes, self._seed = pipes, episodes, seed
        self.total = len(pipes) * episodes
        self._next = 0
        self.running = np.full(n, -1)

    def source(self, robots: NDArray[np.intp]) -> Episodes:
        started = []
        for robot in robots:
            job = self._next if self._next < self.total else -1
            self._next += 1
            self.running[robot] = job
            started.append(self._start(max(job, 0)))  # a robot without work repeats episode 0, which is not counted
        return _joined(started)

    def _start(self, job: int) -> Episodes:
        pipe, number = self._pipes[job // self._episodes], job % self._episodes
        diameter, angle = round(m_to_mm(pipe.diameter) * 1e3), round(rad_to_deg(pipe.angle) * 1e3)
        rng = np.random.default_rng([self._seed, diameter, angle, int(pipe.side > 0), number])
        return episode.sample(self._robot, self._task, [pipe], rng)


def _joined(parts: list[Episodes]) -> Episodes:
    arrays = [np.concatenate([part[i] for part in parts]) for i in range(1, len(Episodes._fields))]
    return Episodes(tuple(part.pipes[0] for part in parts), *arrays)


def run_episodes(
    controller: Controller,
    pipes: Sequence[Pipe],
    episodes: int,
    seed: int,
    backend: str = "mujoco",
    options: dict[str, Any] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> EpisodeResults:
    """Run `episodes` episodes in every pipe.

    Args:
        controller: what acts.
        pipes: where.
        episodes: per pipe.
        seed: of starts and targets.
        backend: name of a simulator backend.
        options: the backend's own settings.
        progress: called with (episodes done, successes so far) now and then.
    """
    robot, task = controller.robot, controller.task
    total = len(pipes) * episodes
    n = min(MAX_ROBOTS, max(1, total // EPISODES_PER_ROBOT))
    segments = max(len(pipe.segments) for pipe in pipes)
    queue = _Queue(robot, task, pipes, episodes, seed, n)
    batch = CornerBatch(robot, task, open_backend(backend, robot, n, options or {}, segments), n, queue.source)
    try:
        return _drain(batch, queue, controller, progress)
    finally:
        batch.close()


class _Peaks:
    """What has been seen of each robot's running episode."""

    def __init__(self, n: int) -> None:
        self.clearance, self.penetration = np.full(n, np.inf), np.zeros(n)
        self.force, self.contact_steps = np.zeros(n), np.zeros(n)

    def add(self, step: StepResult) -> None:
        self.clearance = np.minimum(self.clearance, step.clearance)
        self.penetration = np.maximum(self.penetration, step.truth.penetration)
        self.force = np.maximum(self.force, step.truth.contact_force)
        self.contact_steps = self.contact_steps + step.truth.contact_share

    def forget(self, robots: NDArray[np.intp]) -> None:
        self.clearance[robots], self.penetration[robots] = np.inf, 0.0
        self.force[robots], self.contact_steps[robots] = 0.0, 0.0


def _drain(
    batch: CornerBatch, queue: _Queue, controller: Controller, progress: Callable[[int, int], None] | None
) -> EpisodeResults:
    """Step until every episode has ended."""
    total = queue.total
    results = EpisodeResults(np.zeros(total, np.int8), np.zeros(total, np.intp), *(np.zeros(total) for _ in range(4)))
    peaks = _Peaks(batch.n)
    observation = batch.reset()
    finished = 0
    while finished < total:
        step = batch.step(controller.act(observation, batch))
        observation = step.observation
        peaks.add(step)
        ended = np.flatnonzero(step.verdict != Verdict.RUNNING)
        if not len(ended):
            continue
        counted = ended[queue.running[ended] >= 0]
        jobs = queue.running[counted]
        results.verdict[jobs], results.steps[jobs] = step.verdict[counted], batch.steps[counted]
        results.clearance[jobs], results.penetration[jobs] = peaks.clearance[counted], peaks.penetration[counted]
        results.force[jobs] = peaks.force[counted]
        results.contact_share[jobs] = peaks.contact_steps[counted] / batch.steps[counted]
        finished += len(counted)
        peaks.forget(ended)
        if progress is not None:
            progress(finished, int((results.verdict == Verdict.REACHED).sum()))
        if finished < total:
            observation = batch.reset(ended)
    return results


def summarise(
    results: EpisodeResults,
    pipes: Sequence[Pipe],
    episodes: int,
    policy: str,
    backend: str,
    controller: Controller,
    seed: int,
    options: dict[str, Any],
) -> Evaluation:
    """The results per pipe, per diameter and over all, as `eval.json` holds them."""
    records = [_pipe_record(pipe, results.part(i * episodes, (i + 1) * episodes)) for i, pipe in enumerate(pipes)]
    return Evaluation.of(
        records,
        policy=policy,
        backend=backend,
        robot=controller.robot.name,
        stage="front",
        seed=seed,
        episodes_per_pipe=episodes,
        penetration_p99_m=float(np.percentile(results.penetration, 99)),
        options=options,
        thesis=thesis_best(controller.task.control, controller.robot.name),
    )


def _pipe_record(pipe: Pipe, results: EpisodeResults) -> PipeRecord:
    reached = results.verdict == Verdict.REACHED
    verdicts, counts = np.unique(results.verdict[~reached], return_counts=True)
    return PipeRecord(
        diameter_mm=round(m_to_mm(pipe.diameter), 6),
        angle_deg=round(rad_to_deg(pipe.angle), 6),
        turn=pipe.turn,
        episodes=len(reached),
        front_attempts=len(reached),
        front_successes=int(reached.sum()),
        failures={Verdict(v).label: int(c) for v, c in zip(verdicts, counts, strict=True)},
        mean_steps=float(results.steps[reached].mean()) if reached.any() else None,
        min_clearance_m=float(results.clearance.min()),
        max_penetration_m=float(results.penetration.max()),
        peak_force_n=float(results.force.max()),
        contact_time_share=float(results.contact_share.mean()),
    )
