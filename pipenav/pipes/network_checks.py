"""Networks that are refused: nodes and pipes that do not fit, pieces that do not connect, pipes that cross."""

from __future__ import annotations

from collections import Counter
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from pipenav.errors import PipenavError, UnknownName, shown
from pipenav.pipes.convex import apart
from pipenav.pipes.corner_checks import DIAMETER_RANGE_MM, LEG_MAX_MM, WALL_RANGE_MM, check_range
from pipenav.pipes.route_legs import SPACING
from pipenav.units import m_to_mm

if TYPE_CHECKING:
    from pipenav.pipes.network import PipeNetwork

MAX_NETWORK_PIPES = 500
"""Pipes of the largest network: the test whether any two cross takes some seconds then."""

MOST_PIPES = 4
"""Pipes that can meet in a node: those of a cross."""

LEAST_PIPE_MM = 1.0
"""Length of the shortest pipe of a network; what its fittings need besides is asked of the routes through it."""

FARTHEST_M = 1000.0
"""Largest coordinate of a node [m]."""


def check_pipes(network: PipeNetwork) -> None:
    """Refuse a network whose nodes and pipes do not fit together.

    Raises:
        PipenavError: with the node or the pipe, and what is allowed.
    """
    check_range("wall thickness", m_to_mm(network.wall), *WALL_RANGE_MM, "mm")
    if not 1 <= len(network.pipes) <= MAX_NETWORK_PIPES:
        raise PipenavError(f"a network of {len(network.pipes)} pipes is not possible: give 1 to {MAX_NETWORK_PIPES}.")
    for name, node in network.nodes.items():
        for axis, value in zip("xyz", node.position, strict=True):
            check_range(f"{axis} of node {shown(name)}", value, -FARTHEST_M, FARTHEST_M, "m")
    for pipe in network.pipes:
        for name in (pipe.start, pipe.end):
            if name not in network.nodes:
                raise UnknownName("node", name, network.nodes)
        check_range(
            f"diameter of the pipe from {shown(pipe.start)} to {shown(pipe.end)}",
            m_to_mm(pipe.diameter),
            *DIAMETER_RANGE_MM,
            "mm",
        )
        if pipe.start == pipe.end:
            raise PipenavError(f"a pipe leads from {shown(pipe.start)} to itself: name two nodes.")
        if network.nodes[pipe.start].position == network.nodes[pipe.end].position:
            raise PipenavError(f"nodes {shown(pipe.start)} and {shown(pipe.end)} of a pipe lie in one place: move one.")
        start, end = network.nodes[pipe.start].position, network.nodes[pipe.end].position
        length = np.linalg.norm(np.subtract(end, start))
        what = f"length of the pipe from {shown(pipe.start)} to {shown(pipe.end)}"
        check_range(what, m_to_mm(float(length)), LEAST_PIPE_MM, LEG_MAX_MM, "mm")
    twice = Counter(frozenset((pipe.start, pipe.end)) for pipe in network.pipes).most_common(1)[0]
    if twice[1] > 1:
        raise PipenavError(f"{twice[1]} pipes lead from {' to '.join(sorted(twice[0]))}: give one.")
    _check_nodes(network)


def _check_nodes(network: PipeNetwork) -> None:
    for name, node in network.nodes.items():
        count = len(network.pipes_at(name))
        if not 1 <= count <= MOST_PIPES:
            raise PipenavError(f"{count} pipes meet in node {shown(name)}: choose 1 to {MOST_PIPES}, or leave it out.")
        if node.capped and count > 1:
            raise PipenavError(f"node {shown(name)} is capped, but {count} pipes meet there: a cap closes one pipe.")
        if (node.bend_radius or node.length) and count != 2:
            raise PipenavError(
                f"node {shown(name)} has a bend radius or a reducer's length, and {count} pipes meet there: "
                "two make a bend or a reducer."
            )
    reached, waiting = set(), [next(iter(network.nodes))]
    while waiting:
        name = waiting.pop()
        if name not in reached:
            reached.add(name)
            waiting += [pipe.other(name) for pipe in network.pipes_at(name)]
    if alone := [name for name in network.nodes if name not in reached]:
        raise PipenavError(
            f"no way leads from {shown(next(iter(network.nodes)))} to {shown(alone[0])}: join the pieces of the "
            "network, or give each a file of its own."
        )
    if not any(len(network.pipes_at(name)) == 1 and not node.capped for name, node in network.nodes.items()):
        raise PipenavError("the network has no open end, so that no robot gets in: open a ring, or leave out a cap.")


def check_apart(network: PipeNetwork) -> None:
    """Refuse a network two of whose pipes meet though they share no node.

    Raises:
        PipenavError: with the two pipes.
    """
    around = np.arange(16) * 2 * np.pi / 16
    ends = np.array(
        [[network.nodes[name].position for name in (pipe.start, pipe.end)] for pipe in network.pipes]
    )  # (pipes, 2, 3)
    outside = np.array([pipe.diameter / 2 + network.wall for pipe in network.pipes])
    low, high = ends.min(axis=1) - outside[:, None] - SPACING, ends.max(axis=1) + outside[:, None] + SPACING
    rods = []
    for (start, end), radius in zip(ends, outside, strict=True):
        along = (end - start) / np.linalg.norm(end - start)
        left = np.cross(along, np.eye(3)[np.abs(along).argmin()])
        left /= np.linalg.norm(left)
        circle = np.cos(around)[:, None] * left + np.sin(around)[:, None] * np.cross(along, left)
        rods.append(np.concatenate([start + radius * circle, end + radius * circle]))
    for i, j in combinations(range(len(network.pipes)), 2):
        one, other = network.pipes[i], network.pipes[j]
        if {one.start, one.end} & {other.start, other.end} or (low[i] > high[j]).any() or (low[j] > high[i]).any():
            continue
        if not apart(rods[i], rods[j], SPACING):
            raise PipenavError(
                f"the network crosses itself: the pipes {one.start} to {one.end} and {other.start} to {other.end} "
                "would touch or nearly touch; join them in a node, or move one."
            )
