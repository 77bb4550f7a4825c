"""Trials: every class of fittings simulated once with the policy, and kept on disk for all later surveys."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

import pipenav
from pipenav.arrays import Table
from pipenav.errors import PipenavError
from pipenav.evaluation.interval import Interval, wilson
from pipenav.jobs import Place, run_jobs
from pipenav.jobs.here import HerePlace
from pipenav.policies.policy import load_policy, resolve_policy
from pipenav.survey.class_store import ClassStore
from pipenav.survey.classes import FittingClass
from pipenav.survey.trained import Trained
from pipenav.survey.trial_jobs import TrialConfig, TrialCounts, TrialJobs

Verdict = Literal["navigable", "not navigable", "unknown"]

Report = Callable[[int, int, str], None]
"""Called with the number of classes that are done, of all of them, and the name of one that is worked on."""


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
    def assumed(self) -> bool:
        """Whether it stands for a trial that nobody ran, because its outcome is known."""
        return bool(self.episodes and self.reason)

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

IDEAL = Trial(episodes=1, successes=1, reason="a perfect policy, by --ideal: it passes what the robot's shape can pass")
"""Trial that stands for those of a perfect policy."""


class Trials:
    """Trials of classes with one policy, from the cache where they are in it.

    Args:
        config: what is tried.
        folder: folder in which trials are kept.
        place: where episodes run, by default this process; results are the same wherever it is.

    Raises:
        PipenavError: an unknown policy, or one that takes no whole robot through pipes.
    """

    def __init__(self, config: TrialConfig, folder: Path, place: Place | None = None) -> None:
        self.config = config
        path = resolve_policy(config.policy)
        policy = load_policy(path)
        self.robot = policy.header.robot
        self.trained = Trained.of(policy.header)
        if config.ideal:
            self.trained = self.trained._replace(sharpest_deg=0.0)
        self.policy_hash = hashlib.sha256(path.read_bytes()).hexdigest()
        self._place = place or HerePlace()
        self._store = ClassStore(folder, "trial", Trial)
        self._known: dict[FittingClass, Trial] = {}

    def results(self, classes: Iterable[FittingClass], report: Report | None = None) -> dict[FittingClass, Trial]:
        """The trials of classes; what is not in the cache is simulated, and kept as soon as it is done.

        Raises:
            JobsLost: trials were lost every time that they were tried; all others are kept.
            PipenavError: the simulator cannot run, or the cache cannot be written.
        """
        wanted = dict.fromkeys(classes)
        missing = [kind for kind in wanted if kind not in self._known and not self._settled(kind)]
        if missing:
            self._simulate(missing, report or (lambda _done, _total, _name: None))
        return {kind: self._known[kind] for kind in wanted}

    def _settled(self, kind: FittingClass) -> bool:
        """Whether a class needs no simulation; its trial is known then."""
        if refusal := self.trained.refusal(kind):
            self._known[kind] = Trial(episodes=0, successes=0, reason=refusal)
        elif kind.straight:
            self._known[kind] = STRAIGHT
        elif self.config.ideal:
            self._known[kind] = IDEAL
        elif (kept := self._store.read(kind, self._key(kind))) is not None:
            self._known[kind] = kept
        return kind in self._known

    def _key(self, kind: FittingClass) -> dict[str, Any]:
        config = self.config
        return {
            "schema": 1,
            "pipenav": pipenav.__version__,  # what counts as passed may change between versions
            "class": kind._asdict(),
            "policy_sha256": self.policy_hash,
            "robot": self.robot.name,
            "backend": config.backend,
            "options": dict(config.options),
            "episodes": config.episodes,
            "seed": config.seed,
        }

    def _simulate(self, classes: list[FittingClass], report: Report) -> None:
        """Run the episodes of some classes at the place."""
        done = 0

        def begun(kind: FittingClass) -> None:
            report(done, len(classes), kind.name)

        def finished(kind: FittingClass, outcome: TrialCounts | PipenavError) -> None:
            nonlocal done
            done += 1
            if isinstance(outcome, PipenavError):
                self._keep(kind, Trial(episodes=0, successes=0, reason=f"it cannot be simulated: {outcome}"))
            else:
                self._keep(kind, Trial(**outcome._asdict()))
            report(done, len(classes), kind.name if done < len(classes) else "")

        work = TrialJobs(self.config, begun, finished)
        run_jobs(self._place, work.jobs(classes), work.hear)

    def _keep(self, kind: FittingClass, trial: Trial) -> None:
        self._known[kind] = trial
        self._store.keep(kind, self._key(kind), trial)
