"""The ladder of outcomes: every one that can end an episode has a rung, and the strongest that holds counts."""

from __future__ import annotations

from random import Random

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pipenav.tasks.outcome import LADDER, Outcome, strongest_outcome

cases = st.lists(st.frozensets(st.sampled_from(LADDER)), max_size=8)
"""For each of some episodes, the outcomes that hold in it."""


def test_every_outcome_that_ends_an_episode_has_one_rung() -> None:
    assert sorted(LADDER) == sorted(set(Outcome) - {Outcome.RUNNING})


@given(cases, st.randoms())
def test_the_strongest_that_holds_counts_in_whatever_order_they_are_given(
    episodes: list[frozenset[Outcome]], rng: Random
) -> None:
    held = list(frozenset().union(*episodes))
    rng.shuffle(held)
    holds = {outcome: np.array([outcome in those for those in episodes], bool) for outcome in held}
    found = [Outcome(value) for value in strongest_outcome(len(episodes), holds)]
    assert found == [max(those, key=LADDER.index, default=Outcome.RUNNING) for those in episodes]


def test_a_failure_beats_a_success_and_a_success_beats_the_end_of_time() -> None:
    both = np.array([True, True])
    sank = np.array([True, False])
    holds = {Outcome.TIMEOUT: both, Outcome.REACHED: both, Outcome.PENETRATION: sank}
    assert strongest_outcome(2, holds).tolist() == [Outcome.PENETRATION, Outcome.REACHED]
