"""Trials: every class of fittings simulated once with the policy, and kept on disk for all later surveys."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

from pydantic import Field, JsonValue, ValidationError

import pipenav
from pipenav.arrays import Table
from pipenav.errors import PipenavError
from pipenav.evaluation.config import EvaluationConfig
from pipenav.evaluation.evaluate import CheckedEvaluation
from pipenav.evaluation.interval import Interval, wilson
from pipenav.pipes.route_sets import parse_pipes
from pipenav.policies.header import PolicyHeader
from pipenav.policies.policy import load_policy, resolve_policy
from pipenav.storage.atomic_files import atomic_write, prepare_folder
from pipenav.storage.temporary import temporary_folder
from pipenav.storage.text_files import read_text
from pipenav.survey.classes import FittingClass
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.units import m_to_mm, rad_to_deg

Verdict = Literal["navigable", "not navigable", "unknown"]

MAX_TRIAL = 64 << 10
"""Largest file of a trial [bytes]."""

Report = Callable[[int, int, str], None]
"""Called with the number of trials that are done, of all of them, and the name of the last one."""


class TrialConfig(NamedTuple):
    """Everything besides the class that decides what a trial gives.

    Attributes:
        policy: shipped policy or FILE.zip.
        backend: name of a simulator.
        options: its own settings.
        episodes: episodes in each class, half of them to either side.
        seed: seed of the starts.
    """

    policy: str
    backend: str = "mujoco"
    options: Mapping[str, JsonValue] = {}  # never changed
    episodes: int = 20
    seed: int = 0


class Trial(Table):
    """Outcome of a class's trial.

    Attributes:
        episodes: episodes that were run; 0 where the class was not tried.
        successes: episodes in which the robot passed.
        failures: number of episodes by the reason of their failure.
        mean_steps: mean control steps of a passage; None without one.
        reason: why the class was not tried, or where the rate comes from.
    """

    episodes: int = Field(ge=0)
    successes: int = Field(ge=0)
    failures: dict[str, int] = Field(default_factory=dict)
    mean_steps: float | None = None
    reason: str = ""

    @property
    def rate(self) -> float | None:
        """Share of episodes that passed, None where the class was not tried."""
        return self.successes / self.episodes if self.episodes else None

    @property
    def interval(self) -> Interval:
        """The 95 % interval of that share; everything where the class was not tried."""
        return wilson(self.successes, self.episodes)

    def verdict(self, confidence: float) -> Verdict:
        """Whether the robot passes with a probability of at least `confidence`; unknown where that is undecided."""
        if not self.episodes:
            return "unknown"
        if self.successes / self.episodes >= confidence:
            return "navigable"
        return "not navigable" if self.interval.high < confidence else "unknown"


STRAIGHT = Trial(episodes=1, successes=1, reason="a straight pipe, as on every route that the policy was trained in")
"""Trial that stands for a straight pipe."""


class Trained(NamedTuple):
    """Range of pipes that a policy was trained in.

    Attributes:
        bores_mm: least and largest inner diameter.
        sharpest_deg: sharpest interior angle.
        inclined: whether it was trained under gravity along the pipe.
    """

    bores_mm: tuple[float, float]
    sharpest_deg: float
    inclined: bool

    @classmethod
    def of(cls, header: PolicyHeader) -> Trained:
        """The range of a policy's training pipes.

        Raises:
            PipenavError: the policy takes no whole robot through pipes.
        """
        task = header.task
        if not isinstance(task, TraverseConfig):
            raise PipenavError(
                f"the policy was made for {header.robot.name!r}, which passes no pipe as a whole: choose one that "
                "does, such as --policy pirate."
            )
        bores, sharpest = _range_of(header.train_pipes)
        return cls(bores, sharpest, task.inclination_deg is not None)

    def refusal(self, kind: FittingClass) -> str:
        """Reason why a class lies outside of what the policy was trained in; empty where it does not."""
        low, high = self.bores_mm
        for bore in (kind.bore_mm, kind.to_mm):
            if bore and not low <= bore <= high:
                return f"a bore of {bore:g} mm lies outside of the {low:g}-{high:g} mm that the policy was trained in"
        if kind.kind == "bend" and kind.angle_deg < self.sharpest_deg:
            return f"{kind.angle_deg:g} deg is sharper than the {self.sharpest_deg:g} deg that it was trained in"
        if kind.incline_deg and not self.inclined:
            return f"the policy was trained in level pipes, this one climbs by {kind.incline_deg:g} deg"
        return ""


@cache
def _range_of(pipes: tuple[str, ...]) -> tuple[tuple[float, float], float]:
    """Least and largest bore [mm] and sharpest interior angle [deg] of sets of pipes."""
    made = parse_pipes(pipes)
    bores = [m_to_mm(pipe.diameter) for pipe in made]
    return (min(bores), max(bores)), min(rad_to_deg(float(pipe.interior_angles.min())) for pipe in made)


def default_cache() -> Path:
    """Folder of trials where no other is named: `pipenav/trials` in the user's folder for caches."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "pipenav" / "trials"


