"""The whole passage, stage by stage: locate a target, reach it with the policy, bring the rear half after.

Every stage runs over all episodes before the next one begins, and starts where the one before ended: reaching
starts at rest in the pose in which locating ended and goes for the target that was found; the rear starts in the
mirrored final pose of a successful front half and plays the passage backwards (approach II).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.simulators import DEFAULT_SIMULATOR, SimulatorSettings
from pipenav.disturbances.disturbance import UNDISTURBED, Disturbance
from pipenav.disturbances.disturbed_backend import disturbed
from pipenav.evaluation.audit import Auditor
from pipenav.evaluation.episode_runner import (
    EpisodeQueue,
    EpisodeResults,
    joined,
    random_start,
    robots_for,
    run_queue,
    run_stage,
)
from pipenav.evaluation.locate_stage import LocateStage
from pipenav.evaluation.rear_stage import RearStage
from pipenav.evaluation.recorded_stage import RecordedStage
from pipenav.evaluation.rolling_stage import rolling_stage
from pipenav.evaluation.stage import Stage, TaskStage, gentle
from pipenav.evaluation.starts import PipeStarts
from pipenav.locating.locator import LocateConfig, Variant, robot_for
from pipenav.locating.variants import LOCATORS
from pipenav.motions.mirror import join, rear_motion
from pipenav.motions.trajectory import Motion
from pipenav.pipes.pipe import Pipe
from pipenav.policies.controller import AnyController
from pipenav.processes.cores import usable_cores
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome, PassageStage
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.registry import TaskConfig, require_reach, task_of

ReportProgress = Callable[[str, int, int, int], None]
"""Called with the stage that runs, its episodes, how many are done, and how many of those succeeded."""

MakeStage = Callable[[Simulator, EpisodeQueue[Any]], Stage]
"""Makes a stage on a simulator, with as many robots as the queue that is its source."""


def report_nothing(_stage: str, _total: int, _done: int, _successes: int) -> None:
    """A `ReportProgress` that reports to nobody."""


@dataclass(frozen=True)
class EpisodePlan:
    """The episodes of an evaluation, and the simulator that they run on.

    Attributes:
        robot: the robot.
        task: settings of the reach or the traverse task; its starts and time limits hold for every stage.
        pipes: the pipes.
        episodes: number of episodes in each pipe.
        seed: seed of starts and, where none is located, of targets.
        simulator: the simulator.
        disturbance: disturbances, drawn anew in every stage.
        max_force: contact force on any one link beyond which an episode fails [N]; None for no limit.
        first: number of the first episode, where the first pipe begins with a later one than 0.
        count: number of episodes in all; None for as many as the pipes have.
        starts: starts of the episodes in each pipe, as many as episodes; none where they are drawn from the seed.
        chosen: numbers of the episodes where only some are run, in order; None for all of them.
    """

    robot: RobotSpec
    task: TaskConfig
    pipes: Sequence[Pipe]
    episodes: int
    seed: int
    simulator: SimulatorSettings = DEFAULT_SIMULATOR
    disturbance: Disturbance = UNDISTURBED
    max_force: float | None = None
    first: int = 0
    count: int | None = None
    starts: tuple[PipeStarts, ...] = ()
    chosen: Sequence[int] | None = None

    @property
    def numbers(self) -> Sequence[int]:
        """Numbers of the episodes, of which the first pipe has those from 0, the next one those after."""
        if self.chosen is not None:
            return self.chosen
        return range(self.first, len(self.pipes) * self.episodes if self.count is None else self.first + self.count)

    def numbered(self) -> Callable[[int], Any]:
        """Function that gives an episode by its number in the plan."""
        task, starts = self.disturbance.starts(self.task), self.starts
        drawn = random_start(self.robot, task, self.pipes, each := self.episodes, self.seed)
        return (lambda job: starts[job // each].starts[job % each].put(drawn(job))) if starts else drawn

    def on(self, simulator: SimulatorSettings) -> EpisodePlan:
        """The same episodes on another simulator."""
        return replace(self, simulator=simulator)


class StageResult(NamedTuple):
    """Results of one stage.

    Attributes:
        jobs: numbers of the episodes that the stage was tried in, (k,).
        results: results of these episodes, in order.
        motions: joint positions from the start to the end of each episode, k arrays (rows, joints); none for a rear,
            and where nobody asked for them.
        targets: the targets that were found, (k, 2) in the canonical frame; NaN where none was, and for other stages.
    """

    jobs: Ints
    results: EpisodeResults
    motions: list[Floats]
    targets: Floats

    @classmethod
    def without_motions(cls, jobs: Ints, results: EpisodeResults) -> StageResult:
        """The result of a stage after which nothing comes."""
        return cls(jobs, results, [], np.full((len(jobs), 2), np.nan))

    @property
    def passed(self) -> Flags:
        """Whether each of the stage's episodes succeeded, (k,)."""
        return np.asarray(self.results.outcome == Outcome.REACHED)


