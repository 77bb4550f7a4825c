"""Sessions of several drivers beside each other, on the episodes that all of them drove."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipenav.driving.records import DriveRecords, EpisodeRecord, matched
from pipenav.evaluation.interval import Interval, wilson

DRAWS = 2000
"""Number of bootstrap samples of an interval: its ends then vary by a few percent of its width."""


class MeanInterval(NamedTuple):
    """A mean with its 95 % interval; NaN where there is nothing to take it of."""

    mean: float
    low: float
    high: float


class DriverRow(NamedTuple):
    """A driver in a comparison.

    Attributes:
        driver: words for who drove.
        disturb: disturbances; None for none.
        episodes, passed: numbers of episodes.
        success: 95 % interval of the share that passed.
        seconds: time of the episodes that passed [s].
        takeovers: take-overs in an episode.
        person_share: share of the time that a person drove.
        force: peak contact force of an episode [N].
        gained, lost: episodes that this driver passed and the first one did not, and the other way round.
    """

    driver: str
    disturb: str | None
    episodes: int
    passed: int
    success: Interval
    seconds: MeanInterval
    takeovers: MeanInterval
    person_share: float
    force: MeanInterval
    gained: int
    lost: int


def compare(sessions: Sequence[DriveRecords]) -> list[DriverRow]:
    """Each session's row, over the episodes that all of them drove.

    Raises:
        PipenavError: they have none in common, or other robots or seeds.
    """
    episodes = matched(sessions)
    return [_row(session, own, episodes[0]) for session, own in zip(sessions, episodes, strict=True)]


def _row(session: DriveRecords, own: Sequence[EpisodeRecord], first: Sequence[EpisodeRecord]) -> DriverRow:
    passed = np.array([episode.passed for episode in own])
    before = np.array([episode.passed for episode in first])
    return DriverRow(
        session.driver,
        session.disturb,
        len(own),
        int(passed.sum()),
        wilson(int(passed.sum()), len(own)),
        mean_interval([episode.seconds for episode in own if episode.passed]),
        mean_interval([episode.takeovers for episode in own]),
        float(np.mean([episode.person_share for episode in own])),
        mean_interval([episode.peak_force_n for episode in own]),
        int((passed & ~before).sum()),
        int((before & ~passed).sum()),
    )


def mean_interval(values: Sequence[float]) -> MeanInterval:
    """Mean of values with its 95 % interval by the bootstrap's percentiles.

    Source: B. Efron and R. J. Tibshirani, "An introduction to the bootstrap" (1993), chapter 13.
    """
    if not values:
        return MeanInterval(float("nan"), float("nan"), float("nan"))
    given = np.array(values, float)
    drawn = np.random.default_rng(0).integers(len(given), size=(DRAWS, len(given)))
    low, high = np.percentile(given[drawn].mean(axis=1), [2.5, 97.5])
    return MeanInterval(float(given.mean()), float(low), float(high))
