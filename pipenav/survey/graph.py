"""The mains of a map as points and straight segments, without what digitising put in: the graph that is surveyed.

Services are left out: what stays of them is the number of taps at each point. Points in the middle of a pipe that bend
it by less than can be told, or that a leg of less than half a metre joins to the next, are no fittings and go.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.errors import PipenavError
from pipenav.networks.model import NetworkMap

LEAST_LEG = 0.5
"""Shortest leg of a map that tells a direction [m]: shorter ones make sharp corners of drawing errors."""

COLLINEAR = 0.02
"""Distance of a vertex from the line of its neighbours that counts as none [m]."""

BORE_STEP = 1e-3
"""Difference of two bores that counts as none [m]."""


class Incidence(NamedTuple):
    """Segments at each point, one after the other.

    Attributes:
        first: number of the first segment of each point in `segments`, and their number, (points + 1,).
        segments: segments of the points, (2 x segments,).
        others: points at the other ends of these segments, (2 x segments,).
    """

    first: Ints
    segments: Ints
    others: Ints

    @property
    def degree(self) -> Ints:
        """Number of segments at each point, (points,)."""
        return np.diff(self.first)


@dataclass(frozen=True)
class MainsGraph:
    """The mains, p points and s segments.

    Attributes:
        network: map that they come from.
        position: positions, (p, 3) [m].
        node: node of the map at each point, -1 for a vertex of a line, (p,).
        taps: number of services at each point, (p,).
        ends: points at the ends of each segment, (s, 2).
        line: line of the map that each segment is a part of, (s,).
        length: lengths, (s,) [m].
        diameter: inner diameters, NaN where none is known, (s,) [m].
        dropped: numbers of points that were left out, by the reason.
        capped: whether a point is an end, (p,).
    """

    network: NetworkMap
    position: Floats
    node: Ints
    taps: Ints
    ends: Ints
    line: Ints
    length: Floats
    diameter: Floats
    dropped: dict[str, int] = field(default_factory=dict)

    @property
    def incidence(self) -> Incidence:
        """Segments at each point."""
        return incidence_of(self.ends, len(self.position))

    def name_of(self, point: int) -> str:
        """Name of a point: of its node, or of its line."""
        node = int(self.node[point])
        return self.network.node_names[node] if node >= 0 else f"vertex {point}"

    def directions(self) -> Floats:
        """Unit vectors along the segments, (s, 3)."""
        step = self.position[self.ends[:, 1]] - self.position[self.ends[:, 0]]
        return np.asarray(step / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-12))


def incidence_of(ends: Ints, points: int) -> Incidence:
    """Segments at each point, see `Incidence`.

    Args:
        ends: points at the ends of each segment, (s, 2).
        points: number of points.
    """
    flat = ends.ravel()
    order = np.argsort(flat, kind="stable")
    first = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=points))])
    segments = order // 2
    return Incidence(first.astype(np.intp), segments, ends[segments, 1 - order % 2])


def mains_graph(network: NetworkMap) -> MainsGraph:
    """The graph of a map's mains.

    Raises:
        PipenavError: every line is a service.
    """
    mains = np.flatnonzero(~network.service)
    if not len(mains):
        raise PipenavError("every line of the map is a service: there is no main to survey; check --service-bore.")
    counts = np.diff(network.offsets)[mains]
    nodes = len(network.position)
    taken = np.concatenate([np.arange(network.offsets[i], network.offsets[i + 1]) for i in mains.tolist()])
    position = np.concatenate([network.position, network.vertices[taken.astype(np.intp)]])
    node = np.concatenate([np.arange(nodes), np.full(len(taken), -1)])
    line = np.repeat(mains, counts + 1)
    begins = np.concatenate([[0], np.cumsum(counts + 1)])[:-1]
    chain_start, chain_end = np.empty(len(line), np.intp), np.empty(len(line), np.intp)
    inner = np.ones(len(line), bool)
    inner[begins] = False
    chain_start[begins] = network.ends[mains, 0]
    chain_start[inner] = nodes + np.arange(len(taken))
    chain_end[:-1][inner[1:]] = chain_start[1:][inner[1:]]
    chain_end[begins + counts] = network.ends[mains, 1]
    ends = np.stack([chain_start, chain_end], axis=1)
    drawn = np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)
    whole = np.add.reduceat(drawn, begins)
    length = drawn * np.repeat(network.length[mains] / np.maximum(whole, 1e-9), counts + 1)
    taps = np.bincount(network.ends[network.service].ravel(), minlength=len(position))
    graph = MainsGraph(network, position, node, taps, ends, line, length, network.diameter[line])
    return compacted(graph if network.fabricated else simplified(graph))


def simplified(graph: MainsGraph) -> MainsGraph:
    """The graph without points that are no fittings; lengths stay what they were."""
    near = graph.incidence
    segments = [(int(a), int(b)) for a, b in graph.ends]
    alive = [True] * len(segments)
    length = graph.length.tolist()
    at: list[list[int]] = [near.segments[a:b].tolist() for a, b in zip(near.first, near.first[1:], strict=False)]
    drawn = np.linalg.norm(graph.position[graph.ends[:, 1]] - graph.position[graph.ends[:, 0]], axis=1)
    in_line, short = _in_line(graph, near), np.zeros(len(graph.position), bool)
    short[graph.ends[drawn < LEAST_LEG].ravel()] = True
    dropped = {"in-line": 0, "short-leg": 0}
    diameter = graph.diameter
    for point in np.flatnonzero((in_line | short) & (near.degree == 2)).tolist():
        if len(at[point]) != 2:
            continue
        one, other = at[point]
        if one == other or not _same_bore(diameter[one], diameter[other]):
            continue
        far = [next(end for end in segments[s] if end != point) for s in (one, other)]
        legs = [float(np.linalg.norm(graph.position[end] - graph.position[point])) for end in far]
        if far[0] == far[1] or not (in_line[point] or min(legs) < LEAST_LEG):
            continue
        dropped["short-leg" if min(legs) < LEAST_LEG else "in-line"] += 1
        keep, gone = (one, other) if length[one] >= length[other] else (other, one)
        segments[keep] = (far[0], far[1])
        length[keep] += length[gone]
        alive[gone] = False
        at[point] = []
        ends = [far[0], far[1]]
        for end in ends:
            at[end] = [keep if s == gone else s for s in at[end]]
    kept = np.array(alive)
    return MainsGraph(
        graph.network,
        graph.position,
        graph.node,
        graph.taps,
        np.array(segments, np.intp)[kept],
        graph.line[kept],
        np.array(length)[kept],
        graph.diameter[kept],
        {reason: count for reason, count in dropped.items() if count},
    )


def _same_bore(one: float, other: float) -> bool:
    return bool(abs(one - other) < BORE_STEP or (np.isnan(one) and np.isnan(other)))


def _in_line(graph: MainsGraph, near: Incidence) -> Flags:
    """Whether a vertex of a line, no node, lies on the line of its two neighbours, (p,)."""
    flags = np.zeros(len(graph.position), bool)
    points = np.flatnonzero((near.degree == 2) & (graph.node < 0))
    if len(points):
        before, after = near.others[near.first[points]], near.others[near.first[points] + 1]
        chord = graph.position[after] - graph.position[before]
        off = np.cross(graph.position[points] - graph.position[before], chord)
        size = np.maximum(np.linalg.norm(chord, axis=1), 1e-9)
        flags[points] = np.linalg.norm(off, axis=1) / size < COLLINEAR
    return flags


def compacted(graph: MainsGraph) -> MainsGraph:
    """The graph without points at which no segment ends."""
    used = np.unique(graph.ends)
    number = np.full(len(graph.position), -1, np.intp)
    number[used] = np.arange(len(used))
    return MainsGraph(
        graph.network,
        graph.position[used],
        graph.node[used],
        graph.taps[used],
        number[graph.ends],
        graph.line,
        graph.length,
        graph.diameter,
        graph.dropped,
    )
