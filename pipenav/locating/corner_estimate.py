"""Estimates of the corner ahead, by whichever map they are made."""

from __future__ import annotations

from typing import NamedTuple

from pipenav.arrays import Floats

TIE = 1.0
"""Votes by which a corner may lose to the best one and still be possible."""


class CornerEstimate(NamedTuple):
    """Best estimates of n robots' corners; NaN where nothing can be said yet.

    Attributes:
        radius: radius of the pipe, (n,) [m].
        edge: end of the inner wall along the first leg, (n,) [m].
        heading: heading of the second leg, (n,) [rad].
        target: middle of the second leg at the wanted depth, (n, 2) [m]; straight on it counts from the farthest of
            the possible edges, so that it lies past the crossing whichever is right.
        spread: largest distance of the possible corners' targets from their mean, (n,) [m].
        votes: votes of the beams that agree on the second leg's outer wall, (n,).
        agreement: share of `votes` in all beams that ended past the first leg's walls, (n,).
    """

    radius: Floats
    edge: Floats
    heading: Floats
    target: Floats
    spread: Floats
    votes: Floats
    agreement: Floats
