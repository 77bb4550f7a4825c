"""Trains and measures what experiments need: several processes, resumable, each result where the next run finds it."""

from __future__ import annotations

import json
import multiprocessing
import queue
import signal
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pydantic import Field, ValidationError

from pipenav.arrays import Table
from pipenav.errors import ConfigError, FileProblem, PipenavError
from pipenav.evaluation.results import Evaluation, read_evaluation
from pipenav.experiments.definition import BEST_OF, Row, agents_of, load_agents, load_experiment
from pipenav.learning.config import TrainConfig
from pipenav.storage.atomic_files import atomic_write, prepare_folder

if TYPE_CHECKING:
    from threading import Event

SETTINGS_FILE = "experiment.json"
TRAINED_FILE = "trained.json"
"""In an agent's run folder once its training is whole: seconds and steps."""

ELAPSED_FILE = "elapsed.json"

EVALUATION_SEED = 0
"""Of starts and targets; the same for every agent, so that all are measured on the same episodes."""

POLL_S = 0.2

STEPS_PER_EPISODE = 15
"""What an evaluation's episode counts as in the estimate of the time left: the mean of a good agent's."""


class Settings(Table):
    """What decides the results in a folder; a later run must have the same."""

    steps: int | None = Field(None, ge=1, description="control steps of each training; None: as the preset says")
    episodes: int = Field(25, ge=1, description="per pipe, agent and seed")
    backend: str = "mujoco"


class ExperimentPlan(NamedTuple):
    """What is to be run: experiments, seeds, and where the results are kept."""

    experiments: tuple[str, ...]
    seeds: tuple[int, ...]
    settings: Settings
    out: Path

    def run_folder(self, agent: str, seed: int) -> Path:
        return self.out / "agents" / agent / f"seed-{seed}"

    def evaluation_folder(self, row: Row, agent: str | None, seed: int) -> Path:
        """Where a row's evaluation lies; rows that measure the same share it."""
        if agent is None:
            return self.out / "stages" / f"{row.robot}-{row.stage}-{row.variant}" / f"seed-{seed}"
        return self.run_folder(agent, seed) / f"eval-{row.stage}"


class Job(NamedTuple):
    """One training, or one evaluation, in a process of its own.

    Attributes:
        name: for messages.
        total: how much there is to do, in control steps (of an evaluation, estimated).
        run: the work; called with a function that reports how much is done, and one that says whether to stop.
    """

    name: str
    total: int
    run: Callable[[Callable[[int], None], Callable[[], bool]], None]


@dataclass(frozen=True)
class Training:
    """A job's work: train, or go on with a training."""

    config: TrainConfig
    folder: Path
    threads: int

    def __call__(self, report: Callable[[int], None], should_stop: Callable[[], bool]) -> None:
        from pipenav.learning.train import train
        from pipenav.learning.training_folder import TrainingFolder

        config = self.config.model_copy(update={"options": _with_threads(self.config, self.threads)})
        resumed = TrainingFolder(self.folder).resume.exists()
        folder = (
            TrainingFolder.open(self.folder)[0]
            if resumed
            else TrainingFolder.create(self.folder, config, "pipenav experiment")
        )
        outcome = train(config, folder, resumed, lambda progress: report(progress.steps), should_stop)
        if not outcome.stopped:
            record = {"seconds": round(outcome.seconds, 1), "steps": outcome.steps}
            atomic_write(self.folder / TRAINED_FILE, json.dumps(record) + "\n")


@dataclass(frozen=True)
class Measurement:
    """A job's work: evaluate a policy, or a stage that needs none."""

    policy: Path | None
    row: Row
    pipes: str
    settings: Settings
    folder: Path
    threads: int

    def __call__(self, report: Callable[[int], None], should_stop: Callable[[], bool]) -> None:
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
        evaluation = CheckedEvaluation(config).run(progress)
        write_evaluation(self.folder, evaluation)


def _with_threads(config: TrainConfig, threads: int) -> dict[str, Any]:
    return {**config.options, "threads": threads} if config.backend == "mujoco" else dict(config.options)


def open_plan(experiments: Sequence[str], seeds: int, settings: Settings, out: Path) -> ExperimentPlan:
    """The plan for a folder, new or of an earlier run with the same settings.

    Raises:
        PipenavError: the folder holds results of other settings.
    """
    prepare_folder(out)
    file = out / SETTINGS_FILE
    if file.exists():
        try:
            earlier = Settings.model_validate_json(file.read_bytes())
        except OSError as error:
            raise FileProblem(file, "read", error) from error
        except ValidationError as error:
            raise ConfigError.from_validation(str(file), error, Settings.model_fields) from error
        if earlier != settings:
            raise PipenavError(
                f"{out} holds results of {_words(earlier)}, not of {_words(settings)}: "
                "give the same settings, or another --out."
            )
    else:
        atomic_write(file, settings.model_dump_json(indent=1) + "\n")
    return ExperimentPlan(tuple(experiments), tuple(range(seeds)), settings, out)


def elapsed(plan: ExperimentPlan) -> float:
    """Seconds that all runs have worked in the folder."""
    file = plan.out / ELAPSED_FILE
    return read_number(file, "seconds") if file.exists() else 0.0


