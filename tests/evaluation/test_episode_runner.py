"""Extremes of episodes, also where a simulation blows up."""

from __future__ import annotations

import numpy as np

from pipenav.backends.messages import Truth
from pipenav.evaluation.episode_runner import _Peaks
from pipenav.evaluation.stage import StageStep
from pipenav.tasks.outcome import Outcome


def step(penetration: list[float], force: list[float]) -> StageStep:
    truth = Truth(np.zeros((2, 3)), np.array(force), np.array(penetration), np.full(2, 0.5), np.zeros((2, 1, 2)))
    return StageStep(np.full(2, Outcome.RUNNING.value, np.int8), np.array([0.1, 0.2]), truth, np.zeros((2, 1)))


def test_a_world_that_blew_up_leaves_the_extremes_of_before() -> None:
    peaks = _Peaks(2)
    peaks.add(step([0.001, 0.002], [3.0, 4.0]))
    peaks.add(step([np.inf, 0.001], [np.nan, 5.0]))
    np.testing.assert_array_equal(peaks.penetration, [0.001, 0.002])
    np.testing.assert_array_equal(peaks.force, [3.0, 5.0])
