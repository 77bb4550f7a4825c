"""The episodes of trials as jobs: parts of one evaluation for each class, which any process on any machine can run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from pydantic import JsonValue

from pipenav.errors import PipenavError
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.parts import run_part
from pipenav.jobs import Done, Event, Job, MemoryStore
from pipenav.storage.temporary import temporary_folder
from pipenav.survey.classes import FittingClass


class TrialConfig(NamedTuple):
    """Everything besides the class that decides what a trial gives.

    Attributes:
        policy: shipped policy or FILE.zip.
        backend: name of a simulator.
        options: its own config.
        episodes: episodes in each class, half of them to either side.
        seed: seed of the starts.
        ideal: take a perfect policy in place of the trials, which passes whatever the robot's shape can pass.
    """

    policy: str
    backend: str = "mujoco"
    options: Mapping[str, JsonValue] = {}  # never changed
    episodes: int = 20
    seed: int = 0
    ideal: bool = False


class TrialCounts(NamedTuple):
    """Counts of a class's episodes, to both sides: see `pipenav.survey.trials.Trial`."""

    episodes: int
    successes: int
    failures: dict[str, int]
    mean_steps: float | None


@dataclass
class _Evaluated:
    """A class whose evaluation runs: the keys of its parts that have not ended, and the others' results."""

    kind: FittingClass
    checked: CheckedEvaluation
    left: set[str]
    store: MemoryStore = field(default_factory=MemoryStore)


class TrialJobs:
    """Jobs for the episodes of classes.

    Args:
        config: what is evaluated.
        begun: called with a class when its jobs are made.
        finished: called with a class and its counts, or with the reason why the simulator cannot make it.
    """

    def __init__(
        self,
        config: TrialConfig,
        begun: Callable[[FittingClass], None],
        finished: Callable[[FittingClass, TrialCounts | PipenavError], None],
    ) -> None:
        self._config, self._begun, self._finished = config, begun, finished
        self._evaluated: dict[str, tuple[_Evaluated, str]] = {}

    def jobs(self, classes: Iterable[FittingClass]) -> Iterator[Job]:
        """A job for each part of each class's evaluation, made when a slot is free for it."""
        for kind in classes:
            self._begun(kind)
            try:
                checked = evaluation_of(kind, self._config)
            except PipenavError as error:
                self._finished(kind, error)
                continue
            parts = checked.parts
            this = _Evaluated(kind, checked, {parts.key(index) for index in range(parts.count)})
            for index in range(parts.count):
                key = f"{kind.name}-{parts.key(index)}"
                self._evaluated[key] = (this, parts.key(index))
                yield Job(key, f"trial of {kind.name}", run_part, parts.part(index, index + 1))

    def hear(self, event: Event) -> None:
        """Hear of one of the jobs; when the last one of a class is done, its episodes are counted."""
        if not isinstance(event, Done):
            return
        this, part = self._evaluated.pop(event.job.key)
        this.store.write(part, event.content)
        this.left.discard(part)
        if not this.left:
            self._finished(this.kind, _counts(this.checked, this.store))


def evaluation_of(kind: FittingClass, config: TrialConfig) -> CheckedEvaluation:
    """The evaluation of a class, half of its episodes to either side.

    Raises:
        PipenavError: the simulator cannot make the class, or the policy does not fit.
    """
    with temporary_folder("trial") as folder:
        pipes = [folder / f"{kind.name}-{turn}.toml" for turn in ("left", "right")]
        for turn, path in zip(("left", "right"), pipes, strict=True):
            Path(path).write_text(kind.toml(turn), encoding="utf-8")
        return CheckedEvaluation(
            EvaluationConfig(
                policy=config.policy,
                pipes=tuple(map(str, pipes)),
                episodes=max(config.episodes // 2, 1),
                seed=config.seed,
                backend=config.backend,
                options=dict(config.options),
            )
        )


def _counts(checked: CheckedEvaluation, store: MemoryStore) -> TrialCounts:
    records = checked.merged(store).pipes
    steps = [record.mean_steps for record in records if record.mean_steps is not None]
    failures: dict[str, int] = {}
    for record in records:
        for reason, count in record.failures.items():
            failures[reason] = failures.get(reason, 0) + count
    return TrialCounts(
        episodes=sum(record.episodes for record in records),
        successes=sum(record.successes for record in records),
        failures=failures,
        mean_steps=sum(steps) / len(steps) if steps else None,
    )
