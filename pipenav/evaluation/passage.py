"""The whole passage, stage by stage: locate a target, reach it with the policy, bring the rear half after.

Every stage runs over all episodes before the next one begins, and each takes up what the one before left: the front
starts at rest in the pose in which locating ended and goes for the target that was found; the rear starts in the
mirrored final pose of a successful front and plays the passage backwards (approach II).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.disturbances.disturbance import UNDISTURBED, Disturbance
from pipenav.disturbances.disturbed_backend import disturbed
from pipenav.evaluation.episode_runner import EpisodeQueue, EpisodeResults, joined, random_start, run_queue, run_stage
from pipenav.evaluation.locate_stage import LocateStage
from pipenav.evaluation.rear_stage import RearStage
from pipenav.evaluation.rolling_stage import space_stage
from pipenav.evaluation.stage import Stage, StageStep, TaskStage
from pipenav.locating.locator import LocateConfig, Variant, robot_for
from pipenav.motions.mirror import join, rear_motion
from pipenav.motions.trajectory import Motion
from pipenav.pipes.pipe import Pipe
from pipenav.policies.controller import Controller
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.episode import Episodes
from pipenav.tasks.registry import AnyTask, kind_of, reaching

Jobs = Ints
Progress = Callable[[str, int, int, int], None]
"""Called with the part that runs, its episodes, how many are done, and how many of those succeeded."""


class StageResult(NamedTuple):
    """What came of one stage.

    Attributes:
        jobs: the episodes that it was tried in, (k,).
        results: of these, in order.
        motions: their joint positions from the start to the end, k arrays (rows, joints); none of a rear.
        targets: the targets that were found, (k, 2) in the canonical frame; NaN where none was, and of other stages.
    """

    jobs: Jobs
    results: EpisodeResults
    motions: list[Floats]
    targets: Floats

    @property
    def passed(self) -> Flags:
        """Which of its episodes succeeded, (k,)."""
        return np.asarray(self.results.outcome == Outcome.REACHED)


class _Recorded(Stage):
    """A stage whose motions and found targets are kept, by episode."""

    def __init__(
        self, stage: Stage, queue: EpisodeQueue[Episodes], start: Callable[[int], Episodes], rows: int
    ) -> None:
        self.robot, self.n = stage.robot, stage.n
        self._stage, self._queue, self._start = stage, queue, start
        self._rows = np.zeros((stage.n, rows, stage.robot.coordinates))
        self.motions: dict[int, Floats] = {}
        self.targets: dict[int, Floats] = {}

    @property
    def steps(self) -> Ints:
        return self._stage.steps

    def start(self, indices: Ints) -> None:
        self._stage.start(indices)
        for robot in indices:
            self._rows[robot, 0] = self._start(max(int(self._queue.running[robot]), 0)).q[0]

    def step(self) -> StageStep:
        step = self._stage.step()
        # A robot without work is stepped on beyond its time; its rows are nobody's.
        count = np.minimum(self._stage.steps, self._rows.shape[1] - 1)
        self._rows[np.arange(self.n), count] = step.q
        for robot in np.flatnonzero(step.outcome != Outcome.RUNNING):
            job = int(self._queue.running[robot])
            self.motions.setdefault(job, self._rows[robot, : count[robot] + 1].copy())
            if isinstance(self._stage, LocateStage):
                self.targets.setdefault(job, self._stage.target[robot].copy())
        return step

    def close(self) -> None:
        self._stage.close()


class Passages:
    """Runs stages over the same episodes of the same pipes.

    Args:
        robot: the robot.
        task: the front's or the traverse's; its starts and time limits hold for every stage.
        pipes: where.
        episodes: in each pipe.
        seed: of starts and, where none is located, of targets.
        backend: name of a simulator backend.
        options: the backend's own settings.
        progress: see `Progress`.
        disturbance: what goes wrong, drawn anew in every stage.
    """

    def __init__(
        self,
        robot: RobotSpec,
        task: AnyTask,
        pipes: Sequence[Pipe],
        episodes: int,
        seed: int,
        backend: str = "mujoco",
        options: dict[str, Any] | None = None,
        progress: Progress = lambda _part, _total, _done, _successes: None,
        disturbance: Disturbance = UNDISTURBED,
    ) -> None:
        self._robot, self._task, self._seed, self._disturbance = robot, task, seed, disturbance
        self._kind = kind_of(task)
        self._pipes = [pipe for pipe in pipes for _ in range(episodes)]
        self._given = random_start(robot, disturbance.starts(task), pipes, episodes, seed)
        self._backend, self._options, self._progress = backend, dict(options or {}), progress

    def locate(self, variant: Variant = "map") -> StageResult:
        """Approach I in every episode."""
        robot, config, task = robot_for(self._robot, variant), LocateConfig(), reaching(self._task, "locating a target")

        def make(simulator: Simulator, queue: EpisodeQueue[Episodes]) -> Stage:
            n = len(queue.running)
            return LocateStage(robot, config, variant, task, simulator, n, lambda r: joined(queue.take(r)))

        return self._run("locating", make, robot, np.arange(len(self._pipes)), self._given)

    def task(self, controller: Controller, located: StageResult | None = None) -> StageResult:
        """The task, a front passage or a traverse, in every episode, or in those where a target was located."""
        jobs = np.arange(len(self._pipes)) if located is None else located.jobs[located.passed]
        rolled = np.array([(not self._pipes[job].planar) for job in jobs], bool)
        if rolled.any():
            return self._with_space(controller, jobs[~rolled], jobs[rolled])
        start = self._given
        if located is not None:
            found = {int(job): k for k, job in enumerate(located.jobs)}

            def start(job: int) -> Episodes:
                k = found[job]
                given: Episodes = self._given(job)
                return given._replace(q=located.results.q[k : k + 1], target=located.targets[k : k + 1])

        return self._run(self._kind.stage, self._make(controller), self._robot, jobs, start)

    def _with_space(self, controller: Controller, flat: Jobs, rolled: Jobs) -> StageResult:
        """The task in pipes of which some leave the plane; nothing comes after it, so no motions are kept."""
        jobs = np.sort(np.concatenate([flat, rolled]))
        results = EpisodeResults.empty(len(jobs), self._robot)
        if len(flat):
            name = self._kind.stage
            results.put(
                np.searchsorted(jobs, flat),
                self._run(name, self._make(controller), self._robot, flat, self._given).results,
            )
        in_space = run_queue(
            lambda queue: space_stage(controller, self._backend, self._options, queue),
            lambda i: self._given(int(rolled[i])),
            len(rolled),
            min(len(rolled), os.cpu_count() or 1),  # a few: episodes are long, and the last one keeps all robots busy
            lambda done, successes: self._progress(f"{self._kind.stage} in space", len(rolled), done, successes),
        )
        results.put(np.searchsorted(jobs, rolled), in_space)
        return StageResult(jobs, results, [], np.full((len(jobs), 2), np.nan))

    def _make(self, controller: Controller) -> Callable[[Simulator, EpisodeQueue[Any]], Stage]:
        def make(simulator: Simulator, queue: EpisodeQueue[Any]) -> Stage:
            n = len(queue.running)
            batch = self._kind.batch(self._robot, self._task, simulator, n, lambda r: joined(queue.take(r)))
            return TaskStage(batch, controller)

        return make

    def rear(self, front: StageResult, located: StageResult | None = None) -> StageResult:
        """The rear half after every successful front."""
        task = reaching(self._task, "the rear half's passage")
        jobs = front.jobs[front.passed]
        before = {int(job): k for k, job in enumerate(located.jobs)} if located is not None else {}
        motions = {}
        for k in np.flatnonzero(front.passed):
            job = int(front.jobs[k])
            parts = [front.motions[k]] if located is None else [located.motions[before[job]], front.motions[k]]
            base = float(self._given(job).base[0])
            whole = join([Motion(self._pipes[job].require_corner(), base, rows) for rows in parts])
            motions[job] = rear_motion(self._robot, whole)

        def make(simulator: Simulator, queue: EpisodeQueue[Motion]) -> Stage:
            n = len(queue.running)
            return RearStage(self._robot, self._disturbed(simulator, n), n, queue.take, task)

        if not len(jobs):
            return _nothing(self._robot)
        results = run_stage(
            make,
            self._robot,
            lambda i: motions[int(jobs[i])],
            [motions[int(job)].pipe for job in jobs],
            self._backend,
            self._options,
            lambda done, successes: self._progress("rear", len(jobs), done, successes),
        )
        return StageResult(jobs, results, [], np.full((len(jobs), 2), np.nan))

    def _disturbed(self, simulator: Simulator, n: int) -> Simulator:
        return disturbed(simulator, self._robot, n, self._disturbance, self._seed)

    def _run(
        self,
        name: str,
        make: Callable[[Simulator, EpisodeQueue[Episodes]], Stage],
        robot: RobotSpec,
        jobs: Jobs,
        start: Callable[[int], Episodes],
    ) -> StageResult:
        if not len(jobs):
            return _nothing(robot)
        recorded: list[_Recorded] = []
        pipes = [self._pipes[job] for job in jobs]
        most_steps = self._task.max_steps * max(len(pipe.interior_angles) for pipe in pipes)

        def begin(i: int) -> Episodes:
            return start(int(jobs[i]))

        def make_recorded(simulator: Simulator, queue: EpisodeQueue[Episodes]) -> Stage:
            stage = make(self._disturbed(simulator, len(queue.running)), queue)
            recorded.append(_Recorded(stage, queue, begin, most_steps + 1))
            return recorded[0]

        results = run_stage(
            make_recorded,
            robot,
            begin,
            pipes,
            self._backend,
            self._options,
            lambda done, successes: self._progress(name, len(jobs), done, successes),
        )
        (kept,) = recorded
        targets = [kept.targets.get(i, np.full(2, np.nan)) for i in range(len(jobs))]
        return StageResult(jobs, results, [kept.motions[i] for i in range(len(jobs))], np.reshape(targets, (-1, 2)))


def _nothing(robot: RobotSpec) -> StageResult:
    """The part of a stage that no episode came to."""
    none = np.zeros(0)
    results = EpisodeResults(
        none.astype(np.int8), none.astype(np.intp), none, none, none, none, np.zeros((0, robot.coordinates))
    )
    return StageResult(none.astype(np.intp), results, [], np.zeros((0, 2)))


def run_task(
    controller: Controller,
    pipes: Sequence[Pipe],
    episodes: int,
    seed: int,
    backend: str = "mujoco",
    options: dict[str, Any] | None = None,
    disturbance: Disturbance = UNDISTURBED,
) -> EpisodeResults:
    """The controller's task alone, a front passage to a given target or a traverse: see `Passages`."""
    robot, task = controller.robot, controller.task
    runs = Passages(robot, task, pipes, episodes, seed, backend, options, disturbance=disturbance)
    return runs.task(controller).results
