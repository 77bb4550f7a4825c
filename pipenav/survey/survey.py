"""A survey: what a robot can inspect of a network, from where, and what stops it where it stops."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError, UnknownName
from pipenav.networks.checks import is_sketch, map_notes
from pipenav.networks.model import NetworkMap, Note
from pipenav.survey.classes import FittingClass
from pipenav.survey.entries import Goal, Proposal, propose
from pipenav.survey.features import Fittings, Geometry, fittings_of
from pipenav.survey.findings import Finding, Findings, Progress
from pipenav.survey.graph import MainsGraph, mains_graph
from pipenav.survey.passage import LIFTED, Judged, Tether, Ways, geometry_accuracy, judgements_of, ways_of
from pipenav.survey.reach import Reach, TetheredWays, search, search_from

MOST_BLOCKERS = 60
"""Most points whose length behind them is searched."""


class SurveyConfig(NamedTuple):
    """Settings of a survey, besides what the policy is.

    Attributes:
        geometry: how fittings are told from the map.
        tether: cable of the robot.
        confidence: least probability of coming to a place, and of passing a fitting that counts as navigable.
        entries: names of the nodes that the robot goes in by; none to have them proposed.
        goal: how many are proposed.
    """

    geometry: Geometry = Geometry()
    tether: Tether = Tether()
    confidence: float = 0.95
    entries: tuple[str, ...] = ()
    goal: Goal = Goal(share=0.8)


class Blocker(NamedTuple):
    """A fitting that stops the robot.

    Attributes:
        point: point of the graph.
        behind: length that would be seen besides, were it passed; of one that is unknown, were the pipes behind it
            whose bore or slope is unknown passed too [m].
        judgement: judgement of the passage that is not taken.
    """

    point: int
    behind: float
    judgement: Judged


class Totals(NamedTuple):
    """Lengths of the mains [m].

    Attributes:
        mains: all of them.
        in_range: those in which the policy can drive, by their bore and slope.
        seen: those that it sees.
        unknown: those that it does not see, and might if all that is unknown could be passed.
        blocked: all others.
    """

    mains: float
    in_range: float
    seen: float
    unknown: float
    blocked: float


@dataclass(frozen=True)
class Survey:
    """Result of a survey."""

    config: SurveyConfig
    graph: MainsGraph
    fittings: Fittings
    findings: dict[FittingClass, Finding]
    judgements: list[Judged]
    ways: Ways
    entries: list[int]
    proposal: Proposal | None
    reach: Reach
    seen: Floats
    optimistic: Floats
    totals: Totals
    blockers: list[Blocker]
    without: dict[str, float]
    notes: list[Note]


def survey(network: NetworkMap, findings: Findings, config: SurveyConfig, progress: Progress | None = None) -> Survey:
    """Survey a network.

    Args:
        network: its map.
        findings: trials of the policy and proofs, which are made as far as they are missing.
        config: settings.
        progress: called as the work goes on.

    Raises:
        PipenavError: an unknown entry, no main, or a simulator that cannot run.
    """
    if np.isnan(network.diameter[~network.service]).all():
        raise PipenavError("no main of the map has a diameter: give --diameter FIELD:mm, or add diameters to it.")
    graph = mains_graph(network)
    entries = _entries(graph, config.entries)
    fittings = classified(network, graph, config.geometry)
    classes = {kind for movement in fittings.movements for kind in movement.classes}
    known = findings.of(classes, progress)
    judgements = judgements_of(fittings.movements, known, config.confidence)
    accuracy = geometry_accuracy(config.geometry, network.fabricated)
    ways = ways_of(fittings, judgements, findings.trained, findings.robot, accuracy)
    _say(progress, "looking for entries")
    proposal = None
    if not entries:
        in_range = float(graph.length[ways.passable].sum())
        proposal = propose(ways, config.tether, config.confidence, config.goal, in_range)
        entries = proposal.points
    reach = search(ways, config.tether, config.confidence, entries)
    open_ways = ways.lifted(fittings, judgements, "unknown")
    optimistic = search(open_ways, config.tether, config.confidence, entries).seen(graph.length)
    _say(progress, "ranking what stops the robot")
    seen = reach.seen(graph.length)
    return Survey(
        config=config,
        graph=graph,
        fittings=fittings,
        findings=known,
        judgements=judgements,
        ways=ways,
        entries=entries,
        proposal=proposal,
        reach=reach,
        seen=seen,
        optimistic=optimistic,
        totals=_totals(graph.length, ways, seen, optimistic),
        blockers=_blockers(ways, config, reach, judgements, graph.length),
        without=_without(ways, fittings, judgements, config, entries),
        notes=[*map_notes(network), *graph_notes(graph)],
    )


def _say(progress: Progress | None, doing: str) -> None:
    if progress is not None:
        progress(doing, 0, 1)


def _totals(length: Floats, ways: Ways, seen: Floats, optimistic: Floats) -> Totals:
    """Sums over all segments: lengths, and what is seen with and without what is unknown, (s,) each [m]."""
    mains, total = float(length.sum()), float(seen.sum())
    might = np.maximum(optimistic - seen, 0.0)
    beyond = (length - np.maximum(optimistic, seen))[list(ways.unknown)]  # in a bore that nobody knows to be passed
    unknown = float(might.sum()) + float(beyond.sum())
    return Totals(mains, float(length[ways.passable].sum()), total, unknown, mains - total - unknown)


def classified(network: NetworkMap, graph: MainsGraph, geometry: Geometry) -> Fittings:
    """The fittings of a graph; in a sketch none of them fits a class."""
    fittings = fittings_of(graph, geometry._replace(accuracy=geometry_accuracy(geometry, network.fabricated)))
    if not is_sketch(network):
        return fittings
    reason = "the map is a sketch, whose angles mean nothing"
    return replace(fittings, movements=tuple(m._replace(classes=(), reason=reason) for m in fittings.movements))


def _entries(graph: MainsGraph, names: tuple[str, ...]) -> list[int]:
    """Points of the nodes that are named."""
    if not names:
        return []
    by_name = {graph.network.node_names[node]: i for i, node in enumerate(graph.node.tolist()) if node >= 0}
    for name in names:
        if name in graph.network.node_names and name not in by_name:
            raise PipenavError(
                f"node {name!r} lies on no main, or in the middle of a straight one: choose a fitting or an end for "
                "--from."
            )
        if name not in by_name:
            raise UnknownName("node", name, by_name)
    return [by_name[name] for name in names]


def _blockers(
    ways: Ways, config: SurveyConfig, reach: Reach, judgements: list[Judged], length: Floats
) -> list[Blocker]:
    """Fittings that stop the robot, the one with most length behind it first."""
    stops: dict[int, list[int]] = {}
    for i, stop in enumerate(reach.stops):
        stops.setdefault(ways.point[stop.movement], []).append(i)
    before = reach.seen(length)
    open_pipes = ways.passable.copy()
    open_pipes[list(ways.unknown)] = True
    closed = TetheredWays.of(ways, config.tether)
    lifted = TetheredWays.of(ways._replace(passable=open_pipes), config.tether)
    found = []
    for point, numbers in list(stops.items())[: MOST_BLOCKERS * 20]:
        opened = [reach.stops[i] for i in numbers]
        labels = [stop.label._replace(cost=stop.label.before.cost if stop.label.before else 0.0) for stop in opened]
        unknown = any(judgements[stop.movement].verdict == "unknown" for stop in opened)
        more = search_from(lifted if unknown else closed, config.confidence, labels, reach)
        both = {d: max(reach.far.get(d, 0.0), far) for d, far in more.far.items()}
        touched = np.unique(np.fromiter(both, np.intp, len(both)) >> 1)
        gain = sum(_gained(s, both, reach.far, length, before) for s in touched.tolist())
        found.append(Blocker(point, gain, judgements[opened[0].movement]))
    found.sort(key=lambda blocker: -blocker.behind)
    return [blocker for blocker in found if blocker.behind > 0.5][:MOST_BLOCKERS]


def _gained(segment: int, far: dict[int, float], old: dict[int, float], length: Floats, before: Floats) -> float:
    sides = [far.get(d, old.get(d, 0.0)) for d in (2 * segment, 2 * segment + 1)]
    return max(min(sum(sides), float(length[segment])) - float(before[segment]), 0.0)


def _without(
    ways: Ways,
    fittings: Fittings,
    judgements: list[Judged],
    config: SurveyConfig,
    entries: list[int],
) -> dict[str, float]:
    """Length that is seen from the same entries without each limit [m]."""
    found, length = {}, np.array(ways.length)
    for limit in LIFTED:
        tether = config.tether.lifted if limit == "tether" else config.tether
        confidence = 1e-9 if limit == "confidence" else config.confidence
        lifted = ways.lifted(fittings, judgements, limit) if limit not in ("tether", "confidence") else ways
        found[limit] = float(search(lifted, tether, confidence, entries).seen(length).sum())
    return found


def graph_notes(graph: MainsGraph) -> list[Note]:
    """Notes about points that were left out."""
    words = {
        "in-line": "vertices of lines that bend them by less than 2 cm are no fittings",
        "short-leg": "points beside a leg of less than half a metre are drawing errors, no sharp corners",
    }
    return [Note(kind, "assumed", words[kind], count) for kind, count in graph.dropped.items()]
