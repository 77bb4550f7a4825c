"""The trainings and evaluations that experiments need, as jobs for any place."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Protocol

from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.folder import UNFINISHED
from pipenav.evaluation.part_jobs import PartJobs
from pipenav.evaluation.report import write_evaluation
from pipenav.experiments.definition import agents_of, load_agents, load_experiment
from pipenav.experiments.plan import EVALUATION_SEED, TRAINED_FILE, ExperimentPlan, resolved_agent
from pipenav.jobs import Done, Event, Job, JobStore, Place, Progressed, Stopped
from pipenav.jobs.here import HerePlace
from pipenav.learning.config import TrainConfig
from pipenav.learning.training_job import order_for, run_training, take_files, take_training
from pipenav.pipes.corner_sets import parse_corners
from pipenav.storage.atomic_files import atomic_write
from pipenav.storage.lock import one_writer

STEPS_PER_EPISODE = 15
"""Control steps that an evaluation's episode counts as in the estimate of the time left: the mean of a good agent's."""

COMMAND = "pipenav experiment"

MOST_CORES = 1 << 10
"""More cores than any machine has: a training takes all that its place has for it."""


class Task(Protocol):
    """A training or an evaluation.

    Attributes:
        name: name for messages.
        total: how much there is to do, in control steps (estimated for an evaluation).
        done: how much of it is done.
        whole: whether all of it is done, and written.
    """

    name: str
    total: int
    done: int
    whole: bool

    def jobs(self, place: Place) -> Iterator[Job]:
        """Its jobs that are left."""
        ...

    def hear(self, event: Event) -> None:
        """Hear of one of its jobs."""
        ...

    def close(self) -> None:
        """Let go of its folder."""
        ...


class Training:
    """A training, in one job; one that has begun goes on."""

    def __init__(self, name: str, config: TrainConfig, folder: Path) -> None:
        self.name, self.total, self.done, self.whole = name, config.steps, 0, False
        self._config, self._folder = config, folder

    def jobs(self, place: Place) -> Iterator[Job]:
        """Its only job."""
        self._order = order_for(self._config, self._folder, COMMAND, place.shares_disk)
        cores = MOST_CORES if place.shares_disk else 1
        yield Job("-".join(self._folder.parts[-2:]), self.name, run_training, self._order, cores)

    def hear(self, event: Event) -> None:
        """Write down that it is whole, when it is."""
        if isinstance(event, Progressed):
            self.done = event.progress[0]
        elif isinstance(event, Stopped):
            take_files(self._order, event.content)
        elif isinstance(event, Done):
            summary = take_training(self._order, event.content)
            record = {"seconds": round(summary.seconds, 1), "steps": summary.steps}
            atomic_write(self._folder / TRAINED_FILE, json.dumps(record) + "\n")
            self.done, self.whole = self.total, True

    def close(self) -> None:
        """Nothing is held: the job holds the folder."""


class Measurement:
    """An evaluation of a policy, or of a stage that needs none, in a job for each part."""

    def __init__(self, name: str, config: EvaluationConfig, folder: Path) -> None:
        self.name, self._config, self._folder = name, config, folder
        self.total = len(parse_corners(config.pipes)) * config.episodes * STEPS_PER_EPISODE
        self.done, self.whole = 0, False
        self._held = ExitStack()

    def jobs(self, place: Place) -> Iterator[Job]:
        """Its parts that are not kept."""
        self._held.enter_context(one_writer(self._folder, f"{COMMAND}, evaluation in {self._folder}"))
        self._checked = CheckedEvaluation(self._config)
        self._store = JobStore(self._folder / UNFINISHED, self._checked.parts.request())
        self._parts = PartJobs(self._checked.parts, self._store)
        yield from self._parts.jobs(isinstance(place, HerePlace), self._note)
        if self._checked.missing(self._store) == 0:
            self._write()

    def _note(self, _stage: str, _total: int, done: int, _successes: int) -> None:
        self.done = max(self.done, done * STEPS_PER_EPISODE)

    def hear(self, event: Event) -> None:
        """Keep a part, and write the whole when it was the last one."""
        self._parts.hear(event)
        if isinstance(event, Done) and self._checked.missing(self._store) == 0:
            self._write()

    def _write(self) -> None:
        if not self.whole:
            write_evaluation(self._folder, self._checked.merged(self._store))
            self._store.remove()
            self.done, self.whole = self.total, True
            self.close()

    def close(self) -> None:
        """Let go of the folder."""
        self._held.close()


def trainings(plan: ExperimentPlan) -> list[Task]:
    """The trainings that are not whole yet."""
    tasks: list[Task] = []
    for agent in agents_of(list(plan.experiments)):
        for seed in plan.seeds:
            folder = plan.training_folder(agent, seed)
            config = load_agents()[agent].config(seed, plan.settings.steps, plan.settings.backend)
            if not (folder / TRAINED_FILE).exists():
                tasks.append(Training(f"train {agent}, seed {seed}", config, folder))
    return tasks


def measurements(plan: ExperimentPlan, stages: Sequence[str]) -> list[Task]:
    """The evaluations of some stages that are not there yet; their policies must be."""
    tasks: dict[Path, Task] = {}
    for name in plan.experiments:
        experiment = load_experiment(name)
        for row in experiment.rows:
            if row.stage not in stages:
                continue
            for seed in plan.evaluation_seeds(row):
                agent = resolved_agent(plan, row)
                folder = plan.evaluation_folder(row, agent, seed)
                if (folder / "eval.json").exists():
                    continue
                config = EvaluationConfig(
                    policy=None if agent is None else str(plan.training_folder(agent, seed) / "best.zip"),
                    pipes=(experiment.pipes,),
                    episodes=plan.settings.episodes,
                    seed=EVALUATION_SEED,
                    stage=row.stage,
                    robot=row.robot,
                    variant=row.variant,
                    backend=plan.settings.backend,
                )
                tasks[folder] = Measurement(f"{row.stage} of {agent or row.robot}, seed {seed}", config, folder)
    return list(tasks.values())
