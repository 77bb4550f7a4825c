"""The plan of experiments, and the folder that keeps their results."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from pydantic import Field, ValidationError

from pipenav.arrays import Table
from pipenav.errors import ConfigError, PipenavError
from pipenav.evaluation.config import EARLIER_STAGES, StageName
from pipenav.evaluation.results import Evaluation, read_evaluation
from pipenav.experiments.definition import BEST_OF, Row, load_experiment
from pipenav.storage.atomic_files import atomic_write, prepare_folder
from pipenav.storage.text_files import checked_json, read_json, read_text

SETTINGS_FILE = "experiment.json"
"""File that says which settings the results in a folder have."""

TRAINED_FILE = "trained.json"
"""File in an agent's training folder once its training is whole: seconds and steps."""

ELAPSED_FILE = "elapsed.json"
"""File with the seconds that all commands have worked in a folder."""

EVALUATION_SEED = 0
"""Seed of starts and targets; the same for every agent, so that all are measured on the same episodes."""


class ExperimentSettings(Table):
    """Everything that decides the results in a folder; a later command must have the same."""

    steps: int | None = Field(None, ge=1, description="control steps of each training; None: as the preset says")
    episodes: int = Field(25, ge=1, description="episodes in each pipe, for each agent and seed")
    backend: str = "mujoco"

    def __str__(self) -> str:
        steps = "the presets' steps" if self.steps is None else f"{self.steps:,} steps"
        return f"{steps}, {self.episodes} episodes per pipe, backend {self.backend}"


class ExperimentPlan(NamedTuple):
    """Experiments, seeds, and where the results are kept."""

    experiments: tuple[str, ...]
    seeds: tuple[int, ...]
    settings: ExperimentSettings
    out: Path

    def training_folder(self, agent: str, seed: int) -> Path:
        return self.out / "agents" / agent / f"seed-{seed}"

    def evaluation_folder(self, row: Row, agent: str | None, seed: int) -> Path:
        """Folder of a row's evaluation; rows that measure the same share it."""
        if agent is None:
            return self.out / "stages" / f"{row.robot}-{row.stage}-{row.variant}" / f"seed-{seed}"
        folders = [self.training_folder(agent, seed) / f"eval-{name}" for name in _names_of_stage(row.stage)]
        return next((folder for folder in folders if folder.is_dir()), folders[0])

    def evaluation_seeds(self, row: Row) -> tuple[int, ...]:
        """Seeds of the trainings whose policies a row measures; a single one where it measures none."""
        return self.seeds if row.agent else (EVALUATION_SEED,)


def _names_of_stage(stage: StageName) -> list[str]:
    """The names that a stage has had, today's first."""
    return [stage, *(earlier for earlier, today in EARLIER_STAGES.items() if today == stage)]


def open_plan(experiments: Sequence[str], seeds: int, settings: ExperimentSettings, out: Path) -> ExperimentPlan:
    """The plan for a folder, which may hold results of the same settings.

    Raises:
        PipenavError: the folder holds results of other settings.
    """
    prepare_folder(out)
    file = out / SETTINGS_FILE
    if file.exists():
        try:
            earlier = ExperimentSettings.model_validate_json(checked_json(read_text(file), str(file)))
        except ValidationError as error:
            raise ConfigError.from_validation(str(file), error, ExperimentSettings.model_fields) from error
        if earlier != settings:
            raise PipenavError(
                f"{out} holds results of {earlier}, not of {settings}: give the same settings, or another --out."
            )
    else:
        atomic_write(file, settings.model_dump_json(indent=1) + "\n")
    return ExperimentPlan(tuple(experiments), tuple(range(seeds)), settings, out)


def elapsed(plan: ExperimentPlan) -> float:
    """Seconds that all commands have worked in the folder."""
    file = plan.out / ELAPSED_FILE
    return read_number(file, "seconds") if file.exists() else 0.0


def read_number(file: Path, key: str) -> float:
    """A number, 0 or more, from a small JSON file of a results folder.

    Raises:
        FileProblem: it cannot be read.
        PipenavError: it is damaged.
    """
    damaged = PipenavError(f"{file} is damaged, it has no number {key!r}: remove it, and run the command again.")
    try:
        content = read_json(file)
    except ConfigError:
        raise damaged from None
    number = content.get(key) if isinstance(content, dict) else None
    if isinstance(number, bool) or not isinstance(number, int | float) or not 0 <= number < math.inf:
        raise damaged
    return float(number)


def add_elapsed(plan: ExperimentPlan, seconds: float) -> None:
    """Add the seconds of some jobs to those that the folder counts."""
    if seconds > 0:
        atomic_write(plan.out / ELAPSED_FILE, json.dumps({"seconds": round(elapsed(plan) + seconds, 1)}) + "\n")


def resolved_agent(plan: ExperimentPlan, row: Row) -> str | None:
    """The agent of a row; for `best of c` the one that reaches best, over all seeds and pipes of (c)."""
    if row.agent is None or not row.agent.startswith(BEST_OF):
        return row.agent
    rows = [r for r in load_experiment(row.agent.removeprefix(BEST_OF)).rows if r.candidate]
    return max(rows, key=lambda row: _mean_success(evaluations(plan, row))).agent


def _mean_success(found: Sequence[Evaluation]) -> float:
    return sum(one.success for one in found) / len(found)


def evaluations(plan: ExperimentPlan, row: Row) -> list[Evaluation]:
    """A row's evaluations, one for each seed."""
    agent = resolved_agent(plan, row)
    return [read_evaluation(plan.evaluation_folder(row, agent, seed)) for seed in plan.evaluation_seeds(row)]


def is_complete(plan: ExperimentPlan, name: str) -> bool:
    """Whether all evaluations of an experiment are there."""
    try:
        return all(evaluations(plan, row) for row in load_experiment(name).rows)
    except PipenavError:
        return False
