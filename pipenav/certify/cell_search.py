"""Search for a proof that no path leads through cells: they are refined where one may."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.certify.cells import ROUNDING, Cells, Evaluate, Span, coarsest, neighbours, overlapping, split, width_of

MOST_WORK = 1_000_000
"""Most cells that a search looks at, those of every round counted: a few seconds."""

LEAST_SHARE = 30
"""Cells among which one is refined in every round at least."""

NEARLY_SHORTEST = 0.5
"""Length of the paths whose cells are refined at once, as a multiple of the shortest one's."""

UNIFORM = 2
"""Level up to which all cells are refined: there are few, and none of them shows where a path leads."""

STUCK = 4.0
"""Length of the way through a smallest cell that is not known to be free, in widths: other ways are tried first."""

LEAST = 1e-6
"""Length of the way through a free cell, as a share of its width: paths prefer free cells over any others."""


class Searched(NamedTuple):
    """Result of a search.

    Attributes:
        proven: whether no path leads from a start to a goal.
        finest: width of the smallest cells [rad].
    """

    proven: bool
    finest: float


def search(evaluate: Evaluate, axes: int, resolution: float, most_work: int = MOST_WORK) -> Searched:
    """Refine cells until start and goal are apart, or a path leads through free middles.

    Args:
        evaluate: spans of cells.
        axes: number of headings.
        resolution: width of the smallest cells [rad].
        most_work: most cells that it looks at, those of every round counted.
    """
    deepest = max(0, math.ceil(math.log2(float(width_of(0)) / resolution) - 1e-9))
    cells, work, finest = coarsest(evaluate, axes), 0, float(width_of(0))
    while True:
        cells, pairs = _between(cells)
        if not len(cells.level):
            return Searched(True, finest)
        ways = _Ways.of(cells, pairs, deepest)
        doubtful = _doubtful(cells, ways.shortest())
        refine = _to_refine(cells, ways, doubtful, deepest)
        work += len(cells.level)
        if not (doubtful & (cells.level < deepest)).any() or not refine.any() or work > most_work:
            return Searched(False, finest)
        cells = split(evaluate, cells, refine)
        finest = min(finest, float(cells.width.min(initial=finest)))


def _to_refine(cells: Cells, ways: _Ways, doubtful: Flags, deepest: int) -> Flags:
    """Cells to halve: the largest doubtful ones of the shortest path, and their like on paths of nearly its length."""
    if cells.level.min() < min(UNIFORM, deepest):
        return np.asarray(cells.level < UNIFORM)
    open_ = doubtful & (cells.level < deepest)
    level = int(cells.level[open_].min(initial=deepest))
    like = ~_known(cells) & (cells.level <= level) & (cells.level < deepest)
    near = ways.total.min() + NEARLY_SHORTEST * cells.width
    if like.any():  # some at least, so that the number of rounds stays small
        share = min(len(cells.level) // LEAST_SHARE, int(like.sum()) - 1)
        near = np.maximum(near, np.partition(ways.total[like], share)[share])
    return np.asarray(open_ & (cells.level <= level) | (like & (ways.total <= near)))


def _known(cells: Cells) -> Flags:
    """Cells whose middle is free; where they may hold a start or a goal, it is one, (n,)."""
    start, goal = cells.outer.start & ~cells.middle.start, cells.outer.goal & ~cells.middle.goal
    return np.asarray(cells.middle.free & ~start & ~goal)


def _doubtful(cells: Cells, path: Sequence[int]) -> Flags:
    """Cells of a path whose middle is not free, or not joined to that of the next one, (n,)."""
    row = np.asarray(path, np.intp)
    doubtful = np.zeros(len(cells.level), bool)
    doubtful[row] = ~cells.middle.free[row]
    doubtful[row[:1]] |= ~cells.middle.start[row[:1]]
    doubtful[row[-1:]] |= ~cells.middle.goal[row[-1:]]
    low, high = cells.middle.low[row], cells.middle.high[row]
    apart = np.maximum(low[:-1], low[1:]) > np.minimum(high[:-1], high[1:])
    doubtful[row[:-1][apart]] = doubtful[row[1:][apart]] = True
    return doubtful


def _between(cells: Cells) -> tuple[Cells, Ints]:
    """Cells in components that hold both a start and a goal, and the pairs of them that are joined, (pairs, 2)."""
    from scipy.sparse.csgraph import connected_components

    none = np.zeros((0, 2), np.intp)
    if not (cells.outer.start.any() and cells.outer.goal.any()):
        return cells.rows(np.zeros(len(cells.level), bool)), none
    pairs = neighbours(cells)
    pairs = pairs[overlapping(cells.outer, pairs, ROUNDING)]
    parts = connected_components(_graph(len(cells.level), pairs, np.ones(len(pairs))), directed=False)[1]
    kept = np.isin(parts, np.intersect1d(parts[cells.outer.start], parts[cells.outer.goal]))
    return cells.rows(kept), (np.cumsum(kept) - 1)[pairs[kept[pairs[:, 0]]]]


def _graph(n: int, pairs: Ints, weights: Floats) -> object:
    from scipy.sparse import coo_array

    return coo_array((weights, (pairs[:, 0], pairs[:, 1])), shape=(n, n)).tocsr()


class _Ways(NamedTuple):
    """Lengths of the shortest paths through each cell, where only cells that are not known to be free count.

    Attributes:
        from_start: length from the nearest start, (n,).
        before: row of the cell before on that path, negative at a start, (n,).
        total: length of the shortest path from start to goal through each cell, (n,).
        goal: cells that hold a goal, (n,).
    """

    from_start: Floats
    before: Ints
    total: Floats
    goal: Flags

    @classmethod
    def of(cls, cells: Cells, pairs: Ints, deepest: int) -> _Ways:
        """The ways through joined cells, of which those at the deepest level are not refined any more."""
        from scipy.sparse.csgraph import dijkstra

        n = len(cells.level)
        joined = overlapping(cells.middle, pairs, 0.0)
        cost = np.where(_known(cells), LEAST, np.where(cells.level < deepest, 1.0, STUCK)) * cells.width
        both_free = cells.middle.free[pairs].all(axis=1)
        # Two free cells whose free values do not overlap are joined only if something between them opens.
        weights = cost[pairs].mean(axis=1) + np.where(both_free & ~joined, cells.width[pairs].mean(axis=1), 0.0)
        graph = _graph(n, pairs, weights)
        start, goal = _ends(cells.outer, cells.middle, "start"), _ends(cells.outer, cells.middle, "goal")
        ahead, before, _ = dijkstra(graph, directed=False, indices=start, min_only=True, return_predecessors=True)
        behind = dijkstra(graph, directed=False, indices=goal, min_only=True)
        ends = np.zeros(n, bool)
        ends[goal] = True
        return cls(ahead, np.asarray(before, np.intp), ahead + behind, ends)

    def shortest(self) -> list[int]:
        """Rows of the cells on the shortest path."""
        at = int(np.where(self.goal, self.from_start, np.inf).argmin())
        path = []
        while at >= 0:
            path.append(at)
            at = int(self.before[at])
        return path[::-1]


def _ends(outer: Span, middle: Span, which: Literal["start", "goal"]) -> Ints:
    """Cells that hold a start or a goal; those that hold a free one for certain, if there are any."""
    certain, possible = getattr(middle, which), getattr(outer, which)
    return np.flatnonzero(certain if certain.any() else possible)
