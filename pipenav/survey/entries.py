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
from pipenav.survey.reach import TetheredWays, search_from

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
    """A point with what is seen from it.

    Attributes:
        point: point of the graph.
        segments: segments of which something is seen, in order, (k,).
        sides: number of the segment in `segments`, times two, and one more where it is seen against its direction,
            (n,).
        far: length that is seen from each side, (n,) [m].
    """

    point: int
    segments: Ints
    sides: Ints
    far: Floats

    @classmethod
    def of(cls, point: int, far: dict[int, float]) -> _Candidate:
        """A point and the lengths that are seen of directed segments [m]."""
        directed = np.fromiter(far, np.int32)
        segments = np.unique(directed >> 1)
        sides = 2 * np.searchsorted(segments, directed >> 1).astype(np.int32) + (directed & 1)
        return cls(point, segments, sides, np.fromiter(far.values(), float))

    def with_own(self, covered: Floats) -> Floats:
        """Lengths that are seen from both sides of its segments by others and from here, (k, 2) [m]."""
        sides = covered[self.segments]
        flat = sides.ravel()
        flat[self.sides] = np.maximum(flat[self.sides], self.far)
        return sides

    def gain(self, covered: Floats, length: Floats) -> float:
        """Length that it adds to what is seen [m]; `covered` is that of all segments from both sides, (s, 2) [m]."""
        whole = length[self.segments]
        before = covered[self.segments]
        sides = self.with_own(covered)
        return float(
            (np.minimum(sides[:, 0] + sides[:, 1], whole) - np.minimum(before[:, 0] + before[:, 1], whole)).sum()
        )


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
    covered = np.zeros((len(length), 2))
    first = np.array([candidate.gain(covered, length) for candidate in candidates])
    heap = [(-gain, i, 0) for i, gain in enumerate(first.tolist())]
    heapq.heapify(heap)
    target = None if goal.share is None else goal.share * whole
    most = goal.number or MOST_ENTRIES
    chosen: list[int] = []
    seen: list[float] = []
    while heap and len(chosen) < most and not (target is not None and seen and seen[-1] >= target):
        gain, i, when = heapq.heappop(heap)
        if when < len(chosen):  # another entry has come since: what is left of the gain?
            heapq.heappush(heap, (-candidates[i].gain(covered, length), i, len(chosen)))
            continue
        if -gain < LEAST_GAIN:
            break
        covered[candidates[i].segments] = candidates[i].with_own(covered)
        chosen.append(i)
        seen.append(float(np.minimum(covered[:, 0] + covered[:, 1], length).sum()))
    aim = (seen[-1] if seen else 0.0) if target is None or not seen or seen[-1] < target else target
    least = _least(candidates, chosen, aim, length, first)
    return Proposal([candidates[i].point for i in chosen], seen, target, least, len(candidates))


def _candidates(ways: Ways, tether: Tether, confidence: float) -> list[_Candidate]:
    """Points with what is seen from each: fittings first, then the others evenly, as far as there is time."""
    degree = np.array([len(leaving) for leaving in ways.leaving])
    special = np.flatnonzero(degree != 2)
    others = np.flatnonzero(degree == 2)
    order = [*special.tolist(), *others[_spread(len(others))].tolist()]
    tethered = TetheredWays.of(ways, tether)
    found: list[_Candidate] = []
    work = 0
    for point in order:
        reach = search_from(tethered, confidence, tethered.starts([point]))
        work += reach.work
        if reach.far:
            found.append(_Candidate.of(point, reach.far))
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


def _least(candidates: list[_Candidate], chosen: list[int], aim: float, length: Floats, first: Floats) -> int:
    """Number of entries below which nobody sees `aim` [m], by the gains at the beginning and after each choice.

    Args:
        candidates: the candidates.
        chosen: numbers of those that were chosen.
        aim: length [m].
        length: lengths of the segments, (s,) [m].
        first: gain of each candidate at the beginning [m].
    """
    covered = np.zeros((len(length), 2))
    gains, seen, best = first.copy(), 0.0, 0
    segments = np.concatenate([np.zeros(0, np.int32), *(candidate.segments for candidate in candidates)])
    owners = np.repeat(np.arange(len(candidates)), [len(candidate.segments) for candidate in candidates])
    for k in range(len(chosen) + 1):
        sums = np.cumsum(np.sort(gains)[::-1])
        missing = aim - seen
        needed = 0 if missing <= 1e-6 else int(np.searchsorted(sums, missing - 1e-6)) + 1
        best = max(best, needed)
        if k == len(chosen) or k >= 5:  # later choices leave little to be gained, and a weaker bound
            break
        one = candidates[chosen[k]]
        covered[one.segments] = one.with_own(covered)
        touched = np.zeros(len(length), bool)
        touched[one.segments] = True
        for i in np.unique(owners[touched[segments]]).tolist():  # the gains of all others are what they were
            gains[i] = candidates[i].gain(covered, length)
        seen = float(np.minimum(covered[:, 0] + covered[:, 1], length).sum())
    return best
