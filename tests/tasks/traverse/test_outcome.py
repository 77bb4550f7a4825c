"""Ends of traverses, and their rewards."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.traversing import CONFIG, ROBOT

from pipenav.backends.messages import Reading, Truth
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.traverse.config import TraverseReward
from pipenav.tasks.traverse.outcome import OutcomeTracker, StepFacts, Whereabouts, reward


class Course:
    """A robot that is led along a straight line by hand, and the outcome of every step."""

    def __init__(self, **config: object) -> None:
        self.config = CONFIG.model_copy(update={"patience": 3, **config})
        self._tracker, self._steps = OutcomeTracker(ROBOT, self.config, 1), np.zeros(1, int)
        self._start = np.linspace(-1.0, -0.4, 8)[None]
        self._tracker.start(np.arange(1), self._start, np.ones(1))

    def step(self, moved: float, depth: float = 0.0, spin: float = 0.0, q: float = 0.0, **where: bool) -> Outcome:
        along = self._start + moved
        if where.get("fold"):
            along[:, -1] = along[:, 0]
        in_branch = np.zeros(along.shape, bool)
        in_branch[:, 4] = where.get("middle_in_branch", False)
        in_branch[:, -1] = where.get("tip_in_branch", False)
        reading = Reading(np.full((1, 6), q), np.zeros((1, 6)), np.ones((1, 10)), np.zeros(1), np.full((1, 6), spin))
        zero = np.zeros(1)
        truth = Truth(np.zeros((1, 3)), zero, np.array([depth]), zero, np.zeros((1, 7, 2)))
        self._steps += 1
        self.facts, outcome = self._tracker.step(
            self._steps,
            np.array([self.config.max_steps]),
            Whereabouts(along, in_branch),
            np.array([0.1]),
            reading,
            truth,
        )
        return Outcome(outcome[0])


def test_the_tail_beyond_the_corner_ends_an_episode_well() -> None:
    course = Course()
    assert course.step(1.1) is Outcome.RUNNING
    assert course.step(1.1 + course.config.through + 1e-6) is Outcome.REACHED
    assert course.facts.passed.all()
    assert course.facts.progress == pytest.approx(course.config.through + 1e-6)


def test_an_overlap_fails_even_the_last_step() -> None:
    assert Course().step(1.2, depth=0.0021) is Outcome.PENETRATION


def test_sliding_back_by_its_length_fails() -> None:
    course = Course()
    course.step(0.3)
    assert course.step(0.3 - 0.99 * ROBOT.length) is Outcome.RUNNING
    assert course.step(0.3 - 1.01 * ROBOT.length) is Outcome.SLID_BACK
    assert course.facts.failed.all()


@pytest.mark.parametrize(
    ("moves", "reason"),
    [({}, Outcome.JAM), ({"spin": 40.0}, Outcome.SLIP), ({"q": 2.19}, Outcome.LIMIT), ({"fold": True}, Outcome.FOLD)],
)
def test_being_stuck_has_a_reason_and_is_a_failure(moves: dict[str, float], reason: Outcome) -> None:
    course = Course()
    for i in range(4):
        outcome = course.step(0.001 * i, **moves)  # type: ignore[arg-type]
        assert outcome is (Outcome.RUNNING if i < 2 else reason)
        assert course.facts.failed.all() == (i >= 2)


def test_a_tip_in_a_branch_may_come_out_again_but_not_be_stuck_there() -> None:
    course = Course()
    outcomes = [course.step(0.001 * i, tip_in_branch=True) for i in range(3)]
    assert outcomes == [Outcome.RUNNING, Outcome.RUNNING, Outcome.WRONG_EXIT]
    course = Course()
    assert [course.step(0.1 * i, tip_in_branch=i == 1) for i in range(5)] == [Outcome.RUNNING] * 5


def test_a_middle_in_a_branch_has_taken_the_wrong_exit() -> None:
    course = Course()
    assert course.step(0.1, middle_in_branch=True) is Outcome.WRONG_EXIT
    assert course.facts.failed.all()


def test_time_runs_out_on_one_that_still_comes_on() -> None:
    course = Course(max_steps=5)
    assert [course.step(0.01 * i) for i in range(1, 6)] == [Outcome.RUNNING] * 4 + [Outcome.TIMEOUT]
    assert not course.facts.failed.any()  # it might have gone on


def test_the_reward_is_the_sum_of_its_terms_and_a_failure_is_one_number() -> None:
    config = TraverseReward(progress=2.0, passed=3.0, step=-0.5, force=-0.1, penetration=-1.0, failed=-7.0)
    facts = StepFacts(
        np.array([0.1, 0.1]),
        np.array([5.0, 5.0]),
        np.array([1e-3, 0.0]),
        np.array([True, False]),
        np.array([False, True]),
    )
    assert reward(config, facts) == pytest.approx([0.2 + 3.0 - 0.5 - 0.5 - 1.0, -7.0])
