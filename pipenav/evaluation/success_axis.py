"""The axis of success in pictures: it widens towards 100 %, so that 99.2 and 100 can be told apart."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pipenav.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SUCCESS_LABEL = "success [%]"

STARTS = (90.0, 50.0, 0.0)
"""Values [percent] at which the axis may start. A cut axis shows small differences; it never starts above 90."""

TICKS = {
    90.0: (90, 92, 94, 96, 98, 99, 100),
    50.0: (50, 60, 70, 80, 90, 95, 99, 100),
    0.0: (0, 25, 50, 75, 90, 99, 100),
}
"""Ticks by the value at which the axis starts [percent]."""

ROOM = 0.05
"""Room beyond both ends, as a share of the axis, so that markers there are whole."""


class AxisLimits(NamedTuple):
    """Ends of an axis [percent]."""

    low: float
    high: float


def axis_start(lowest: float) -> float:
    """Value [percent] at which an axis starts that shows a lowest share [percent]."""
    return next(start for start in STARTS if lowest >= start)


def widen(axes: Axes, lowest: float, across: bool = False) -> None:
    """Give axes a scale of percentages on which the distance to 100 grows with the root of the failures.

    Args:
        axes: the axes.
        lowest: lowest value that must be seen [percent].
        across: whether success goes to the right; otherwise it goes upwards.
    """
    from matplotlib.ticker import FixedLocator, NullLocator

    (axes.set_xscale if across else axes.set_yscale)("function", functions=(_forward, _back))
    axis = axes.xaxis if across else axes.yaxis
    axis.set_major_locator(FixedLocator(TICKS[axis_start(lowest)]))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter("{x:g}")


def _forward(success: Floats) -> Floats:
    failure = 100.0 - np.asarray(success, dtype=float)
    return np.asarray(-np.sign(failure) * np.sqrt(np.abs(failure)))


def _back(height: Floats) -> Floats:
    height = np.asarray(height, dtype=float)
    return np.asarray(100.0 + np.sign(height) * height**2)


def limits(lowest: float) -> AxisLimits:
    """Ends of the axis [percent] with room for markers at both."""
    start = float(_forward(np.array(axis_start(lowest))))
    low, high = _back(np.array([start * (1 + ROOM), -start * ROOM]))
    return AxisLimits(float(low), float(high))
