"""Maps to survey, and trials without a simulator: the evaluation is answered by a rule."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from pipenav.certify.verdict import Kind
from pipenav.jobs import MemoryStore
from pipenav.networks.draft import LineFacts, MapDraft
from pipenav.networks.model import NetworkMap
from pipenav.survey import trial_jobs
from pipenav.survey.classes import FittingClass
from pipenav.survey.findings import Finding, Findings
from pipenav.survey.possible import Possibility
from pipenav.survey.trial_jobs import TrialConfig
from pipenav.survey.trials import Report, Trial, Trials

Rule = Callable[[str], int]
"""Number of 20 episodes that pass, by the name of a class."""


def all_pass(_: str) -> int:
    """A robot that passes everything."""
    return 20


class Record(NamedTuple):
    """Counts of one pipe as an evaluation gives them."""

    episodes: int
    successes: int
    failures: dict[str, int]
    mean_steps: float | None


class AnsweredTrials(Trials):
    """Trials whose episodes are answered by a rule, and which are not kept; everything else is real."""

    def __init__(self, cache: Path, rule: Rule = all_pass, config: TrialConfig | None = None) -> None:
        super().__init__(config or TrialConfig("pirate"), cache)
        self.rule, self.simulated = rule, list[str]()

    def _simulate(self, classes: list[FittingClass], report: Report) -> None:
        for done, kind in enumerate(classes, 1):
            self.simulated.append(kind.name)
            passed = self.rule(kind.name)
            failures = {"slip": 20 - passed} if passed < 20 else {}
            self._known[kind] = Trial(episodes=20, successes=passed, failures=failures)
            report(done, len(classes), kind.name)


class AnsweredFindings(Findings):
    """Findings whose trials are answered by a rule; geometry is real."""

    def __init__(self, cache: Path, rule: Rule = all_pass, config: TrialConfig | None = None) -> None:
        super().__init__(config or TrialConfig("pirate"), cache)
        self.trials = AnsweredTrials(cache, rule, config)


def found(trial: Trial, geometry: Kind = "passable") -> Finding:
    """A finding with geometry's word on it."""
    return Finding(trial, Possibility(kind=geometry, reason="" if geometry == "passable" else "a reason"))


def answer_evaluations(monkeypatch: pytest.MonkeyPatch, rule: Rule = all_pass) -> list[Any]:
    """Let every evaluation of a survey be answered by a rule; gives the list of what was asked."""
    asked: list[Any] = []

    class Answered:
        count = 1

        def __init__(self, config: Any) -> None:
            asked.append(config)
            self._config, self.parts = config, self

        def key(self, index: int) -> str:
            return f"part-{index}"

        def part(self, _first: int, _end: int) -> str:
            return Path(self._config.pipes[0]).stem.rpartition("-")[0]

        def merged(self, store: MemoryStore) -> Any:
            passed = int(store.read("part-0") or b"")
            half = self._config.episodes
            counts = (min(passed, half), max(passed - half, 0))

            class Result(NamedTuple):
                pipes: Sequence[Record]

            return Result(
                [Record(half, n, {"slip": half - n} if n < half else {}, 70.0 if n else None) for n in counts]
            )

    monkeypatch.setattr(trial_jobs, "CheckedEvaluation", Answered)
    monkeypatch.setattr(trial_jobs, "run_part", lambda name, _control: str(rule(name)).encode())
    return asked


def map_of(
    points: Sequence[tuple[float, float, float]], lines: Sequence[tuple[int, int]], bore: float = 0.1
) -> NetworkMap:
    """A map of straight lines between points, whose nodes are called N0, N1 and so on."""
    draft = MapDraft("a map", "test")
    for i, point in enumerate(points):
        draft.node(f"N{i}", point, f"line {i}")
    for i, ends in enumerate(lines):
        draft.line(f"P{i}", ends, LineFacts(diameter=bore), place=f"line {i}")
    return draft.finish()


def random_tree(seed: int, nodes: int) -> NetworkMap:
    """A tree of mains of 100 mm with legs of 20 to 120 m."""
    rng = np.random.default_rng(seed)
    points, lines = [(0.0, 0.0, 0.0)], []
    for i in range(1, nodes):
        start = int(rng.integers(max(0, i - 4), i))
        around, length = rng.uniform(0, 2 * np.pi), rng.uniform(20, 120)
        x, y, _ = points[start]
        points.append((x + length * np.cos(around), y + length * np.sin(around), 0.0))
        lines.append((start, i))
    return map_of(points, lines)
