"""Search for a path through cells, which are refined until there is one, or a proof that there is none."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.certify.cells import ROUNDING, Cells, Evaluate, Span, coarsest, neighbours, overlapping, split, width_of

MOST_WORK = 600_000
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
        verdict: `path`, `none` where there is a proof, or `undecided`.
        motion: configurations of a motion, (rows, coordinates); None where there is none.
        finest: width of the smallest cells [rad].
    """

    verdict: Literal["path", "none", "undecided"]
    motion: Floats | None
    finest: float


Attempt = Callable[[Cells, Sequence[int]], Floats | None]
"""Makes a motion through the middles of some cells and tests it: configurations, or None where the test fails."""


def search(evaluate: Evaluate, axes: int, resolution: float, attempt: Attempt, most_work: int = MOST_WORK) -> Searched:
    """Refine cells until a motion is found, or start and goal are apart.

    Args:
        evaluate: spans of cells.
        axes: number of headings.
        resolution: width of the smallest cells [rad].
        attempt: makes a motion of a path through cells.
        most_work: most cells that it looks at, those of every round counted.
    """
    deepest = max(0, math.ceil(math.log2(float(width_of(0)) / resolution) - 1e-9))
    cells, work, finest = coarsest(evaluate, axes), 0, float(width_of(0))
    tried: set[tuple[int, ...]] = set()
    while True:
        cells, pairs = _between(cells)
        if not len(cells.level):
            return Searched("none", None, finest)
        ways = _Ways.of(cells, pairs, deepest)
        path = ways.shortest()
        doubtful = _doubtful(cells, path)
        keys = tuple(cells.place[path].ravel().tolist())
        if keys not in tried and (cells.middle.low[path] <= cells.middle.high[path]).all():
            tried.add(keys)
            if (motion := attempt(cells, path)) is not None:
                return Searched("path", motion, finest)
        refine = _to_refine(cells, ways, doubtful, deepest)
        work += len(cells.level)
        if not refine.any() or work > most_work:
            return Searched("undecided", None, finest)
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
    """Cells that are free for certain; where they may hold a start or a goal, they do, (n,)."""
    start, goal = cells.outer.start & ~cells.inner.start, cells.outer.goal & ~cells.inner.goal
    return np.asarray(cells.inner.free & ~start & ~goal)


def _doubtful(cells: Cells, path: Sequence[int]) -> Flags:
    """Cells of a path that are not known to be free, or not known to be joined to the next one, (n,)."""
    row = np.asarray(path, np.intp)
    doubtful = np.zeros(len(cells.level), bool)
    doubtful[row] = ~cells.inner.free[row]
    doubtful[row[:1]] |= ~cells.inner.start[row[:1]]
    doubtful[row[-1:]] |= ~cells.inner.goal[row[-1:]]
    low, high = cells.inner.low[row], cells.inner.high[row]
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
        joined = overlapping(cells.inner, pairs, 0.0)
        hopeful = np.where(cells.middle.low <= cells.middle.high, 0.5, np.where(cells.level < deepest, 1.0, STUCK))
        cost = np.where(_known(cells), LEAST, hopeful) * cells.width
        both_free = cells.inner.free[pairs].all(axis=1)
        # Two free cells whose free values do not overlap are joined only if something between them opens.
        weights = cost[pairs].mean(axis=1) + np.where(both_free & ~joined, cells.width[pairs].mean(axis=1), 0.0)
        graph = _graph(n, pairs, weights)
        start, goal = _ends(cells.outer, cells.inner, "start"), _ends(cells.outer, cells.inner, "goal")
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


def _ends(outer: Span, inner: Span, which: Literal["start", "goal"]) -> Ints:
    """Cells that hold a start or a goal; those that hold a free one for certain, if there are any."""
    certain, possible = getattr(inner, which), getattr(outer, which)
    return np.flatnonzero(certain if certain.any() else possible)
