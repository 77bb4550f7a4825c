"""Cells of headings, each with an interval of one more coordinate, refined where a path may or may not lead through.

The cells lie on a torus: one axis for each heading, each a whole turn around. Every cell has two intervals of the
further coordinate: `outer` holds every value at which any heading of the cell is free, `middle` those at which the
heading in its middle is. Two cells that share a face are joined where their intervals overlap. If start and goal are in
different components by the outer intervals, there is no free path: a proof. Cells whose middle is free cannot be
excluded by any refinement; the others on the way are refined.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Self

import numpy as np

from pipenav.arrays import Flags, Floats, Ints

ROUNDING = 1e-6
"""Slack of every comparison in a proof [m]: floating-point errors are a millionth of it."""

COARSEST = 24
"""Number of the largest cells in a whole turn: 15 deg each."""


class Span(NamedTuple):
    """Free values of the further coordinate in cells, and which cells hold a start or a goal.

    Attributes:
        low: smallest free value, (n,).
        high: largest; a cell with high < low is not free, (n,).
        start: whether a start lies in the cell, (n,).
        goal: whether a goal lies in it, (n,).
    """

    low: Floats
    high: Floats
    start: Flags
    goal: Flags

    def rows(self, which: Ints | Flags) -> Self:
        """Some of the cells."""
        return type(self)(self.low[which], self.high[which], self.start[which], self.goal[which])

    @property
    def free(self) -> Flags:
        """Cells that have a free value, (n,)."""
        return np.asarray(self.low <= self.high)


class Cells(NamedTuple):
    """Cells of several sizes, none inside another.

    Attributes:
        level: how often the coarsest cell was halved, (n,).
        place: place on the torus in units of the cell's own width, (n, axes).
        outer: values at which any heading of the cell may be free.
        middle: values at which the heading in its middle is free, and whether it is one of a start or a goal.
    """

    level: Ints
    place: Ints
    outer: Span
    middle: Span

    def rows(self, which: Ints | Flags) -> Self:
        """Some of the cells."""
        return type(self)(self.level[which], self.place[which], self.outer.rows(which), self.middle.rows(which))

    @property
    def width(self) -> Floats:
        """Widths, (n,) [rad]."""
        return np.asarray(width_of(self.level))

    @property
    def centres(self) -> Floats:
        """Headings in the middle of the cells, from -pi to pi, (n, axes) [rad]."""
        return np.asarray(-math.pi + (self.place + 0.5) * self.width[:, None])


def width_of(level: Ints | int) -> Floats:
    """Width of cells of a level [rad]."""
    return np.asarray(2 * math.pi / (COARSEST * 2.0 ** np.asarray(level)))


Evaluate = Callable[[Floats, float], tuple[Span, Span]]
"""Outer spans of cells, and spans of the headings in their middles.

Arguments: the middles, (n, axes) [rad], and half of the cells' width [rad].
"""


def coarsest(evaluate: Evaluate, axes: int) -> Cells:
    """All cells of the first level that may be free."""
    index = np.stack(np.meshgrid(*[np.arange(COARSEST)] * axes, indexing="ij"), -1).reshape(-1, axes)
    return _evaluated(evaluate, np.zeros(len(index), np.intp), index)


def split(evaluate: Evaluate, cells: Cells, which: Flags) -> Cells:
    """The cells with some of them halved along every axis.

    Args:
        evaluate: spans of cells.
        cells: the cells.
        which: flags of those to split, (n,).
    """
    axes = cells.place.shape[1]
    corners = np.stack(np.meshgrid(*[np.arange(2)] * axes, indexing="ij"), -1).reshape(-1, axes)
    parents = cells.rows(which)
    found = [cells.rows(~which)]
    for level in np.unique(parents.level).tolist():
        index = (2 * parents.place[parents.level == level][:, None] + corners).reshape(-1, axes)
        found.append(_evaluated(evaluate, np.full(len(index), level + 1, np.intp), index))
    return _joined(found)


def _evaluated(evaluate: Evaluate, level: Ints, index: Ints) -> Cells:
    """Cells of one level, without those that are not free."""
    half = float(width_of(int(level[0]))) / 2
    outer, middle = evaluate(np.asarray(-math.pi + (index + 0.5) * 2 * half), half)
    return Cells(level, index, outer, middle).rows(outer.free)


def _joined(parts: list[Cells]) -> Cells:
    outer = Span(*(np.concatenate(columns) for columns in zip(*(part.outer for part in parts), strict=True)))
    middle = Span(*(np.concatenate(columns) for columns in zip(*(part.middle for part in parts), strict=True)))
    level = np.concatenate([part.level for part in parts])
    return Cells(level, np.concatenate([part.place for part in parts]), outer, middle)


def neighbours(cells: Cells) -> Ints:
    """Pairs of cells that share a face, (pairs, 2): of one size, or a smaller cell and a larger one."""
    axes = cells.place.shape[1]
    found = [np.zeros((0, 2), np.intp)]
    levels = np.unique(cells.level).tolist()
    tables = {level: _Table.of(cells, level) for level in levels}
    for level in levels:
        table, around = tables[level], COARSEST << level
        for axis in range(axes):
            for step in (1, -1):
                beside = cells.place[table.rows].copy()
                beside[:, axis] = (beside[:, axis] + step) % around
                for other in [k for k in levels if k < level or (k == level and step == 1)]:
                    here, there = tables[other].find(beside >> (level - other))
                    found.append(np.stack([table.rows[here], there], axis=1))
    return np.concatenate(found)


class _Table(NamedTuple):
    """Cells of one level in the order of their keys.

    Attributes:
        rows: their rows among all cells, (m,).
        keys: keys in ascending order, (m,).
        weights: factors that make a key of an index, (axes,).
    """

    rows: Ints
    keys: Ints
    weights: Ints

    @classmethod
    def of(cls, cells: Cells, level: int) -> _Table:
        """The cells of one level."""
        rows = np.flatnonzero(cells.level == level)
        weights = np.asarray((COARSEST << level) ** np.arange(cells.place.shape[1])[::-1], np.intp)
        keys = cells.place[rows] @ weights
        order = np.argsort(keys, kind="stable")
        return cls(rows[order], keys[order], weights)

    def find(self, index: Ints) -> tuple[Ints, Ints]:
        """Rows of the given indices that are in the table, and their rows among all cells."""
        wanted = index @ self.weights
        at = np.minimum(np.searchsorted(self.keys, wanted), len(self.keys) - 1)
        here = np.flatnonzero(self.keys[at] == wanted)
        return here, self.rows[at[here]]


def overlapping(span: Span, pairs: Ints, slack: float) -> Flags:
    """Which pairs have intervals that overlap, both free, (pairs,)."""
    one, other = pairs.T
    low = np.maximum(span.low[one], span.low[other])
    return np.asarray(low <= np.minimum(span.high[one], span.high[other]) + slack)
