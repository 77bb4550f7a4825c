"""Reach of a robot from its entries: a search over directed pipes with turn limits, pass probabilities and a cable.

A label is a way to the begin of a directed pipe: its distance, the tension of the cable at the robot, and the cost of
the passages so far. The tension of a cable that is dragged grows by weight and friction along a pipe and, by the
capstan equation, by exp(friction x turn) around each turn (Euler 1769; Eytelwein 1808).
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.robots.cable import capstan, drag_per_metre
from pipenav.survey.passage import Tether, Ways

MOST_LABELS = 6
"""Most labels of one directed pipe: more would be ways that trade a little distance for a little tension."""

ROUNDING = 1e-9


class Label(NamedTuple):
    """A way to the begin of a directed segment.

    Attributes:
        distance: length of cable that is out [m].
        tension: tension of the cable at the robot [N].
        cost: minus the logarithm of the probability of coming here.
        directed: directed segment.
        before: label of the segment before; None at an entry.
    """

    distance: float
    tension: float
    cost: float
    directed: int
    before: Label | None


class Stop(NamedTuple):
    """A passage that a robot came to and did not take: the movement, and the label that it would have given."""

    movement: int
    label: Label


class Reach(NamedTuple):
    """Result of a search.

    Attributes:
        far: length that is seen of a directed segment from its begin, by directed segment [m].
        labels: labels of each directed segment.
        stops: passages that were not taken.
        by_tether: points or segments at which the cable ended the way: their number.
        work: number of labels that were looked at.
    """

    far: dict[int, float]
    labels: dict[int, list[Label]]
    stops: list[Stop]
    by_tether: int
    work: int

    def seen(self, length: Floats) -> Floats:
        """Length that is seen of each segment, from both sides together, (s,) [m]."""
        return seen_length(self.far, length)


class TetheredWays(NamedTuple):
    """Ways as a robot with one cable meets them: everything that its searches ask, as plain numbers.

    Attributes:
        ways: the ways through the network.
        tether: the cable.
        passable: whether a robot may drive in each segment, s values.
        growth: growth of the cable's tension along each directed segment, 2 s values [N/m].
        capstan: factor on that tension in each movement, m values.
    """

    ways: Ways
    tether: Tether
    passable: list[bool]
    growth: list[float]
    capstan: list[float]

    @classmethod
    def of(cls, ways: Ways, tether: Tether) -> TetheredWays:
        """Ways with a cable."""
        climb = np.array(ways.climb)
        growth = drag_per_metre(tether.weight, tether.friction, np.stack([climb, -climb], axis=1))
        factors = capstan(tether.friction, np.array(ways.turn))
        return cls(ways, tether, ways.passable.tolist(), growth.ravel().tolist(), factors.tolist())

    def starts(self, points: Iterable[int]) -> list[Label]:
        """Labels at points that are dug up, from which the robot can go into any pipe."""
        return [Label(0.0, 0.0, 0.0, directed, None) for point in points for directed in self.ways.leaving[point]]


def seen_length(far: dict[int, float], length: Floats) -> Floats:
    """Length that is seen of each segment, (s,) [m].

    Args:
        far: see `Reach`.
        length: lengths of the segments, (s,) [m].
    """
    both = np.zeros(2 * len(length))
    if far:
        both[list(far)] = list(far.values())
    return np.minimum(both[0::2] + both[1::2], length)


def search(ways: Ways, tether: Tether, confidence: float, entries: Iterable[int], base: Reach | None = None) -> Reach:
    """Reach from entries, points that are dug up and from which the robot can go into any pipe.

    Args:
        ways: the ways through the network.
        tether: the cable.
        confidence: least probability of coming to a place.
        entries: numbers of the points.
        base: an earlier reach whose labels are as good as ways of this search: only what goes beyond it is found.
    """
    tethered = TetheredWays.of(ways, tether)
    return search_from(tethered, confidence, tethered.starts(entries), base)


def search_from(tethered: TetheredWays, confidence: float, starts: Iterable[Label], base: Reach | None = None) -> Reach:
    """Reach from labels, see `search`."""
    ways, tether, passable, growth, factors = tethered
    budget = -math.log(confidence) + ROUNDING
    labels: dict[int, list[Label]] = {}
    far: dict[int, float] = {}
    stops: list[Stop] = []
    heap = [(label.distance, i, label) for i, label in enumerate(starts)]
    heapq.heapify(heap)
    pushed, by_tether, work = len(heap), 0, 0
    while heap:
        label = heapq.heappop(heap)[2]
        directed, segment = label.directed, label.directed >> 1
        if not passable[segment] or _beaten(label, labels, base):
            continue
        work += 1
        labels.setdefault(directed, []).append(label)
        length, gain = ways.length[segment], growth[directed]
        room = min(tether.cable - label.distance, (tether.pull - label.tension) / gain if gain > 0 else math.inf)
        far[directed] = max(far.get(directed, 0.0), min(length, max(room, 0.0)))
        if room < length:
            by_tether += 1
            continue
        distance, tension = label.distance + length, label.tension + gain * length
        for onward, movement in ways.onward[directed]:
            dragged = tension * factors[movement]
            cost = label.cost + ways.cost[movement]
            new = Label(distance, dragged, cost, onward, label)
            if cost > budget:
                stops.append(Stop(movement, new))
            elif dragged > tether.pull:
                by_tether += 1
            else:
                pushed += 1
                heapq.heappush(heap, (distance, pushed, new))
    return Reach(far, labels, stops, by_tether, work)


def _beaten(label: Label, labels: dict[int, list[Label]], base: Reach | None) -> bool:
    """Whether another label of the same directed segment is no worse in all, or there are too many already."""
    own = labels.get(label.directed, ())
    if len(own) >= MOST_LABELS:
        return True
    held = own if base is None else [*own, *base.labels.get(label.directed, ())]
    if not held:
        return False
    distance, tension, cost = (value + ROUNDING for value in label[:3])
    return any(other[0] <= distance and other[1] <= tension and other[2] <= cost for other in held)


def way_to(label: Label) -> Ints:
    """Directed segments from an entry to a label's, (n,)."""
    back = []
    current: Label | None = label
    while current is not None:
        back.append(current.directed)
        current = current.before
    return np.array(back[::-1], np.intp)
