"""Evaluations: some stages over many episodes in many pipes, counted pipe by pipe."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipenav.backends.registry import check_options
from pipenav.backends.simulators import SimulatorSettings, load_simulator
from pipenav.disturbances.disturbance import UNDISTURBED, load_disturbance
from pipenav.errors import PipenavError
from pipenav.evaluation.audit import AuditRows, check_audit
from pipenav.evaluation.audit_record import AuditRecord
from pipenav.evaluation.config import EvaluationConfig, StageName
from pipenav.evaluation.part_jobs import PartJobs
from pipenav.evaluation.part_plan import PartPlan, Shard
from pipenav.evaluation.parts import PartResult, PartRows
from pipenav.evaluation.passability import check_certified_stage
from pipenav.evaluation.passability_jobs import ReportPipes, decide, report_no_pipes
from pipenav.evaluation.passability_record import PipePassability
from pipenav.evaluation.passage import EpisodePlan, ReportProgress, report_nothing
from pipenav.evaluation.pipe_counts import pipe_records
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.results import Evaluation, Extremes
from pipenav.evaluation.starts import StartSet, load_starts
from pipenav.evaluation.thesis import thesis_best
from pipenav.evaluation.training_range import TrainingRange
from pipenav.jobs import MemoryStore, Place, Store
from pipenav.jobs.here import HerePlace
from pipenav.policies.named import open_controller
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.tasks.outcome import PassageStage
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import check_fits
from pipenav.tasks.registry import TaskConfig, task_of
from pipenav.tasks.rolling.batch import check_in_space
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.tether import TetherConfig


class CheckedEvaluation:
    """An evaluation that has been checked and can begin.

    Args:
        config: what to compute.

    Attributes:
        config: the same, its stage named.
        parts: the evaluation in parts.
        cpus: kinds of processors that computed the parts that have been merged; results of two kinds may differ in
            their last digits.

    Raises:
        PipenavError: something is unknown, the robot does not fit into a pipe, or there is no policy where one is
            needed.
    """

    def __init__(self, config: EvaluationConfig) -> None:
        if (config.policy is None) != (config.stage == "locate"):
            raise PipenavError(
                f"{f'stage {config.stage}' if config.stage else 'an evaluation'} measures a policy: give --policy, for "
                "example --policy arm."
                if config.policy is None
                else "stage locate runs without a policy: leave out --policy."
            )
        starts = None if config.starts is None else load_starts(config.starts)
        if starts is not None:  # they bring their pipes
            pipes_named = tuple(pipe.pipe for pipe in starts.pipes)
            config = config.model_copy(update={"pipes": pipes_named, "episodes": starts.each})
        self._controller = None if config.policy is None else open_controller(config.policy, config.robot, config.seed)
        self._robot = load_robot(config.robot or "basic") if self._controller is None else self._controller.robot
        self._config: TaskConfig = ReachConfig() if self._controller is None else self._controller.task
        self._config = _recovering(_with_sensors(_tethered(self._config, config), config), config)
        self._task = task_of(self._config)
        if starts is not None:
            _check_starts(starts, self._robot, self._config)
        self.config = config.model_copy(update={"stage": self._stage_of(config)})
        pipes = self._task.parse_pipes(config.pipes)
        simulator = SimulatorSettings(config.backend, config.options)
        check_options(config.backend, load_simulator(config.backend), config.options)
        check_fits(self._robot, pipes)
        disturbance = UNDISTURBED if config.disturb is None else load_disturbance(config.disturb)
        if any(pipe.in_space for pipe in pipes):
            check_in_space(self._robot, config.backend, None if config.disturb is None else "--disturb")
        if config.audit is not None:
            check_audit(str(self.config.stage), pipes)
        if config.certify:
            check_certified_stage(str(self.config.stage))
        plan = EpisodePlan(
            self._robot,
            self._config,
            pipes,
            config.episodes,
            config.seed,
            simulator,
            disturbance,
            config.max_force,
            starts=() if starts is None else starts.pipes,
        )
        self.parts = PartPlan(self.config, plan, self._controller)
        self.cpus: set[str] = set()

    def _stage_of(self, config: EvaluationConfig) -> StageName:
        """The stage to run, by default the one that the policy was trained for."""
        traverses = self._task.stage is PassageStage.TRAVERSE
        stage: StageName = config.stage or ("traverse" if traverses else "reach")
        if self._controller is not None and traverses != (stage == "traverse"):
            does = "traverses the pipe as a whole" if traverses else "reaches a target around the corner"
            fits = "traverse" if traverses else "reach, reach-rear or passage"
            raise PipenavError(f"policy {config.policy} {does}, given stage {stage}: choose {fits}.")
        return stage

    def run(
        self, report_progress: ReportProgress = report_nothing, place: Place | None = None, store: Store | None = None
    ) -> Evaluation:
        """Run every episode, at a place, and count.

        Args:
            report_progress: called with sums over all parts, see `ReportProgress`.
            place: where the parts run, by default this process; the results are the same wherever it is.
            store: keeps the parts that are finished, and has those of earlier drivers.

        Raises:
            JobsLost: parts were lost every time that they were tried.
            PipenavError: a part raised it.
        """
        store = MemoryStore() if store is None else store
        self.run_parts(store, report_progress, place)
        return self.merged(store, place)

    def run_parts(
        self,
        store: Store,
        report_progress: ReportProgress = report_nothing,
        place: Place | None = None,
        shard: Shard | None = None,
    ) -> None:
        """Run the parts that a store lacks, all or those of a share; the arguments are those of `run`."""
        PartJobs(self.parts, store, shard).run(place or HerePlace(), report_progress)

    def missing(self, store: Store) -> int:
        """Number of the parts that a store lacks."""
        return sum(not store.has(self.parts.key(index)) for index in range(self.parts.count))

    def merged(
        self, store: Store, place: Place | None = None, report_pipes: ReportPipes = report_no_pipes
    ) -> Evaluation:
        """The evaluation from its parts in a store, all of which must be there; they are read one after another.

        Args:
            store: has the parts, and keeps the verdicts of geometry where they are asked for.
            place: where these verdicts are found, by default this process.
            report_pipes: see `ReportPipes`.
        """
        plan = self.parts.episodes
        self._deepest, self._hardest = np.zeros((2, self.parts.total))
        self._audits, self._failed = list[AuditRows](), list[int]()
        records = list(pipe_records(self._read(store), plan.pipes, plan.episodes))
        if self.config.certify:
            records = self._certified(records, store, place or HerePlace(), report_pipes)
        trained = None if self._controller is None else self._controller.task.control
        return Evaluation.of(
            records,
            config=self.config,
            robot=self._robot.name,
            extremes=Extremes(float(np.percentile(self._deepest, 99)), float(np.percentile(self._hardest, 99))),
            thesis={} if trained is None else thesis_best(trained, self._robot.name),
            audit=None if self.config.audit is None else AuditRecord.of(self._audits, self._config.max_penetration),
        )

    def _certified(
        self, records: list[PipeRecord], store: Store, place: Place, report_pipes: ReportPipes
    ) -> list[PipeRecord]:
        """The records with geometry's verdicts, and whether the policy was trained in pipes around."""
        plan, trained = self.parts.episodes, TrainingRange.of(self._controller)
        failed: list[list[int]] = [[] for _ in plan.pipes]
        for number in self._failed:
            failed[number // plan.episodes].append(number % plan.episodes)
        answers = decide(self.parts, failed, store, place, report_pipes)
        return [
            record.model_copy(
                update={
                    "passability": PipePassability.on(answer, record.successes),
                    "trained": None if trained is None else trained.has(pipe),
                }
            )
            for record, answer, pipe in zip(records, answers, plan.pipes, strict=True)
        ]

    def _read(self, store: Store) -> Iterator[tuple[int, PartRows]]:
        """Every part, as `pipe_records` takes it; notes each episode's extremes, audits and failures."""
        for index, end in enumerate(self.parts.bounds[1:]):
            content = store.read(self.parts.key(index))
            if content is None:
                raise PipenavError(f"part {index + 1} of the evaluation is missing: give the command again to run it.")
            rows, cpu, audits = PartResult.from_bytes(content)
            self.cpus.add(cpu)
            self._audits += [] if audits is None else [audits]
            for part in rows.values():
                self._failed += part.jobs[~part.passed].tolist()
                self._deepest[part.jobs] = np.maximum(self._deepest[part.jobs], part.penetration)
                self._hardest[part.jobs] = np.maximum(self._hardest[part.jobs], part.force)
            yield end, rows


def _tethered(task: TaskConfig, config: EvaluationConfig) -> TaskConfig:
    """The task with the cable that an evaluation asks for.

    Raises:
        PipenavError: the task is none of a whole robot, or a cable's friction without a cable.
    """
    if config.tether is None:
        if config.cable_friction is not None:
            raise PipenavError("--cable-friction is of the cable of --tether: give that too, or leave it out.")
        return task
    if not isinstance(task, TraverseConfig):
        raise PipenavError("a cable is pulled by a whole robot: give a policy such as pirate, or leave out --tether.")
    friction = {} if config.cable_friction is None else {"friction": config.cable_friction}
    tether = TetherConfig(length=(config.tether, config.tether), **friction)
    return task.model_copy(update={"tether": tether})


def _check_starts(starts: StartSet, robot: RobotSpec, task: TaskConfig) -> None:
    """Refuse starts that are none of the task's robot.

    Raises:
        PipenavError: the task is none of a whole robot, or one with other links.
    """
    if not isinstance(task, TraverseConfig):
        raise PipenavError("--starts are poses of a whole robot: give a policy such as pirate, or leave out --starts.")
    starts.check_robot(robot)


def _with_sensors(task: TaskConfig, config: EvaluationConfig) -> TaskConfig:
    """The task with the sensors that an evaluation asks for.

    Raises:
        PipenavError: the task is none of a whole robot.
    """
    if config.sensors is None:
        return task
    if not isinstance(task, TraverseConfig):
        raise PipenavError(
            "gyroscopes, accelerometers and wheels are a whole robot's: give a policy such as pirate, or leave out "
            "--sensors."
        )
    return task.model_copy(update={"sensors": config.sensors})


def _recovering(task: TaskConfig, config: EvaluationConfig) -> TaskConfig:
    """The task with recovery, where an evaluation asks for it.

    Raises:
        PipenavError: the task is none of a whole robot.
    """
    if not config.recover:
        return task
    if not isinstance(task, TraverseConfig):
        raise PipenavError("a whole robot recovers by itself: give a policy such as pirate, or leave out --recover.")
    return task.model_copy(update={"recovery": True})
