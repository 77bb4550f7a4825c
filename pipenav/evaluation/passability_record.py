"""Passability of pipes and episodes in eval.json. docs/formats/evaluation-folder.md describes the format."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Self

from pydantic import computed_field

from pipenav.evaluation.interval import Interval, wilson
from pipenav.evaluation.passability import Answer
from pipenav.evaluation.record import Count, Record, Share

Verdict = Literal["passable", "impossible", "undecided"]


class Chances(Record):
    """Episodes by the chance that geometry gave them; together they are all episodes.

    Attributes:
        possible: episodes that succeeded, and failed ones for which there is a motion of rigid bodies.
        possible_with_overlap: failed episodes that only bodies with the allowed overlap have a motion for.
        undecided: failed episodes with neither a motion nor a proof.
        impossible: failed episodes for which it is proven that there is no motion, even with the allowed overlap.
        gaps: failed episodes among the possible ones: it was the policy, and not the pipe.
        contradictions: successes in pipes that are proven impossible with the allowed overlap; a proof would be wrong.
    """

    possible: Count
    possible_with_overlap: Count
    undecided: Count
    impossible: Count
    gaps: Count
    contradictions: Count

    @property
    def successes(self) -> int:
        """Episodes that succeeded."""
        return self.possible - self.gaps

    @property
    def episodes(self) -> int:
        """Number of all episodes."""
        return self.possible + self.possible_with_overlap + self.undecided + self.impossible

    @property
    def of_possible(self) -> Interval:
        """95 % interval of the success of the possible episodes."""
        return wilson(self.successes, self.possible)

    @classmethod
    def of(cls, parts: Sequence[Chances]) -> Self:
        """The episodes of several pipes together."""
        return cls(**{name: sum(getattr(part, name) for part in parts) for name in Chances.model_fields})


class PipePassability(Chances):
    """Verdicts on one pipe, and the chances of its episodes.

    Attributes:
        verdict: verdict of geometry for rigid bodies.
        verdict_with_overlap: verdict with the overlap that the task allows.
        reason: reason, in words.
    """

    verdict: Verdict
    verdict_with_overlap: Verdict
    reason: str

    @classmethod
    def on(cls, answer: Answer, successes: int) -> Self:
        """The verdicts on a pipe in which so many episodes succeeded."""
        failed = answer.failed
        gaps = failed.get("possible", 0)
        return cls(
            verdict=answer.verdict,
            verdict_with_overlap=answer.verdict_with_overlap,
            reason=answer.reason,
            possible=successes + gaps,
            possible_with_overlap=failed.get("with_overlap", 0),
            undecided=failed.get("undecided", 0),
            impossible=failed.get("impossible", 0),
            gaps=gaps,
            contradictions=successes if answer.verdict_with_overlap == "impossible" else 0,
        )


class Passability(Chances):
    """Chances of all episodes of an evaluation.

    Attributes:
        success_of_possible: share of the possible episodes that succeeded; None where none was possible.
        success_of_possible_low, success_of_possible_high: its 95 % interval.
        success_of_not_impossible: the share of all episodes that succeeded but those proven impossible.
    """

    @computed_field  # type: ignore[prop-decorator]  # mypy knows no decorated properties
    @property
    def success_of_possible(self) -> Share | None:
        """Share of the possible episodes that succeeded."""
        return self.successes / self.possible if self.possible else None

    @computed_field  # type: ignore[prop-decorator]
    @property
    def success_of_possible_low(self) -> float:
        """Lower end of the 95 % interval of that share."""
        return self.of_possible.low

    @computed_field  # type: ignore[prop-decorator]
    @property
    def success_of_possible_high(self) -> float:
        """Upper end of the 95 % interval of that share."""
        return self.of_possible.high

    @computed_field  # type: ignore[prop-decorator]
    @property
    def success_of_not_impossible(self) -> Share | None:
        """Share of the episodes not proven impossible that succeeded: those without a verdict count as possible."""
        left = self.episodes - self.impossible
        return self.successes / left if left else None
