"""The objective ranks trainings as a person would."""

from __future__ import annotations

import pytest
from helpers.tuning import outcome
from hypothesis import given
from hypothesis import strategies as st

from pipenav.tuning.objective import FAILED, NEVER, Objective, Outcome

shares = st.integers(0, 100).map(lambda percent: percent / 100)
curves = st.lists(shares, min_size=1, max_size=20)


@pytest.mark.parametrize("name", ["steps", "seconds"])
@given(one=curves, other=curves)
def test_the_earlier_success_is_better_and_none_is_worst(name: str, one: list[float], other: list[float]) -> None:
    objective = Objective(name=name, success=0.9)
    firsts = [next((i for i, share in enumerate(curve) if share >= 0.9), None) for curve in (one, other)]
    here, there = objective.value(outcome(*one)), objective.value(outcome(*other))
    if None not in firsts:
        assert (here < there) == (firsts[0] < firsts[1])
    elif firsts == [None, None]:
        assert (here < there) == (max(one) > max(other))
    else:
        assert (here < NEVER <= there) if firsts[1] is None else (there < NEVER <= here)


@given(curves, curves)
def test_success_at_the_end_is_that_of_the_best_check(one: list[float], other: list[float]) -> None:
    objective = Objective(name="success")
    assert (objective.value(outcome(*one)) < objective.value(outcome(*other))) == (max(one) > max(other))
    assert objective.words(objective.value(outcome(*one))) == f"{100 * max(one):.1f}% success"


@pytest.mark.parametrize("name", ["steps", "seconds", "success"])
@given(curve=curves)
def test_what_diverges_is_behind_all_others(name: str, curve: list[float]) -> None:
    objective, found = Objective(name=name, success=1.0), outcome(*curve)
    broken = found.model_copy(update={"diverged": True})
    if max(curve) < 1.0 or name == "success":
        assert objective.value(broken) == FAILED > objective.value(found)
        assert objective.words(objective.value(broken)) == "diverged"
        assert not objective.reached(broken)


@given(curves)
def test_words_say_how_near_a_training_came(curve: list[float]) -> None:
    objective = Objective(name="steps", success=0.9)
    words = objective.words(objective.value(outcome(*curve)))
    assert words.endswith(" steps") if max(curve) >= 0.9 else words == f"never (best {100 * max(curve):.1f}%)"


@given(curves)
def test_an_outcome_comes_back_from_its_file(curve: list[float]) -> None:
    found = outcome(*curve)
    assert Outcome.model_validate_json(found.model_dump_json()) == found
