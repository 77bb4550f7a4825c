"""Laws of the limits on commands, and the rules that stop an arm: at the threshold, and one step below it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.backends.safety import Bounds, Deadlines, Repeats, Stopped, limited, require_finite

counts = st.integers(0, 1023)
hostile = st.one_of(st.floats(allow_nan=False, allow_infinity=False), counts.map(float))


def bounds(lower: float, upper: float, step: float, slack: float) -> Bounds:
    return Bounds(np.array([lower]), np.array([upper]), np.array([step]), np.array([slack]))


some_bounds = st.builds(
    lambda limits, step, slack: bounds(*sorted(limits), step, slack),
    st.tuples(counts, counts),
    st.integers(1, 60),
    st.integers(0, 5),
)


@given(hostile, counts, counts, some_bounds)
def test_a_limited_goal_keeps_every_limit(goal: float, present: int, last: int, allowed: Bounds) -> None:
    lower, upper, step, slack = (values[0] for values in allowed)
    result = limited(np.array([goal]), np.array([present]), np.array([last]), allowed)
    if result.empty[0]:
        nearest = np.clip([last - step, last + step], lower, upper)
        assert lower > last + step or upper < last - step or (np.abs(nearest - present) > step + slack).all()
        return
    sent = result.set_points[0]
    assert lower <= sent <= upper
    assert abs(sent - last) <= step
    assert abs(sent - present) <= step + slack
    assert result.clamped[0] == (sent != goal)


@given(counts, counts, st.integers(1, 60))
def test_a_goal_within_all_limits_is_left_alone(last: int, goal: int, step: int) -> None:
    if abs(goal - last) <= step:
        result = limited(np.array([float(goal)]), np.array([last]), np.array([last]), bounds(0, 1023, step, 2))
        assert result.set_points[0] == goal
        assert not result.clamped[0]


@given(counts, counts, hostile, st.integers(1, 60))
def test_limiting_twice_is_limiting_once(last: int, present: int, goal: float, step: int) -> None:
    limits = bounds(0, 1023, step, 2)
    once = limited(np.array([goal]), np.array([present]), np.array([last]), limits)
    if not once.empty[0]:
        again = limited(once.set_points, np.array([present]), np.array([last]), limits)
        assert again.set_points[0] == once.set_points[0]
        assert not again.clamped[0]


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, "forwards", None, object(), [1, [2]]])
def test_what_is_no_number_stops_and_is_not_clamped(value: object) -> None:
    with pytest.raises(Stopped, match="not a finite number") as stopped:
        require_finite([0.0, value], "an action")  # type: ignore[list-item]
    assert stopped.value.cause == "not-finite"


def test_finite_values_pass_unchanged() -> None:
    assert require_finite([1e308, -5, 0], "an action").tolist() == [1e308, -5.0, 0.0]


def test_one_late_tick_is_counted_and_forgiven() -> None:
    deadlines = Deadlines(0.1)
    for taken in (0.01, 0.1, 0.1001, 0.01, 0.149, 0.02):
        deadlines.check(taken)
        deadlines.note(taken)
        deadlines.begin()
    assert deadlines.missed == 2


@pytest.mark.parametrize("ticks", [(0.151,), (0.101, 0.101), (0.01, 0.14, 0.11)])
def test_a_very_late_tick_or_two_late_ones_stop(ticks: tuple[float, ...]) -> None:
    deadlines = Deadlines(0.1)
    with pytest.raises(Stopped, match="a tick took") as stopped:
        for taken in ticks:
            deadlines.check(taken)
            deadlines.begin()
    assert stopped.value.cause == "deadline"


@given(st.lists(st.booleans(), max_size=30), st.integers(0, 5))
def test_a_rule_is_broken_after_more_than_the_allowed_breaches_in_a_row(breaches: list[bool], allowed: int) -> None:
    rule, row = Repeats(allowed), 0
    for breach in breaches:
        row = row + 1 if breach else 0
        assert rule.broken(breach) == (row > allowed)
