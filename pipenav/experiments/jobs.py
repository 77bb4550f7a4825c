"""The trainings and evaluations that experiments need, each a job that can run in a process of its own."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from pipenav.experiments.definition import Row, agents_of, load_agents, load_experiment
from pipenav.experiments.plan import EVALUATION_SEED, TRAINED_FILE, ExperimentPlan, ExperimentSettings, resolved_agent
from pipenav.learning.config import TrainConfig
from pipenav.storage.atomic_files import atomic_write
from pipenav.storage.lock import one_writer

STEPS_PER_EPISODE = 15
"""Control steps that an evaluation's episode counts as in the estimate of the time left: the mean of a good agent's."""

ReportDone = Callable[[int], None]
"""Called with how much of a job is done, in control steps."""

ShouldStop = Callable[[], bool]


class Job(NamedTuple):
    """A training or an evaluation, in a process of its own.

    Attributes:
        name: name for messages.
        total: how much there is to do, in control steps (estimated for an evaluation).
        work: the work; called with a function that reports how much is done, and one that says whether to stop.
    """

    name: str
    total: int
    work: Callable[[ReportDone, ShouldStop], None]


@dataclass(frozen=True)
class Training:
    """Work of a job: train, or go on with a training."""

    config: TrainConfig
    folder: Path
    threads: int

    def __call__(self, report: ReportDone, should_stop: ShouldStop) -> None:
        from pipenav.learning.train import train
        from pipenav.learning.training_folder import TrainingFolder

        config = self.config.model_copy(update={"options": _with_threads(self.config, self.threads)})
        with one_writer(self.folder, f"pipenav experiment, training in {self.folder}"):
            resumed = TrainingFolder(self.folder).checkpoint.exists()
            folder = (
                TrainingFolder.open(self.folder).folder
                if resumed
                else TrainingFolder.create(self.folder, config, "pipenav experiment")
            )
            summary = train(config, folder, resumed, lambda progress: report(progress.steps), should_stop)
            if not summary.stopped:
                record = {"seconds": round(summary.seconds, 1), "steps": summary.steps}
                atomic_write(self.folder / TRAINED_FILE, json.dumps(record) + "\n")


@dataclass(frozen=True)
class Measurement:
    """Work of a job: evaluate a policy, or a stage that needs none."""

    policy: Path | None
    row: Row
    pipes: str
    settings: ExperimentSettings
    folder: Path
    threads: int

    def __call__(self, report: ReportDone, should_stop: ShouldStop) -> None:
        from pipenav.evaluation.config import EvaluationConfig
        from pipenav.evaluation.evaluate import CheckedEvaluation
        from pipenav.evaluation.report import write_evaluation

        def progress(_part: str, _total: int, done: int, _successes: int) -> None:
            report(done * STEPS_PER_EPISODE)
            if should_stop():
                raise KeyboardInterrupt

        config = EvaluationConfig(
            policy=None if self.policy is None else str(self.policy),
            pipes=(self.pipes,),
            episodes=self.settings.episodes,
            seed=EVALUATION_SEED,
            stage=self.row.stage,
            robot=self.row.robot,
            variant=self.row.variant,
            backend=self.settings.backend,
            options={"threads": self.threads} if self.settings.backend == "mujoco" else {},
        )
        with one_writer(self.folder, f"pipenav experiment, evaluation in {self.folder}"):
            write_evaluation(self.folder, CheckedEvaluation(config).run(progress))


def _with_threads(config: TrainConfig, threads: int) -> dict[str, Any]:
    return {**config.options, "threads": threads} if config.backend == "mujoco" else dict(config.options)


def training_jobs(plan: ExperimentPlan, threads: int) -> list[Job]:
    """The trainings that are not whole yet."""
    jobs = []
    for agent in agents_of(list(plan.experiments)):
        for seed in plan.seeds:
            folder = plan.training_folder(agent, seed)
            config = load_agents()[agent].config(seed, plan.settings.steps, plan.settings.backend)
            if not (folder / TRAINED_FILE).exists():
                jobs.append(Job(f"train {agent}, seed {seed}", config.steps, Training(config, folder, threads)))
    return jobs


def evaluation_jobs(plan: ExperimentPlan, threads: int, stages: Sequence[str]) -> list[Job]:
    """The evaluations of some stages that are not there yet; their policies must be."""
    jobs: dict[Path, Job] = {}
    for name in plan.experiments:
        experiment = load_experiment(name)
        for row in experiment.rows:
            if row.stage not in stages:
                continue
            for seed in plan.evaluation_seeds(row):
                agent = resolved_agent(plan, row)
                folder = plan.evaluation_folder(row, agent, seed)
                if not (folder / "eval.json").exists():
                    policy = None if agent is None else plan.training_folder(agent, seed) / "best.zip"
                    work = Measurement(policy, row, experiment.pipes, plan.settings, folder, threads)
                    jobs[folder] = Job(f"{row.stage} of {agent or row.robot}, seed {seed}", _control_steps(work), work)
    return list(jobs.values())


def _control_steps(work: Measurement) -> int:
    from pipenav.pipes.corner_sets import parse_corners

    return len(parse_corners([work.pipes])) * work.settings.episodes * STEPS_PER_EPISODE
