"""Entry points that a survey proposes: one after the other, each the one that shows most of what is still unseen.

Length that is seen grows ever more slowly with more entries, so the greedy choice of k entries shows at least 63 %
(1 - 1/e) of what the best k would (Nemhauser, Wolsey, Fisher 1978). A tighter bound follows from the gains themselves:
after any choice, m more entries cannot add more than the m largest gains of single ones.
"""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.survey.passage import Tether, Ways
from pipenav.survey.reach import search

MOST_ENTRIES = 500
"""Most entries that are proposed."""

MOST_WORK = 4_000_000
"""Labels that all candidates' searches may look at together: a minute or two."""

LEAST_GAIN = 1.0
"""Length that a further entry shows at least [m]."""


class Goal(NamedTuple):
    """When there are enough entries: a share of a length [m], or a number; None for no such limit."""

    share: float | None = None
    number: int | None = None


class Proposal(NamedTuple):
    """Entries in the order in which they were chosen.

    Attributes:
        points: points of the graph.
        seen: length that is seen with the first k of them, (k,) [m].
        target: length to be seen [m]; None where a number of entries was asked for.
        least: number of entries that nobody can see as much with fewer of, by the gains.
        candidates: points that were looked at.
    """

    points: list[int]
    seen: list[float]
    target: float | None
    least: int
    candidates: int

    @property
    def reached(self) -> bool:
        """Whether the target was met."""
        return self.target is None or bool(self.seen and self.seen[-1] >= self.target - 1e-6)


class _Candidate(NamedTuple):
    """A point with what is seen from it: directed segments, (k,), and lengths along them, (k,) [m]."""

    point: int
    directed: Ints
    far: Floats


def propose(ways: Ways, tether: Tether, confidence: float, goal: Goal, whole: float) -> Proposal:
    """Entries by greedy cover.

    Args:
        ways: the ways through the network.
        tether: the cable.
        confidence: least probability of coming to a place.
        goal: when there are enough.
        whole: length that a share refers to [m].
    """
    length = np.array(ways.length)
    candidates = _candidates(ways, tether, confidence)
    covered = np.zeros(2 * len(length))
    heap = [(-_gain(candidate, covered, length), i, 0) for i, candidate in enumerate(candidates)]
    heapq.heapify(heap)
    first = np.sort([-gain for gain, _, _ in heap])[::-1]
    target = None if goal.share is None else goal.share * whole
    most = goal.number or MOST_ENTRIES
    points: list[int] = []
    seen: list[float] = []
    while heap and len(points) < most and not (target is not None and seen and seen[-1] >= target):
        gain, i, when = heapq.heappop(heap)
        if when < len(points):  # another entry has come since: what is left of the gain?
            heapq.heappush(heap, (-_gain(candidates[i], covered, length), i, len(points)))
            continue
        if -gain < LEAST_GAIN:
            break
        candidate = candidates[i]
        covered[candidate.directed] = np.maximum(covered[candidate.directed], candidate.far)
        points.append(candidate.point)
        seen.append(float(np.minimum(covered[0::2] + covered[1::2], length).sum()))
    aim = (seen[-1] if seen else 0.0) if target is None or not seen or seen[-1] < target else target
    least = _least(candidates, points, aim, length, first)
    return Proposal(points, seen, target, least, len(candidates))


def _candidates(ways: Ways, tether: Tether, confidence: float) -> list[_Candidate]:
    """Points with what is seen from each: fittings first, then the others evenly, as far as there is time."""
    degree = np.array([len(leaving) for leaving in ways.leaving])
    special = np.flatnonzero(degree != 2)
    others = np.flatnonzero(degree == 2)
    order = [*special.tolist(), *others[_spread(len(others))].tolist()]
    found: list[_Candidate] = []
    work = 0
    for point in order:
        reach = search(ways, tether, confidence, [point])
        work += reach.work
        if reach.far:
            far = np.fromiter(reach.far.values(), float)
            found.append(_Candidate(point, np.fromiter(reach.far, np.intp), far))
        if work > MOST_WORK:
            break
    return found


def _spread(count: int) -> Ints:
    """Numbers from 0 to count - 1, any first part of which is spread evenly: the digits of a number turned round."""
    if count == 0:
        return np.zeros(0, np.intp)
    bits = max(int(count - 1).bit_length(), 1)
    turned = [int(format(k, f"0{bits}b")[::-1], 2) for k in range(1 << bits)]
    return np.array([k for k in turned if k < count], np.intp)


def _gain(candidate: _Candidate, covered: Floats, length: Floats) -> float:
    """Length that a candidate adds to what is seen [m]."""
    segments = np.unique(candidate.directed >> 1)
    there = np.searchsorted(segments, candidate.directed >> 1)
    sides = covered[np.stack([2 * segments, 2 * segments + 1], axis=1)]
    before = np.minimum(sides.sum(axis=1), length[segments])
    np.maximum.at(sides, (there, candidate.directed & 1), candidate.far)
    return float((np.minimum(sides.sum(axis=1), length[segments]) - before).sum())


def _least(candidates: list[_Candidate], points: list[int], aim: float, length: Floats, first: Floats) -> int:
    """Number of entries below which nobody sees `aim` [m], by the gains at the beginning and after each choice."""
    by_point = {candidate.point: candidate for candidate in candidates}
    covered = np.zeros(2 * len(length))
    gains, seen, best = first, 0.0, 0
    for k in range(len(points) + 1):
        sums = np.cumsum(gains)
        missing = aim - seen
        needed = 0 if missing <= 1e-6 else int(np.searchsorted(sums, missing - 1e-6)) + 1
        best = max(best, needed)
        if k == len(points) or k >= 5:  # later choices leave little to be gained, and a weaker bound
            break
        chosen = by_point[points[k]]
        covered[chosen.directed] = np.maximum(covered[chosen.directed], chosen.far)
        gains = np.sort([_gain(candidate, covered, length) for candidate in candidates])[::-1]
        seen = float(np.minimum(covered[0::2] + covered[1::2], length).sum())
    return best
