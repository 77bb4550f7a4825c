"""Reach of a robot with a cable, against direct sums on trees, and entries against all choices."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from helpers.surveys import found, map_of, random_tree
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.robots.robot import load_robot
from pipenav.survey.entries import Goal, propose
from pipenav.survey.features import Geometry, fittings_of
from pipenav.survey.graph import mains_graph
from pipenav.survey.passage import Tether, Ways, judged, ways_of
from pipenav.survey.reach import search
from pipenav.survey.trained import Trained
from pipenav.survey.trials import Trial

PIRATE = load_robot("pirate")
TRAINED = Trained((70.0, 120.0), 30.0, False)
SOME = settings(max_examples=40)


def ways_in(seed: int, nodes: int, rate: float = 1.0) -> Ways:
    """The ways of a tree in which every fitting of a class is passed with one probability."""
    fittings = fittings_of(mains_graph(random_tree(seed, nodes)), Geometry(0.0))
    finding = found(Trial(episodes=1000, successes=round(1000 * rate)))
    findings = {kind: finding for movement in fittings.movements for kind in movement.classes}
    return ways_of(fittings, [judged(m, findings, 0.1) for m in fittings.movements], TRAINED, PIRATE, 0.0)


def by_hand(ways: Ways, tether: Tether, confidence: float, entry: int) -> np.ndarray:
    """Seen length of each segment of a tree, by walking every way once and adding up."""
    seen = np.zeros(len(ways.length))

    def walk(directed: int, distance: float, tension: float, share: float) -> None:
        length, growth = ways.length[directed >> 1], tether.weight * tether.friction
        room = min(tether.cable - distance, (tether.pull - tension) / growth if growth else math.inf)
        seen[directed >> 1] = max(seen[directed >> 1], min(max(room, 0.0), length))
        if room < length:
            return
        for onward, movement in ways.onward[directed]:
            pulled = (tension + growth * length) * math.exp(tether.friction * ways.turn[movement])
            left = share * math.exp(-ways.cost[movement])
            if left >= confidence - 1e-9 and pulled <= tether.pull:
                walk(onward, distance + length, pulled, left)

    for directed in ways.leaving[entry]:
        walk(directed, 0.0, 0.0, 1.0)
    return seen


tethers = st.builds(
    Tether, st.floats(10, 800), st.floats(0.5, 60), st.floats(0, 0.8), st.sampled_from([0.0, 0.02, 0.1, 0.4])
)


@SOME
@given(st.integers(0, 10_000), st.integers(2, 14), tethers, st.sampled_from([1.0, 0.97, 0.9]))
def test_reach_in_a_tree_is_that_of_its_only_ways(seed: int, nodes: int, tether: Tether, rate: float) -> None:
    ways = ways_in(seed, nodes, rate)
    for entry in range(len(ways.leaving)):
        seen = search(ways, tether, 0.8, [entry]).seen(np.array(ways.length))
        np.testing.assert_allclose(seen, by_hand(ways, tether, 0.8, entry), atol=1e-6)


@SOME
@given(st.integers(0, 10_000), tethers, st.sampled_from(["cable", "pull", "friction", "weight"]), st.floats(1, 4))
def test_a_better_cable_never_sees_less(seed: int, tether: Tether, what: str, factor: float) -> None:
    ways = ways_in(seed, 12)
    length = np.array(ways.length)
    better = getattr(tether, what) * (factor if what in ("cable", "pull") else 1 / factor)
    before, after = (search(ways, t, 0.9, [0]).seen(length) for t in (tether, tether._replace(**{what: better})))
    assert (after >= before - 1e-9).all()


@SOME
@given(st.integers(0, 10_000), tethers, st.integers(0, 11), st.integers(0, 11))
def test_two_entries_see_what_each_of_them_sees(seed: int, tether: Tether, one: int, other: int) -> None:
    ways = ways_in(seed, 12)
    length = np.array(ways.length)
    points = len(ways.leaving)
    one, other = one % points, other % points
    first, second = (search(ways, tether, 0.9, [point]) for point in (one, other))
    both = search(ways, tether, 0.9, [one, other])
    far = {d: max(first.far.get(d, 0.0), second.far.get(d, 0.0)) for d in first.far.keys() | second.far.keys()}
    assert both.far == pytest.approx(far)
    assert (both.seen(length) <= first.seen(length) + second.seen(length) + 1e-9).all()


def test_a_cable_is_dragged_harder_around_a_corner() -> None:
    """By exp(friction x turn): with 10 N after 100 m, a right angle at 0.3 leaves room for no more than 16.02 N."""
    right = [(0.0, 0.0, 0.0), (100.0, 0.0, 0.0), (100.0, 100.0, 0.0)]
    fittings = fittings_of(mains_graph(map_of(right, [(0, 1), (1, 2)])), Geometry(0.0))
    findings = {kind: found(Trial(episodes=20, successes=20)) for m in fittings.movements for kind in m.classes}
    ways = ways_of(fittings, [judged(m, findings, 0.9) for m in fittings.movements], TRAINED, PIRATE, 0.0)
    needed = 10 * math.exp(0.3 * math.pi / 2)
    tether = Tether(1e6, needed + 5.0, 0.3, 10 / 100 / 0.3)
    assert search(ways, tether, 0.9, [0]).seen(np.array(ways.length)).sum() == pytest.approx(100 + 5.0 / 0.1)
    weaker = tether._replace(pull=needed - 1e-6)
    assert search(ways, weaker, 0.9, [0]).seen(np.array(ways.length)).sum() == pytest.approx(100)


@settings(max_examples=15)
@given(st.integers(0, 10_000), st.integers(1, 3), st.sampled_from([60.0, 120.0]))
def test_greedy_entries_keep_their_bounds(seed: int, count: int, cable: float) -> None:
    """At least 63 % of the best choice of as many; and no choice sees as much with fewer than is said."""
    ways = ways_in(seed, 9)
    length, tether = np.array(ways.length), Tether(cable, 1e9)

    def best(k: int) -> float:
        sets = itertools.combinations(range(len(ways.leaving)), k)
        return max(float(search(ways, tether, 0.9, points).seen(length).sum()) for points in sets)

    proposal = propose(ways, tether, 0.9, Goal(number=count), float(length.sum()))
    seen = float(search(ways, tether, 0.9, proposal.points).seen(length).sum())
    assert proposal.seen[-1] == pytest.approx(seen)
    assert seen >= (1 - 1 / math.e) * best(min(count, len(ways.leaving))) - 1e-6
    assert proposal.least <= len(proposal.points)
    if proposal.least > 1:
        assert best(proposal.least - 1) < seen - 1e-9


def test_a_share_is_met_or_said_not_to_be() -> None:
    ways = ways_in(3, 14)
    whole = sum(ways.length)
    proposal = propose(ways, Tether(80.0, 1e9), 0.9, Goal(share=0.8), whole)
    assert proposal.reached and proposal.seen[-1] >= 0.8 * whole
    assert len(proposal.seen) == 1 or proposal.seen[-2] < 0.8 * whole, "no entry too many"
    blind = ways._replace(passable=np.zeros(len(ways.length), bool))
    assert not propose(blind, Tether(), 0.9, Goal(share=0.8), whole).reached
