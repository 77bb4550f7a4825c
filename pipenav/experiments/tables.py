"""An experiment's numbers: per row and diameter the mean over seeds and their range, beside the thesis's figure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Literal, NamedTuple

from pipenav.evaluation.pipe_results import DiameterRecord, PipeRecord
from pipenav.evaluation.results import Evaluation
from pipenav.evaluation.thesis import thesis_rows
from pipenav.experiments.definition import Row, load_experiment
from pipenav.experiments.plan import ExperimentPlan, evaluations

ShownStage = Literal["locate", "reach", "rear", "whole"]
"""A stage of a passage, or `whole` for all that were run, together."""

SHOWN_STAGES: dict[str, tuple[ShownStage, ...]] = {
    "reach": ("reach",),
    "reach-rear": ("reach", "rear", "whole"),
    "locate": ("locate",),
    "passage": ("locate", "reach", "rear", "whole"),
}
"""Stages that an evaluation reports, by the stage it ran; `rear` is a share of the episodes in which `reach`
succeeded."""


class Spread(NamedTuple):
    """Success in percent over the seeds: mean, lowest and highest; and how many seeds."""

    mean: float
    low: float
    high: float
    seeds: int

    @property
    def text(self) -> str:
        if self.seeds == 1 or self.high - self.low < 0.05:
            return f"{self.mean:.1f}"
        return f"{self.mean:.1f} ({self.low:.1f}-{self.high:.1f})"


class Line(NamedTuple):
    """A row's figures of one stage.

    Attributes:
        label: label of the agent.
        table: the thesis's table, or empty.
        stage: the stage, see `SHOWN_STAGES`.
        ours: success over the seeds by diameter [mm]; without the diameters in which the stage was never tried.
        thesis: success [percent] by diameter [mm]; empty where it has none.
    """

    label: str
    table: str
    stage: ShownStage
    ours: dict[float, Spread]
    thesis: dict[float, float]

    @property
    def mean(self) -> float:
        """Mean over the diameters [percent]; NaN without any."""
        return sum(spread.mean for spread in self.ours.values()) / len(self.ours) if self.ours else float("nan")


class Result(NamedTuple):
    """Results of a row: its evaluations, one per seed, and its lines."""

    row: Row
    evaluations: list[Evaluation]
    lines: list[Line]

    def line(self, stage: ShownStage) -> Line:
        (line,) = (line for line in self.lines if line.stage == stage)
        return line

    @property
    def failures(self) -> Counter[str]:
        """Number of episodes of all seeds that ended by each reason."""
        total: Counter[str] = Counter()
        for evaluation in self.evaluations:
            for record in evaluation.pipes:
                total.update(record.failures)
        return total

    @property
    def episodes(self) -> int:
        return sum(evaluation.episodes for evaluation in self.evaluations)


def results(plan: ExperimentPlan, name: str) -> list[Result]:
    """The results of an experiment, row by row."""
    return [_result(row, evaluations(plan, row)) for row in load_experiment(name).rows]


def _result(row: Row, found: list[Evaluation]) -> Result:
    return Result(row, found, [_line(row, stage, found) for stage in SHOWN_STAGES[row.stage]])


def _line(row: Row, stage: ShownStage, found: Sequence[Evaluation]) -> Line:
    by_diameter: dict[float, list[float]] = {}
    for evaluation in found:
        for record in evaluation.diameters:
            share = _share(record, evaluation, stage)
            if share is not None:
                by_diameter.setdefault(record.diameter_mm, []).append(100 * share)
    ours = {d: Spread(sum(v) / len(v), min(v), max(v), len(v)) for d, v in by_diameter.items()}
    return Line(row.title, row.table or "", stage, ours, _thesis(row, stage))


def _share(record: DiameterRecord, evaluation: Evaluation, stage: ShownStage) -> float | None:
    if stage == "locate":
        return record.located_share
    if stage == "reach":
        return record.reach_success
    if stage == "rear":
        return record.rear_success
    pipes = [pipe for pipe in evaluation.pipes if pipe.diameter_mm == record.diameter_mm]
    return sum(pipe.successes for pipe in pipes) / sum(pipe.episodes for pipe in pipes)


class Counts(NamedTuple):
    """Attempts at a stage, and how many of them succeeded."""

    successes: int
    attempts: int


def stage_counts(record: PipeRecord, stage: ShownStage) -> Counts:
    """Attempts at a stage in a pipe."""
    if stage == "locate":
        return Counts(record.located or 0, record.episodes)
    if stage == "reach":
        return Counts(record.reach_successes or 0, record.reach_attempts or 0)
    if stage == "rear":
        return Counts(record.rear_successes or 0, record.rear_attempts or 0)
    return Counts(record.successes, record.episodes)


def pooled_counts(evaluations: Sequence[Evaluation], stage: ShownStage, diameter: float) -> Counts:
    """Attempts at a stage in all pipes of a diameter [mm], of all seeds together."""
    pipes = [record for one in evaluations for record in one.pipes if record.diameter_mm == diameter]
    counts = [stage_counts(record, stage) for record in pipes]
    return Counts(sum(one.successes for one in counts), sum(one.attempts for one in counts))


def _thesis(row: Row, stage: ShownStage) -> dict[float, float]:
    for known in thesis_rows():
        if (known.table, known.agent, known.stage) == (row.table, row.label, stage):
            return known.percent
    return {}