class Trials:
    """Trials of classes with one policy, from the cache where they are in it.

    Args:
        config: what is tried.
        folder: folder in which trials are kept.

    Raises:
        PipenavError: an unknown policy, or one that takes no whole robot through pipes.
    """

    def __init__(self, config: TrialConfig, folder: Path) -> None:
        self.config = config
        path = resolve_policy(config.policy)
        policy = load_policy(path)
        self.robot = policy.header.robot.name
        self.trained = Trained.of(policy.header)
        self.policy_hash = hashlib.sha256(path.read_bytes()).hexdigest()
        self._folder = folder
        self._known: dict[FittingClass, Trial] = {}

    def results(self, classes: Iterable[FittingClass], report: Report | None = None) -> dict[FittingClass, Trial]:
        """The trials of classes; what is not in the cache is simulated, and kept as soon as it is done.

        Raises:
            PipenavError: the simulator cannot run, or the cache cannot be written.
        """
        wanted = dict.fromkeys(classes)
        missing = [kind for kind in wanted if kind not in self._known and not self._settled(kind)]
        for done, kind in enumerate(missing):
            if report is not None:
                report(done, len(missing), kind.name)
            self._known[kind] = trial = self._simulated(kind)
            self._keep(kind, trial)
        if report is not None and missing:
            report(len(missing), len(missing), "")
        return {kind: self._known[kind] for kind in wanted}

    def _settled(self, kind: FittingClass) -> bool:
        """Whether a class needs no simulation; its trial is known then."""
        if refusal := self.trained.refusal(kind):
            self._known[kind] = Trial(episodes=0, successes=0, reason=refusal)
        elif kind.straight:
            self._known[kind] = STRAIGHT
        elif (kept := self._kept(kind)) is not None:
            self._known[kind] = kept
        return kind in self._known

    def _key(self, kind: FittingClass) -> dict[str, Any]:
        config = self.config
        return {
            "schema": 1,
            "pipenav": pipenav.__version__,  # what counts as passed may change between versions
            "class": kind._asdict(),
            "policy_sha256": self.policy_hash,
            "robot": self.robot,
            "backend": config.backend,
            "options": dict(config.options),
            "episodes": config.episodes,
            "seed": config.seed,
        }

    def _file(self, kind: FittingClass) -> Path:
        text = json.dumps(self._key(kind), sort_keys=True)
        return self._folder / f"{kind.name}-{hashlib.sha256(text.encode()).hexdigest()[:16]}.json"

    def _kept(self, kind: FittingClass) -> Trial | None:
        """The trial in the cache; None where there is none that can be read."""
        file = self._file(kind)
        if not file.is_file():
            return None
        try:
            record = json.loads(read_text(file, MAX_TRIAL))
            return Trial.model_validate(record["trial"]) if record["key"] == self._key(kind) else None
        except (PipenavError, ValueError, KeyError, TypeError, ValidationError):
            return None  # it is simulated again

    def _keep(self, kind: FittingClass, trial: Trial) -> None:
        record = {"key": self._key(kind), "trial": trial.model_dump()}
        atomic_write(prepare_folder(self._folder) / self._file(kind).name, json.dumps(record, indent=1) + "\n")

    def _simulated(self, kind: FittingClass) -> Trial:
        """The class's episodes, half of them to either side; a class that the simulator cannot make is not tried."""
        config = self.config
        with temporary_folder("trial") as folder:
            pipes = [str(folder / f"{kind.name}-{turn}.toml") for turn in ("left", "right")]
            for turn, path in zip(("left", "right"), pipes, strict=True):
                Path(path).write_text(kind.toml(turn), encoding="utf-8")
            try:
                checked = CheckedEvaluation(
                    EvaluationConfig(
                        policy=config.policy,
                        pipes=tuple(pipes),
                        episodes=max(config.episodes // 2, 1),
                        seed=config.seed,
                        backend=config.backend,
                        options=dict(config.options),
                    )
                )
            except PipenavError as error:
                return Trial(episodes=0, successes=0, reason=f"it cannot be simulated: {error}")
            records = checked.run().pipes
        steps = [record.mean_steps for record in records if record.mean_steps is not None]
        failures: dict[str, int] = {}
        for record in records:
            for reason, count in record.failures.items():
                failures[reason] = failures.get(reason, 0) + count
        return Trial(
            episodes=sum(record.episodes for record in records),
            successes=sum(record.successes for record in records),
            failures=failures,
            mean_steps=sum(steps) / len(steps) if steps else None,
        )
