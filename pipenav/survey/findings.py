"""Everything that is known of classes: what the policy did in trials, and what geometry says of the robot's shape."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Literal, NamedTuple

from pipenav.jobs import Place
from pipenav.robots.robot import RobotSpec
from pipenav.survey.classes import FittingClass
from pipenav.survey.possible import Possibilities, Possibility
from pipenav.survey.trained import Trained
from pipenav.survey.trial_jobs import TrialConfig
from pipenav.survey.trials import Trial, Trials, Verdict

Cause = Literal["", "impossible", "policy", "undecided", "untried", "episodes", "map"]
"""Cause of a verdict other than navigable: a proof that no policy passes; the policy, which fails where a motion was
found; the policy, or the passage between boards, where geometry decides nothing; nobody tried; too few episodes; the
map, which makes it no class."""

Progress = Callable[[str, int, int], None]
"""Called with words for what is done, and how much of how much."""


class Finding(NamedTuple):
    """Findings about a class."""

    trial: Trial
    geometry: Possibility

    def verdict(self, confidence: float) -> Verdict:
        """The verdict: a proof outdoes any trial, and a passage between boards counts where a round bore allows it."""
        if self.geometry.kind == "impossible":
            return "not navigable"
        verdict = self.trial.verdict(confidence)
        return "unknown" if verdict == "navigable" and self.geometry.kind == "undecided" else verdict

    def cause(self, confidence: float) -> Cause:
        """Cause of the verdict."""
        verdict = self.verdict(confidence)
        if verdict == "navigable":
            return ""
        if self.geometry.kind == "impossible":
            return "impossible"
        if not self.trial.episodes:
            return "untried"
        if verdict == "not navigable":
            return "policy" if self.geometry.kind == "passable" else "undecided"
        return "undecided" if self.trial.verdict(confidence) == "navigable" else "episodes"

    def reason(self, confidence: float) -> str:
        """Cause of the verdict in words."""
        why, passable = self.geometry.reason, self.geometry.kind == "passable"
        match self.cause(confidence):
            case "impossible":
                return f"no policy passes, {why}"
            case "policy":
                return "the policy fails; the robot's shape can pass"
            case "undecided" if self.verdict(confidence) == "not navigable":
                return f"the policy fails; whether the robot's shape can pass is open: {why}"
            case "undecided":
                return f"it passes between boards; whether it can in a round bore is open: {why}"
            case "untried":
                return f"{self.trial.reason}; {'its shape can pass' if passable else f'geometry leaves it open: {why}'}"
            case "episodes":
                return "its trials leave open whether it passes often enough: try more --episodes"
            case _:
                return ""


class Findings:
    """Findings about classes, for one policy.

    Args:
        config: what is tried.
        folder: folder in which results are kept.
        place: where they are found, by default this process; they are the same wherever that is.

    Raises:
        PipenavError: an unknown policy, or one that takes no whole robot through pipes.
    """

    def __init__(self, config: TrialConfig, folder: Path, place: Place | None = None) -> None:
        self.folder = folder
        self.trials = Trials(config, folder, place)
        self.geometry = Possibilities(self.trials.robot, folder, place)

    @property
    def robot(self) -> RobotSpec:
        """The policy's robot."""
        return self.trials.robot

    @property
    def trained(self) -> Trained:
        """Range of pipes that the policy was trained in."""
        return self.trials.trained

    def of(self, classes: Iterable[FittingClass], progress: Progress | None = None) -> dict[FittingClass, Finding]:
        """Findings about classes, in their order.

        Raises:
            JobsLost: some were lost every time that they were tried; all others are kept.
            PipenavError: the simulator cannot run, or the cache cannot be written.
        """
        wanted = sorted(set(classes))

        def report(doing: str) -> Callable[[int, int, str], None]:
            def told(done: int, total: int, name: str) -> None:
                if progress is not None:
                    progress(f"{doing} {name}" if name else f"{doing} classes", done, total)

            return told

        shapes = self.geometry.results(wanted, report("certifying"))
        tried = self.trials.results(wanted, report("trying"))
        return {kind: Finding(tried[kind], shapes[kind]) for kind in wanted}
