"""Evaluations: some stages over many episodes in many pipes, counted pipe by pipe."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags
from pipenav.backends.registry import check_options
from pipenav.backends.simulators import SimulatorSettings, load_simulator
from pipenav.disturbances.disturbance import UNDISTURBED, load_disturbance
from pipenav.errors import PipenavError
from pipenav.evaluation.config import EvaluationConfig, StageName
from pipenav.evaluation.episode_runner import EpisodeResults
from pipenav.evaluation.passage import EpisodePlan, Passages, ReportProgress, StageResult, report_nothing
from pipenav.evaluation.pipe_results import PipeRecord
from pipenav.evaluation.results import Evaluation
from pipenav.evaluation.thesis import thesis_best
from pipenav.pipes.pipe import Pipe
from pipenav.pipes.tee import fitting_of
from pipenav.policies.named import open_controller
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome, PassageStage
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import check_fits
from pipenav.tasks.registry import TaskConfig, task_of
from pipenav.tasks.rolling.batch import check_in_space
from pipenav.units import m_to_mm, rad_to_deg

StageResults = dict[PassageStage, StageResult]


class CheckedEvaluation:
    """An evaluation that has been checked and can begin.

    Args:
        config: what to compute.

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
        self._controller = None if config.policy is None else open_controller(config.policy, config.robot, config.seed)
        self._robot = load_robot(config.robot or "basic") if self._controller is None else self._controller.robot
        self._config: TaskConfig = ReachConfig() if self._controller is None else self._controller.task
        self._task = task_of(self._config)
        self.config = config.model_copy(update={"stage": self._stage_of(config)})
        pipes = self._task.parse_pipes(config.pipes)
        simulator = SimulatorSettings(config.backend, config.options)
        check_options(config.backend, load_simulator(config.backend), config.options)
        check_fits(self._robot, pipes)
        disturbance = UNDISTURBED if config.disturb is None else load_disturbance(config.disturb)
        if any(pipe.in_space for pipe in pipes):
            check_in_space(self._robot, config.backend, None if config.disturb is None else "--disturb")
        self._plan = EpisodePlan(self._robot, self._config, pipes, config.episodes, config.seed, simulator, disturbance)

    def _stage_of(self, config: EvaluationConfig) -> StageName:
        """The stage to run, by default the one that the policy was trained for."""
        traverses = self._task.stage is PassageStage.TRAVERSE
        stage: StageName = config.stage or ("traverse" if traverses else "reach")
        if self._controller is not None and traverses != (stage == "traverse"):
            does = "traverses the pipe as a whole" if traverses else "reaches a target around the corner"
            fits = "traverse" if traverses else "reach, reach-rear or passage"
            raise PipenavError(f"policy {config.policy} {does}, given stage {stage}: choose {fits}.")
        return stage

    def run(self, report_progress: ReportProgress = report_nothing) -> Evaluation:
        """Run every stage over all episodes, one after the other."""
        config, plan = self.config, self._plan
        stages = self._run_stages(Passages(plan, report_progress))
        deepest = np.zeros(len(plan.pipes) * plan.episodes)
        for result in stages.values():
            deepest[result.jobs] = np.maximum(deepest[result.jobs], result.results.penetration)
        records = [_pipe_record(pipe, stages, i * plan.episodes, plan.episodes) for i, pipe in enumerate(plan.pipes)]
        trained = None if self._controller is None else self._controller.task.control
        return Evaluation.of(
            records,
            config=config,
            robot=self._robot.name,
            penetration_p99_m=float(np.percentile(deepest, 99)),
            thesis={} if trained is None else thesis_best(trained, self._robot.name),
        )

    def _run_stages(self, passages: Passages) -> StageResults:
        stages: StageResults = {}
        if self.config.stage in ("locate", "passage"):
            stages[PassageStage.LOCATE] = passages.locate(self.config.variant)
        if self._controller is not None:
            stages[self._task.stage] = passages.task(self._controller, stages.get(PassageStage.LOCATE))
        if self.config.stage in ("reach-rear", "passage"):
            stages[PassageStage.REAR] = passages.rear(stages[PassageStage.REACH], stages.get(PassageStage.LOCATE))
        return stages


MAIN_STAGES = (PassageStage.REACH, PassageStage.TRAVERSE, PassageStage.LOCATE)
"""Stages whose steps count for an evaluation, the most important one first."""


class _StageInPipe(NamedTuple):
    """The episodes of a stage in one pipe, and which of them succeeded."""

    results: EpisodeResults
    passed: Flags

    @classmethod
    def of(cls, stage: StageResult, first: int, episodes: int) -> _StageInPipe:
        here = np.asarray((stage.jobs >= first) & (stage.jobs < first + episodes))
        return cls(stage.results.select(here), stage.passed[here])


def _pipe_record(pipe: Pipe, stages: StageResults, first: int, episodes: int) -> PipeRecord:
    """The record of a pipe, whose episodes are `first` and the ones after it."""
    here = {stage: _StageInPipe.of(result, first, episodes) for stage, result in stages.items()}
    results = [part.results for part in here.values()]
    main = next(here[stage].results for stage in MAIN_STAGES if stage in here)
    reached = main.outcome == Outcome.REACHED
    steps = np.concatenate([part.steps for part in results])
    shares = np.concatenate([part.contact_share for part in results])
    corner = pipe.corner
    return PipeRecord(
        diameter_mm=round(m_to_mm(pipe.diameter), 6),
        angle_deg=None if corner is None else round(rad_to_deg(corner.angle), 6),
        turn=None if corner is None else corner.turn,
        bend_radius_mm=0.0 if corner is None else round(m_to_mm(corner.bend_radius), 6),
        fitting=None if corner is None else fitting_of(corner),
        route=pipe.name if corner is None else None,
        episodes=episodes,
        failures=_failures(here),
        mean_steps=float(main.steps[reached].mean()) if reached.any() else None,
        min_range_m=min(float(part.min_range.min(initial=np.inf)) for part in results),
        max_penetration_m=max(float(part.penetration.max(initial=0.0)) for part in results),
        peak_force_n=max(float(part.force.max(initial=0.0)) for part in results),
        contact_time_share=float((steps * shares).sum() / steps.sum()),
        **_counts(here),
    )


def _counts(here: dict[PassageStage, _StageInPipe]) -> dict[str, int]:
    """Attempts and successes of the stages, by the keys of a `PipeRecord`."""
    counts: dict[str, int] = {}
    for stage, (_, passed) in here.items():
        if stage is PassageStage.LOCATE:
            counts["located"] = int(passed.sum())
        else:
            counts |= {f"{stage}_attempts": len(passed), f"{stage}_successes": int(passed.sum())}
    return counts


def _failures(here: dict[PassageStage, _StageInPipe]) -> dict[str, int]:
    """Number of episodes by the reason of their failure; before it the stage, where that is not the main task."""
    failures: dict[str, int] = {}
    for stage, (results, passed) in here.items():
        before = "" if stage in (PassageStage.REACH, PassageStage.TRAVERSE) else f"{stage} "
        for outcome in results.outcome[~passed]:
            reason = before + Outcome(outcome).label
            failures[reason] = failures.get(reason, 0) + 1
    return failures
