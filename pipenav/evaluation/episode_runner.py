"""Many episodes of one stage in many pipes, and their results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.simulators import DEFAULT_SIMULATOR, SimulatorSettings
from pipenav.evaluation.stage import Stage, StageStep
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.registry import TaskConfig, task_of
from pipenav.tasks.traverse.episode import TraverseEpisodes
from pipenav.units import m_to_mm, rad_to_deg

Episode = TypeVar("Episode")
"""The start of a stage's episode: a task's episodes of k = 1, or a motion to replay."""

ReportEpisodes = Callable[[int, int], None]
"""Called with the episodes that are done and how many of those succeeded."""

Starting = TypeVar("Starting", ReachEpisodes, TraverseEpisodes)

MAX_ROBOTS = 256
"""Robots stepped together: enough to keep every core busy, few enough that the last ones to finish cost little."""

EPISODES_PER_ROBOT = 4
"""Episodes for each robot: with fewer, most robots would wait for the last ones, whose episodes may be ten times longer
than the mean."""


class EpisodeResults(NamedTuple):
    """Results of episodes, in order: all episodes of the first pipe, then of the next.

    Attributes:
        outcome: how each episode ended, an `Outcome` each, (k,).
        steps: control steps, (k,).
        min_range: smallest laser reading, (k,) [m].
        penetration: deepest overlap with the wall, (k,) [m].
        force: peak contact force, (k,) [N].
        contact_share: share of the time in contact, (k,).
        q: configurations at the end, in the robot's own frame, (k, coordinates) [m, rad].
    """

    outcome: NDArray[np.int8]
    steps: Ints
    min_range: Floats
    penetration: Floats
    force: Floats
    contact_share: Floats
    q: Floats

    def put(self, jobs: Ints, part: EpisodeResults) -> None:
        """Overwrite the results of k episodes by `part`."""
        for column, rows in zip(self, part, strict=True):
            np.asarray(column)[jobs] = rows

    @classmethod
    def empty(cls, total: int, robot: RobotSpec) -> EpisodeResults:
        """Room for the results of so many episodes."""
        min_range, penetration, force, contact_share = np.zeros((4, total))
        outcome, steps, q = np.zeros(total, np.int8), np.zeros(total, np.intp), np.zeros((total, robot.coordinates))
        return cls(outcome, steps, min_range, penetration, force, contact_share, q)

    def select(self, wanted: Flags) -> EpisodeResults:
        """Results of the episodes that are marked, (k,)."""
        return EpisodeResults(*(column[wanted] for column in self))  # type: ignore[arg-type]  # every column alike


class EpisodeQueue(Generic[Episode]):
    """Hands out episodes one after another and remembers which of them each robot runs.

    Args:
        start: gives an episode by its number, the same one whenever it is asked.
        total: number of episodes.
        n: number of robots that share them.
    """

    def __init__(self, start: Callable[[int], Episode], total: int, n: int) -> None:
        self._start, self.total = start, total
        self._next = 0
        self.running = np.full(n, -1)

    def take(self, indices: Ints) -> list[Episode]:
        """The next episode of each of these robots."""
        started = []
        for robot in indices:
            job = self._next if self._next < self.total else -1
            self._next += 1
            self.running[robot] = job
            started.append(self._start(max(job, 0)))  # a robot without work repeats episode 0, which is not counted
        return started


def joined(parts: Sequence[Starting]) -> Starting:
    """Several episodes of a task as one, in order."""
    pipes, *arrays = zip(*parts, strict=True)
    return type(parts[0])(tuple(pipe for (pipe,) in pipes), *map(np.concatenate, arrays))


def random_start(
    robot: RobotSpec, task: TaskConfig, pipes: Sequence[Pipe], episodes: int, seed: int
) -> Callable[[int], Any]:
    """Episodes by number: all of the first pipe, then of the next.

    Start and target of an episode depend on the seed, the pipe and the episode's number in it alone, so that results
    do not depend on how many robots run at once, nor on the other pipes of the set.

    Raises:
        PipenavError: a pipe that is too narrow for the robot at rest.
    """
    episode.check_fits(robot, pipes)

    def start(job: int) -> Any:
        pipe, number = pipes[job // episodes], job % episodes
        numbers = [round(m_to_mm(pipe.diameter) * 1e3)]
        for angle, turn_sign in zip(pipe.interior_angles.tolist(), pipe.turn_signs.tolist(), strict=True):
            numbers += [round(rad_to_deg(angle) * 1e3), int(turn_sign > 0)]
        rng = np.random.default_rng([seed, *numbers, number])
        return task_of(task).sample(robot, [pipe], rng)

    return start


def robots_for(total: int) -> int:
    """Number of robots that share `total` episodes."""
    return min(MAX_ROBOTS, max(1, total // EPISODES_PER_ROBOT))


def run_stage(
    make: Callable[[Simulator, EpisodeQueue[Episode]], Stage],
    robot: RobotSpec,
    start: Callable[[int], Episode],
    pipes: Sequence[Pipe],
    simulator: SimulatorSettings = DEFAULT_SIMULATOR,
    report_progress: ReportEpisodes | None = None,
) -> EpisodeResults:
    """Run every episode of a stage once.

    Args:
        make: the stage, from a backend and the queue of its episodes; it has as many robots as the queue.
        robot: the robot.
        start: gives an episode by its number.
        pipes: the pipe of every episode.
        simulator: the simulator.
        report_progress: called with (episodes done, successes so far) now and then.
    """
    segments = max(len(pipe.segments) for pipe in pipes)

    def make_in_plane(queue: EpisodeQueue[Episode]) -> Stage:
        return make(simulator.open(robot, len(queue.running), segments), queue)

    return run_queue(make_in_plane, start, len(pipes), robots_for(len(pipes)), report_progress)


def run_queue(
    make: Callable[[EpisodeQueue[Episode]], Stage],
    start: Callable[[int], Episode],
    total: int,
    n: int,
    report_progress: ReportEpisodes | None = None,
) -> EpisodeResults:
    """Run every episode of a stage once, where the stage brings its own simulator.

    Args:
        make: the stage, from the queue of its episodes.
        start: gives an episode by its number.
        total: number of episodes.
        n: number of robots that share them.
        report_progress: called with (episodes done, successes so far) now and then.
    """
    queue = EpisodeQueue(start, total, n)
    with closing(make(queue)) as stage:
        return drain(stage, queue, report_progress)


class _Peaks:
    """Extremes of each robot's running episode."""

    def __init__(self, n: int) -> None:
        self.min_range, self.penetration = np.full(n, np.inf), np.zeros(n)
        self.force, self.contact_steps = np.zeros(n), np.zeros(n)

    def add(self, step: StageStep) -> None:
        self.min_range = np.minimum(self.min_range, step.min_range)
        # A world that blew up has an infinite overlap, which fails the episode; its sizes say nothing.
        known = np.isfinite(step.truth.penetration) & np.isfinite(step.truth.contact_force)
        self.penetration = np.maximum(self.penetration, np.where(known, step.truth.penetration, 0.0))
        self.force = np.maximum(self.force, np.where(known, step.truth.contact_force, 0.0))
        self.contact_steps = self.contact_steps + step.truth.contact_share

    def forget(self, indices: Ints) -> None:
        self.min_range[indices], self.penetration[indices] = np.inf, 0.0
        self.force[indices], self.contact_steps[indices] = 0.0, 0.0


def drain(stage: Stage, queue: EpisodeQueue[Episode], report_progress: ReportEpisodes | None = None) -> EpisodeResults:
    """Step until every episode of the queue, which is the stage's source, has ended."""
    total = queue.total
    results = EpisodeResults.empty(total, stage.robot)
    peaks = _Peaks(stage.n)
    stage.start(np.arange(stage.n))
    finished = 0
    while finished < total:
        step = stage.step()
        peaks.add(step)
        ended = np.flatnonzero(step.outcome != Outcome.RUNNING)
        if not len(ended):
            continue
        counted = ended[queue.running[ended] >= 0]
        jobs = queue.running[counted]
        results.outcome[jobs], results.steps[jobs] = step.outcome[counted], stage.steps[counted]
        results.min_range[jobs], results.penetration[jobs] = peaks.min_range[counted], peaks.penetration[counted]
        results.force[jobs], results.q[jobs] = peaks.force[counted], step.q[counted]
        results.contact_share[jobs] = peaks.contact_steps[counted] / stage.steps[counted]
        finished += len(counted)
        peaks.forget(ended)
        if report_progress is not None:
            report_progress(finished, int((results.outcome == Outcome.REACHED).sum()))
        if finished < total:
            stage.start(ended)
    return results
