"""What keeps a real arm from harm: pure limits on what it is told, and rules that say when it must stop.

Limits shorten a command; they never replace a nonsensical one by a number. A rule that is broken raises `Stopped`,
which is final: whoever catches it switches torque off, and only a person starts again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pipenav.arrays import Flags, Floats
from pipenav.errors import PipenavError

DEADLINE = 1.0
"""Control periods in which a tick must have done its work; a longer one is counted as missed."""

LAST_DEADLINE = 1.5
"""Control periods after which a single late tick stops the arm; two missed in a row do so too."""


class Stopped(PipenavError):
    """The arm was stopped. Final for this run.

    Attributes:
        cause: one word for tables and logs, as `docs/hardware.md` explains it.
    """

    def __init__(self, cause: str, what: str, remedy: str) -> None:
        self.cause, self.what, self.remedy = cause, what, remedy
        super().__init__(f"stopped ({cause}): {what}; {remedy}.")


class Bounds(NamedTuple):
    """What a goal may be, in any unit, (joints,) each.

    Attributes:
        lower, upper: the joint limits.
        step: farthest from the last goal that the next one may be: the speed limit times the control period.
        slack: how much farther than `step` from where the joint is.
    """

    lower: Floats
    upper: Floats
    step: Floats
    slack: Floats


class Limited(NamedTuple):
    """A goal as it may be sent.

    Attributes:
        goal: (joints,); meaningless where `empty`.
        clamped: joints whose goal was changed, (joints,).
        empty: joints for which no goal would do, (joints,): they are farther from their last goal, or from their
            limits, than a step. Then nothing is sent, for any joint.
    """

    goal: Floats
    clamped: Flags
    empty: Flags


def require_finite(values: ArrayLike, what: str) -> Floats:
    """The values as an array of numbers.

    Raises:
        Stopped: any of them is no finite number. Clamping would turn it into a limit, and the arm would drive there.
    """
    try:
        array = np.asarray(values, float)
    except (TypeError, ValueError):
        array = np.array([np.nan])
    if not np.isfinite(array).all():
        raise Stopped(
            "not-finite", f"{what} is not a finite number", "the policy or its input is broken: do not use it"
        )
    return array


def limited(goal: Floats, present: Floats, last: Floats, bounds: Bounds) -> Limited:
    """The goal within the joint limits, a step from the last goal, and a step and the slack from where the joint is.

    Args:
        goal: finite, (joints,).
        present: where the joints are, (joints,).
        last: the goal before, (joints,).
        bounds: in the same units.
    """
    reach = bounds.step + bounds.slack
    low = np.maximum.reduce([bounds.lower, last - bounds.step, present - reach])
    high = np.minimum.reduce([bounds.upper, last + bounds.step, present + reach])
    allowed = np.clip(goal, low, high)
    return Limited(allowed, allowed != goal, low > high)


class Deadlines:
    """Counts ticks that were late, and stops the arm when that is no accident any more.

    Attributes:
        missed: how many were late.
    """

    def __init__(self, period: float, patience: float = 1.0) -> None:
        self._limit, self._last = DEADLINE * period * patience, LAST_DEADLINE * period * patience
        self.missed = 0
        self._late = self._late_before = False

    def begin(self) -> None:
        """The next tick."""
        self._late, self._late_before = False, self._late

    def note(self, taken: float) -> None:
        """Something of the tick was done `taken` seconds after it was due; however often, a tick is late once."""
        if taken > self._limit and not self._late:
            self._late = True
            self.missed += 1

    def check(self, taken: float) -> None:
        """Whether a tick may go on `taken` seconds after it was due.

        Raises:
            Stopped: much too late, or late twice in a row.
        """
        self.note(taken)
        if taken > self._last or (self._late and self._late_before):
            raise Stopped(
                "deadline",
                f"a tick took {taken * 1e3:.0f} ms, {self._limit * 1e3:.0f} ms are allowed "
                f"({self.missed} missed in all)",
                "end other programs on this machine, and see the bus latency in pipenav hw-check",
            )


class Repeats:
    """A rule that may be broken for a while: `allowed` checks in a row are forgiven, the next one is not."""

    def __init__(self, allowed: int) -> None:
        self._allowed, self._count = allowed, 0

    def broken(self, now: bool) -> bool:
        """Whether the rule is broken for good, given whether it is broken now."""
        self._count = self._count + 1 if now else 0
        return self._count > self._allowed