def read_number(file: Path, key: str) -> float:
    """A number from a small JSON file of a results folder.

    Raises:
        FileProblem: it cannot be read.
        PipenavError: it is damaged.
    """
    try:
        return float(json.loads(file.read_text(encoding="utf-8"))[key])
    except OSError as error:
        raise FileProblem(file, "read", error) from error
    except (ValueError, TypeError, KeyError):
        raise PipenavError(
            f"{file} is damaged, it has no number {key!r}: remove it, and run the command again."
        ) from None


def add_elapsed(plan: ExperimentPlan, seconds: float) -> None:
    """Count the seconds of some jobs."""
    if seconds > 0:
        atomic_write(plan.out / ELAPSED_FILE, json.dumps({"seconds": round(elapsed(plan) + seconds, 1)}) + "\n")


def _words(settings: Settings) -> str:
    steps = "the presets' steps" if settings.steps is None else f"{settings.steps:,} steps"
    return f"{steps}, {settings.episodes} episodes per pipe, backend {settings.backend}"


def training_jobs(plan: ExperimentPlan, threads: int) -> list[Job]:
    """The trainings that are not whole yet."""
    jobs = []
    for agent in agents_of(list(plan.experiments)):
        for seed in plan.seeds:
            folder = plan.run_folder(agent, seed)
            config = load_agents()[agent].config(seed, plan.settings.steps)
            config = config.model_copy(update={"backend": plan.settings.backend})
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
            for seed in plan.seeds if row.agent else (EVALUATION_SEED,):
                agent = resolved_agent(plan, row)
                folder = plan.evaluation_folder(row, agent, seed)
                if not (folder / "eval.json").exists():
                    policy = None if agent is None else plan.run_folder(agent, seed) / "best.zip"
                    work = Measurement(policy, row, experiment.pipes, plan.settings, folder, threads)
                    jobs[folder] = Job(f"{row.stage} of {agent or row.robot}, seed {seed}", _control_steps(work), work)
    return list(jobs.values())


def _control_steps(work: Measurement) -> int:
    from pipenav.pipes.corner_sets import parse_corners

    return len(parse_corners([work.pipes])) * work.settings.episodes * STEPS_PER_EPISODE


def resolved_agent(plan: ExperimentPlan, row: Row) -> str | None:
    """The agent of a row; of `best of c` the one whose fronts succeeded most, over all seeds and pipes of (c)."""
    if row.agent is None or not row.agent.startswith(BEST_OF):
        return row.agent
    rows = [r for r in load_experiment(row.agent.removeprefix(BEST_OF)).rows if r.candidate]
    return max(rows, key=lambda row: _mean_success(evaluations(plan, row))).agent


def _mean_success(found: Sequence[Evaluation]) -> float:
    return sum(one.success for one in found) / len(found)


def evaluations(plan: ExperimentPlan, row: Row) -> list[Evaluation]:
    """A row's evaluations, one for each seed."""
    agent = resolved_agent(plan, row)
    seeds = plan.seeds if row.agent else (EVALUATION_SEED,)
    return [read_evaluation(plan.evaluation_folder(row, agent, seed)) for seed in seeds]


Report = Callable[[str, float, float], None]
"""Called with what just happened (or nothing new), the share of the work that is done, and seconds since the start."""


def run_jobs(jobs: Sequence[Job], processes: int, report: Report, should_stop: Callable[[], bool]) -> bool:
    """Run jobs in some processes; False when it was asked to stop before all were done.

    Raises:
        PipenavError: what a job raised.
    """
    if not jobs:
        return True
    started = time.monotonic()
    total, done = sum(job.total for job in jobs), [0] * len(jobs)
    context = multiprocessing.get_context("spawn")  # torch and thread pools do not survive a fork
    with context.Manager() as manager:
        inbox, stop = manager.Queue(), manager.Event()
        with ProcessPoolExecutor(processes, mp_context=context, initializer=_leave_signals_to_parent) as pool:
            running: dict[Future[None], int] = {
                pool.submit(_work, job.run, i, inbox, stop): i for i, job in enumerate(jobs)
            }
            while running:
                finished, _ = wait(running, timeout=POLL_S, return_when=FIRST_COMPLETED)
                _drain_inbox(inbox, done)
                if should_stop() and not stop.is_set():
                    stop.set()
                    for future in running:
                        future.cancel()
                message = ""
                for future in finished:
                    i = running.pop(future)
                    if future.cancelled():
                        continue
                    _raise_after_stopping(future, stop)
                    if not stop.is_set():
                        done[i], message = jobs[i].total, jobs[i].name
                report(message, sum(done) / total, time.monotonic() - started)
            return not stop.is_set()


def _raise_after_stopping(future: Future[None], stop: Event) -> None:
    error = future.exception()
    if error is not None and not (isinstance(error, KeyboardInterrupt) and stop.is_set()):
        stop.set()
        raise error


def _drain_inbox(inbox: queue.Queue[tuple[int, int]], done: list[int]) -> None:
    while True:
        try:
            i, amount = inbox.get_nowait()
        except queue.Empty:
            return
        done[i] = amount


def _leave_signals_to_parent() -> None:
    """Ctrl-C goes to every process of the terminal; only the parent decides what it means."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _work(run: Callable[..., None], i: int, inbox: queue.Queue[tuple[int, int]], stop: Event) -> None:
    last = [0.0]

    def report(amount: int) -> None:
        if time.monotonic() - last[0] > POLL_S:
            last[0] = time.monotonic()
            inbox.put((i, amount))

    run(report, stop.is_set)
