"""A trial as a job: train, and tell how success went.

The training lies in the folder of the search where the place shares the driver's disk, so that a trial that was stopped
or killed goes on there. Elsewhere it lies in a temporary folder, and begins anew.
"""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from pydantic import ValidationError

from pipenav.arrays import Table
from pipenav.backends.simulators import CORES_OPTIONS, SimulatorSettings
from pipenav.errors import PipenavError
from pipenav.jobs import JobControl, JobStopped
from pipenav.learning.config import TrainConfig
from pipenav.learning.stages import training_stages
from pipenav.storage.atomic_files import atomic_write
from pipenav.storage.lock import one_writer
from pipenav.storage.temporary import temporary_folder
from pipenav.storage.text_files import checked_json, read_text
from pipenav.tuning.objective import Check, Objective, Outcome

if TYPE_CHECKING:
    from pipenav.learning.progress import TrainingProgress
    from pipenav.learning.training_folder import TrainingFolder

CHECKS_FILE = "timed-checks.json"
"""File in a trial's training folder with the checks so far, which progress.csv has without their moments."""


class TrialOrder(NamedTuple):
    """Everything that a worker must know of a trial.

    Attributes:
        config: configuration of its training.
        objective: what is looked for, and so when the training may end.
        name: name of the trial.
        folder: its training folder; None where the place has no disk in common with the driver.
    """

    config: TrainConfig
    objective: Objective
    name: str
    folder: Path | None


def trial_folder(search: Path, name: str) -> Path:
    """The training folder of a trial."""
    return search / "trainings" / name


def run_trial(order: TrialOrder, control: JobControl) -> bytes:
    """Train, or go on with it; returns the `Outcome` as JSON.

    Raises:
        JobStopped: it was asked to stop, and has saved.
        PipenavError: the robot, the task, the pipes and the simulator do not fit each other.
    """
    from pipenav.learning.divergence import TrainingDiverged
    from pipenav.learning.train import train

    with _folder(order) as path, one_writer(path, f"pipenav tune, {order.name}"):
        config = _on_cores(order.config, control.cores)
        folder, resumed = _opened(path, config)
        watch = _Watch(order, control, path, resumed)
        try:
            summary = train(config, folder, resumed, watch.report, watch.should_stop)
        except TrainingDiverged:
            return watch.outcome(watch.steps, watch.seconds, diverged=True)
        if summary.stopped and not watch.succeeded:
            raise JobStopped
        if not summary.stopped:
            watch.add(Check(summary.steps, summary.seconds, summary.check_success))
        return watch.outcome(summary.steps, summary.seconds)


@contextlib.contextmanager
def _folder(order: TrialOrder) -> Iterator[Path]:
    """The trial's folder, or a temporary one."""
    if order.folder is not None:
        yield order.folder
        return
    with temporary_folder("trial") as path:
        yield path


def _on_cores(config: TrainConfig, cores: int) -> TrainConfig:
    """The training on as many cores as its place gives it."""
    simulator = SimulatorSettings(config.backend, config.options).on_cores(cores)
    return config.model_copy(update={"options": dict(simulator.options)})


class _Opened(NamedTuple):
    folder: TrainingFolder
    resumed: bool


def _opened(path: Path, config: TrainConfig) -> _Opened:
    """The trial's training folder: one to go on with, or a new one where there is none or its training differs."""
    from pipenav.learning.training_folder import TrainingFolder

    with contextlib.suppress(PipenavError):
        earlier = TrainingFolder.open(path)
        if _without_cores(earlier.config) == _without_cores(config):
            return _Opened(earlier.folder, True)
    for file in path.glob("[!.]*"):
        shutil.rmtree(file) if file.is_dir() else file.unlink()
    return _Opened(TrainingFolder.create(path, config, "pipenav tune"), False)


def _without_cores(config: TrainConfig) -> TrainConfig:
    return config.model_copy(update={"options": {k: v for k, v in config.options.items() if k not in CORES_OPTIONS}})


class _Checks(Table):
    """Content of `CHECKS_FILE`."""

    checks: tuple[Check, ...]


class _Watch:
    """A training of which the checks are collected, and which is ended where it has shown enough.

    Attributes:
        steps, seconds: progress of the training as far as it is known.
        succeeded: whether a success has ended it.
    """

    def __init__(self, order: TrialOrder, control: JobControl, path: Path, resumed: bool) -> None:
        stages = training_stages(order.config)
        self._since = stages[stages[-1].checked_since - 1].begin  # checks before measure something else
        self._objective, self._control, self._file = order.objective, control, path / CHECKS_FILE
        self._checks = _earlier_checks(self._file, path) if resumed else []
        self.steps, self.seconds = 0, 0.0
        self.succeeded = False
        self._look()

    def report(self, progress: TrainingProgress) -> None:
        """Take what a training reports after an update."""
        self.steps = progress.steps
        last = self._checks[-1].steps if self._checks else 0
        if progress.check_steps > max(last, self._since):
            self.seconds = progress.check_seconds
            self.add(Check(progress.check_steps, round(progress.check_seconds, 2), progress.check_success))
        self._control.report(Outcome(checks=tuple(self._checks), steps=self.steps, seconds=self.seconds))

    def add(self, check: Check) -> None:
        """Take a check."""
        self._checks.append(check)
        atomic_write(self._file, _Checks(checks=tuple(self._checks)).model_dump_json() + "\n")
        self._look()

    def _look(self) -> None:
        so_far = Outcome(checks=tuple(self._checks), steps=self.steps, seconds=self.seconds)
        self.succeeded = self._objective.ends_early and self._objective.first_success(so_far) is not None

    def should_stop(self) -> bool:
        """Whether the training shall save and end."""
        asked = self._control.should_stop()  # always: a place that is never asked would end the process
        return asked or self.succeeded

    def outcome(self, steps: int, seconds: float, diverged: bool = False) -> bytes:
        """The end of the training, as the job returns it."""
        outcome = Outcome(checks=tuple(self._checks), steps=steps, seconds=round(seconds, 2), diverged=diverged)
        return outcome.model_dump_json().encode()


def _earlier_checks(file: Path, path: Path) -> list[Check]:
    """The checks of a training that goes on, without those of steps that it does again."""
    from pipenav.learning.checkpoint import steps_done
    from pipenav.learning.training_folder import TrainingFolder

    try:
        found = _Checks.model_validate_json(checked_json(read_text(file), str(file)))
    except (PipenavError, ValidationError):
        return []
    done = steps_done(TrainingFolder(path).checkpoint)
    return [check for check in found.checks if check.steps <= done]
