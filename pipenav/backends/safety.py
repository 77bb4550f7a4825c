"""Safety of a real arm: pure functions that limit set-points, and rules that decide when the arm must stop.

Limits shorten a command; they never replace a nonsensical one by a number. A rule that is broken raises `Stopped`,
which is final: its handler switches torque off, and only a person starts again.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pipenav.arrays import Flags, Floats
from pipenav.errors import PipenavError

DEADLINE = 1.0
"""Duration within which a tick must have done its work [control periods]; a longer tick is counted as missed."""

LAST_DEADLINE = 1.5
"""Duration after which a single late tick stops the arm [control periods]; two missed in a row do so too."""


class Stopped(PipenavError):
    """The arm was stopped, which is final for this mission.

    Attributes:
        cause: word for tables and logs, as `docs/guides/the-arm.md` explains it.
        what: what happened.
        remedy: what to do about it.
        unconfirmed: joints whose torque may still be on.
    """

    def __init__(self, cause: str, what: str, remedy: str, unconfirmed: Sequence[str] = ()) -> None:
        self.cause, self.what, self.remedy, self.unconfirmed = cause, what, remedy, list(unconfirmed)
        super().__init__(f"stopped ({cause}): {what}; {remedy}.")

    def __str__(self) -> str:
        return " ".join([*self.args, *([torque_warning(self.unconfirmed)] if self.unconfirmed else [])])


class TorqueUnconfirmed(Stopped):
    """Torque could not be confirmed off, after an ending that was no stop."""

    def __init__(self, joints: Sequence[str], what: str = "not every servo confirmed that its torque is off") -> None:
        super().__init__("torque", what, "check supply and cables, then run pipenav hw-check", joints)


def torque_warning(joints: Sequence[str]) -> str:
    """Sentence about joints whose torque could not be confirmed off."""
    return f"Torque may still be on at {', '.join(joints)}: switch the supply off before touching the arm."


class Bounds(NamedTuple):
    """Bounds on set-points, in any unit, (joints,) each.

    Attributes:
        lower, upper: joint limits.
        step: largest distance between the last set-point and the next: the speed limit times the control period.
        slack: distance by which a set-point may be farther than `step` from the joint's position.
    """

    lower: Floats
    upper: Floats
    step: Floats
    slack: Floats


class Limited(NamedTuple):
    """Set-points within their bounds.

    Attributes:
        set_points: set-points that may be sent, (joints,); meaningless where `empty`.
        clamped: joints whose set-point was changed, (joints,).
        empty: joints for which no set-point is within the bounds, (joints,): they are farther from their last
            set-point, or from their limits, than a step. Then nothing is sent, for any joint.
    """

    set_points: Floats
    clamped: Flags
    empty: Flags


def require_finite(values: ArrayLike, what: str) -> Floats:
    """Values as an array of finite numbers.

    Raises:
        Stopped: a value is no finite number. Clamping would turn it into a limit, and the arm would move there.
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


def limited(set_points: Floats, present: Floats, last: Floats, bounds: Bounds) -> Limited:
    """Limit set-points to the joint limits, a step from the last ones, and a step and the slack from the joints.

    Args:
        set_points: set-points that are wanted, finite, (joints,).
        present: positions of the joints, (joints,).
        last: set-points before these, (joints,).
        bounds: bounds in the same units.
    """
    reach = bounds.step + bounds.slack
    low = np.maximum.reduce([bounds.lower, last - bounds.step, present - reach])
    high = np.minimum.reduce([bounds.upper, last + bounds.step, present + reach])
    allowed = np.clip(set_points, low, high)
    return Limited(allowed, allowed != set_points, low > high)


class Deadlines:
    """Counts late ticks, and stops the arm when they are too late or too many in a row.

    Args:
        period: control period [s].
        patience: factor on both deadlines.

    Attributes:
        missed: number of late ticks.
    """

    def __init__(self, period: float, patience: float = 1.0) -> None:
        self._limit, self._last = DEADLINE * period * patience, LAST_DEADLINE * period * patience
        self.missed = 0
        self._late = self._late_before = False

    def begin(self) -> None:
        """Begin the next tick."""
        self._late, self._late_before = False, self._late

    def note(self, taken: float) -> None:
        """Note that a part of the tick was done `taken` seconds after the tick was due; a tick counts as late once."""
        if taken > self._limit and not self._late:
            self._late = True
            self.missed += 1

    def check(self, taken: float) -> None:
        """Check that a tick may go on `taken` seconds after it was due.

        Raises:
            Stopped: it is much too late, or late after another late tick.
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
    """A rule that may be broken for a while: `allowed` breaches in a row are forgiven, the next one is not."""

    def __init__(self, allowed: int) -> None:
        self._allowed, self._count = allowed, 0

    def broken(self, now: bool) -> bool:
        """Whether the rule is broken for good, given whether it is broken now."""
        self._count = self._count + 1 if now else 0
        return self._count > self._allowed
