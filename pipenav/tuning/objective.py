"""The objective of a search: what came of a training, as one number of which less is better."""

from __future__ import annotations

from typing import Literal, NamedTuple

from pydantic import Field

from pipenav.arrays import Table

ObjectiveName = Literal["steps", "seconds", "success"]

NEVER = 1e13
"""Number that counts for a training that never comes to a success: more than steps or seconds of any training."""

FAILED = 3 * NEVER
"""Number of a training that ended at values that are not finite, behind all others."""


class Check(NamedTuple):
    """A noise-free check during a training.

    Attributes:
        steps: control steps before it.
        seconds: seconds of training before it.
        success: share of its episodes that reached their target.
    """

    steps: int
    seconds: float
    success: float


class Outcome(Table):
    """The end of a trial's training, in numbers.

    A training that went on to its last step ends with a check, whose success is that of its best policy.
    """

    checks: tuple[Check, ...] = Field((), strict=False, description="checks that measure what the last one measures")
    steps: int = Field(ge=0, description="control steps that were done")
    seconds: float = Field(ge=0, description="seconds of training")
    diverged: bool = Field(False, description="whether it ended at values that are not finite")

    @property
    def success(self) -> float:
        """Success of the best check; 0 where there was none."""
        return max((check.success for check in self.checks), default=0.0)


class Objective(Table):
    """The number that a search makes small.

    `steps` and `seconds` are those of a training before its first check with at least `success`; the training ends
    there. `success` is the share of failures of a whole training's best policy.
    """

    name: ObjectiveName = "steps"
    success: float = Field(0.99, ge=0, le=1, description="share of a check's episodes that counts as a success")

    @property
    def ends_early(self) -> bool:
        """Whether nothing is to be learned from a training after its first success."""
        return self.name != "success"

    def first_success(self, outcome: Outcome) -> Check | None:
        """The first check that counts as a success, if there is one."""
        return next((check for check in outcome.checks if check.success >= self.success), None)

    def value(self, outcome: Outcome) -> float:
        """The number of a training. Those that never come to a success are behind all others, the nearest first."""
        if self.name == "success":
            return FAILED if outcome.diverged else 1.0 - outcome.success
        found = self.first_success(outcome)
        if found is not None:
            return float(found.steps if self.name == "steps" else found.seconds)
        return FAILED if outcome.diverged else NEVER * (1.0 + self.success - outcome.success)

    def reached(self, outcome: Outcome) -> bool:
        """Whether the number is one for people, and not one of those that only rank."""
        return self.value(outcome) < NEVER

    def words(self, value: float) -> str:
        """A number in words: `84,480 steps`."""
        if value >= FAILED:
            return "diverged"
        if value >= NEVER:
            return f"never (best {100 * (1.0 + self.success - value / NEVER):.1f}%)"
        if self.name == "success":
            return f"{100 * (1.0 - value):.1f}% success"
        return f"{value:,.0f} steps" if self.name == "steps" else f"{value:.1f} s"

    @property
    def title(self) -> str:
        """The objective in words: `steps to 99% success`."""
        return "success at the end" if self.name == "success" else f"{self.name} to {100 * self.success:g}% success"
