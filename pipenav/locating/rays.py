"""Rays of k robots, and steps on their arrays that the votes of a corner map share."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints

Float = TypeVar("Float", np.float32, np.float64)


class Rays(NamedTuple):
    """All beams that k robots have sent so far, m of each.

    Attributes:
        tip: beginnings of the beams, (k, m, 2) [m].
        direction: unit vectors along the beams, (k, m, 2).
        end: ends of the beams, (k, m, 2) [m].
        met: whether each beam met a wall within the laser's range, (k, m).
        near: whether each beam read the laser's minimum, (k, m).
    """

    tip: Floats
    direction: Floats
    end: Floats
    met: Flags
    near: Flags

    def part(self, index: int | Ints | None) -> Rays:
        """Rays of one robot or some; None puts an axis before those of one."""
        return Rays(self.tip[index], self.direction[index], self.end[index], self.met[index], self.near[index])


def weights(distance: NDArray[Float]) -> NDArray[Float]:
    """Votes by distance: 1 for a distance of 0, 0 from a distance of 1 on, a parabola in between.

    The result takes its argument's memory, which is large.
    """
    np.multiply(distance, distance, out=distance)
    np.subtract(1.0, distance, out=distance)
    return np.maximum(distance, 0.0, out=distance)


def packed(values: Floats, kept: Flags) -> Floats:
    """Kept values of each row of `values`, (k, m), in their order, then -inf, (k, most that a row keeps).

    Most beams say nothing about most questions, and leaving out a vote of 0 changes no bit of a sum.
    """
    count = kept.sum(axis=1)
    first = np.argsort(~kept, axis=1, kind="stable")[:, : count.max(initial=0)]
    return np.where(np.arange(first.shape[1]) < count[:, None], ordered(values, first), -np.inf)


def ordered(values: NDArray[Any], order: Ints) -> NDArray[Any]:
    """numpy.take_along_axis along the last axis, without an overhead that counts for a few hundred values."""
    rows = values.reshape(-1, values.shape[-1])
    return rows[np.arange(len(rows))[:, None], order.reshape(len(rows), -1)].reshape(order.shape)


def pick(values: Floats, index: Ints) -> Floats:
    """values[..., index] for an index (...) along the last axis, clipped to the range of indices, (...)."""
    rows = values.reshape(-1, values.shape[-1])
    clipped = np.minimum(np.maximum(index, 0), rows.shape[1] - 1).ravel()
    return np.asarray(rows[np.arange(len(rows)), clipped].reshape(index.shape))