class Passages:
    """Runs stages over the same episodes of the same pipes.

    Args:
        plan: the episodes.
        report_progress: see `ReportProgress`.
        keep_motions: whether results have the motions, which the rear half needs, and which take most of the memory.
        auditor: audits successful episodes of the task as they end; None for no audit.
    """

    def __init__(
        self,
        plan: EpisodePlan,
        report_progress: ReportProgress = report_nothing,
        keep_motions: bool = True,
        auditor: Auditor | None = None,
    ) -> None:
        self._auditor, self._task = auditor, task_of(plan.task)
        self._plan, self._report_progress, self._keep_motions = plan, report_progress, keep_motions
        self._pipes = [plan.pipes[number // plan.episodes] for number in plan.numbers]
        self._numbered = plan.numbered()

    def _given(self, job: int) -> Any:
        """The start and the target of an episode."""
        return self._numbered(self._plan.numbers[job])

    def locate(self, variant: Variant = "map") -> StageResult:
        """Locate a target in every episode (approach I)."""
        robot, task = robot_for(self._plan.robot, variant), require_reach(self._plan.task, "locating a target")

        def make(simulator: Simulator, queue: EpisodeQueue[ReachEpisodes]) -> Stage:
            locator = LOCATORS[variant](robot, LocateConfig(), len(queue.running))
            return LocateStage(robot, locator, task, simulator, lambda indices: joined(queue.take(indices)))

        return self._run(PassageStage.LOCATE, make, robot, np.arange(len(self._pipes)), self._given)

    def task(self, controller: AnyController, located: StageResult | None = None) -> StageResult:
        """Reach or traverse in every episode, or in those where a target was located."""
        jobs = np.arange(len(self._pipes)) if located is None else located.jobs[located.passed]
        rolled = np.array([self._pipes[job].in_space for job in jobs], bool)
        if rolled.any():
            return self._with_rolling(controller, jobs[~rolled], jobs[rolled])
        start = self._given if located is None else self._from_located(located)
        return self._run(self._task.stage, self._make(controller), self._plan.robot, jobs, start)

    def _from_located(self, located: StageResult) -> Callable[[int], ReachEpisodes]:
        """Episodes that start where locating ended, with the target that was found."""
        found = {int(job): k for k, job in enumerate(located.jobs)}

        def start(job: int) -> ReachEpisodes:
            k = found[job]
            given: ReachEpisodes = self._given(job)
            return given._replace(q=located.results.q[k : k + 1], target=located.targets[k : k + 1])

        return start

    def _with_rolling(self, controller: AnyController, flat: Ints, rolled: Ints) -> StageResult:
        """The task in pipes of which some leave the plane; nothing comes after it, so no motions are kept."""
        jobs = np.sort(np.concatenate([flat, rolled]))
        results = EpisodeResults.empty(len(jobs), self._plan.robot)
        total, in_plane = len(jobs), 0
        if len(flat):
            make, robot = self._make(controller), self._plan.robot
            found = self._run(self._task.stage, make, robot, flat, self._given, total).results
            results.put(np.searchsorted(jobs, flat), found)
            in_plane = int((found.outcome == Outcome.REACHED).sum())
        in_space = run_queue(
            lambda queue: gentle(
                rolling_stage(controller, self._plan.task, self._plan.simulator, queue), self._plan.max_force
            ),
            lambda i: self._given(int(rolled[i])),
            len(rolled),
            max(robots_for(len(rolled)), min(len(rolled), usable_cores())),
            lambda done, successes: self._report_progress(
                self._task.stage, total, len(flat) + done, in_plane + successes
            ),
        )
        results.put(np.searchsorted(jobs, rolled), in_space)
        return StageResult.without_motions(jobs, results)

    def _make(self, controller: AnyController) -> MakeStage:
        def make(simulator: Simulator, queue: EpisodeQueue[Any]) -> Stage:
            n = len(queue.running)
            batch = self._task.batch(self._plan.robot, simulator, n, lambda indices: joined(queue.take(indices)))
            return TaskStage(batch, controller)

        return make

    def rear(self, front: StageResult, located: StageResult | None = None) -> StageResult:
        """The rear half's passage after every successful front half's."""
        task, robot = require_reach(self._plan.task, "the rear half's passage"), self._plan.robot
        jobs = front.jobs[front.passed]
        if not len(jobs):
            return _nothing(robot)
        motions = self._rear_motions(front, located)

        def make(simulator: Simulator, queue: EpisodeQueue[Motion]) -> Stage:
            n = len(queue.running)
            stage = RearStage(robot, self._disturbed(simulator, n), n, queue.take, task)
            return gentle(stage, self._plan.max_force)

        results = run_stage(
            make,
            robot,
            lambda i: motions[int(jobs[i])],
            [motions[int(job)].pipe for job in jobs],
            self._plan.simulator,
            lambda done, successes: self._report_progress(PassageStage.REAR, len(jobs), done, successes),
        )
        return StageResult.without_motions(jobs, results)

    def _rear_motions(self, front: StageResult, located: StageResult | None) -> dict[int, Motion]:
        """The rear half's motion after each successful front half's, by episode."""
        before = {int(job): k for k, job in enumerate(located.jobs)} if located is not None else {}
        motions = {}
        for k in np.flatnonzero(front.passed):
            job = int(front.jobs[k])
            parts = [front.motions[k]] if located is None else [located.motions[before[job]], front.motions[k]]
            base, corner = float(self._given(job).base[0]), self._pipes[job].require_corner()
            motions[job] = rear_motion(self._plan.robot, join([Motion(corner, base, rows) for rows in parts]))
        return motions

    def _disturbed(self, simulator: Simulator, n: int) -> Simulator:
        return disturbed(simulator, self._plan.robot, n, self._plan.disturbance, self._plan.seed)

    def _run(
        self,
        name: str,
        make: MakeStage,
        robot: RobotSpec,
        jobs: Ints,
        start: Callable[[int], Any],
        total: int | None = None,
    ) -> StageResult:
        """Run a stage; `total` counts the stage's episodes where these are not all."""
        if not len(jobs):
            return _nothing(robot)
        recorded: list[RecordedStage] = []
        pipes = [self._pipes[job] for job in jobs]
        most_steps = self._task.most_steps(self._plan.robot, pipes)
        auditor, motions = self._auditor if name == self._task.stage else None, dict[int, Floats]()
        hears = self._keep_motions or auditor is not None

        def begin(i: int) -> Any:
            return start(int(jobs[i]))

        def hear(i: int, reached: bool, motion: Floats) -> None:
            if self._keep_motions:
                motions[i] = motion.copy()
            if auditor is not None and i >= 0 and reached and auditor.wants(job := int(jobs[i])):
                auditor.audit(job, begin(i), motion)

        def make_recorded(simulator: Simulator, queue: EpisodeQueue[Any]) -> Stage:
            stage = gentle(make(self._disturbed(simulator, len(queue.running)), queue), self._plan.max_force)
            recorded.append(RecordedStage(stage, queue, begin, most_steps + 1, hear if hears else None))
            return recorded[0]

        def report(done: int, successes: int) -> None:
            self._report_progress(name, total or len(jobs), done, successes)

        results = run_stage(make_recorded, robot, begin, pipes, self._plan.simulator, report)
        (kept,) = recorded
        targets = [kept.targets.get(i, np.full(2, np.nan)) for i in range(len(jobs))]
        kept_motions = [motions[i] for i in range(len(jobs))] if self._keep_motions else []
        return StageResult(jobs, results, kept_motions, np.reshape(targets, (-1, 2)))


def _nothing(robot: RobotSpec) -> StageResult:
    """Result of a stage that no episode came to."""
    return StageResult.without_motions(np.zeros(0, np.intp), EpisodeResults.empty(0, robot))


def run_task(
    controller: AnyController,
    pipes: Sequence[Pipe],
    episodes: int,
    seed: int,
    simulator: SimulatorSettings = DEFAULT_SIMULATOR,
    disturbance: Disturbance = UNDISTURBED,
) -> EpisodeResults:
    """Run the controller's task alone: reach a given target, or traverse; the arguments are an `EpisodePlan`'s."""
    plan = EpisodePlan(controller.robot, controller.task, pipes, episodes, seed, simulator, disturbance)
    return Passages(plan, keep_motions=False).task(controller).results
