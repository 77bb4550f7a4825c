"""Motions of an arm through cells of headings, tested before they count."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipenav.arrays import Floats
from pipenav.certify.arm import ArmSpans, configuration
from pipenav.certify.cells import Cells
from pipenav.certify.motion_check import check_by_distance, check_by_shapely


class ArmAttempt:
    """Makes a motion through the middles of cells, and keeps it if both tests find it free.

    Args:
        spans: free slides of the arm.
    """

    def __init__(self, spans: ArmSpans) -> None:
        self._spans = spans

    def __call__(self, cells: Cells, path: Sequence[int]) -> Floats | None:
        """Configurations in the robot's own frame, (rows, joints); None where a test fails.

        The slide moves while all headings stand, then the headings move while the slide stands.
        """
        spans, row = self._spans, np.asarray(path, np.intp)
        headings = _unwrapped(cells.centres[row])
        low, high = cells.middle.low[row], cells.middle.high[row]
        at = spans.target_slides(headings[-1:])
        end = float(np.clip((at.low[0] + at.high[0]) / 2, low[-1], high[-1]))
        if not at.low[0] <= end <= at.high[0]:
            return None
        start_slide = sum(spans.ends.start_slide) / 2
        slides = _junctions(low, high, start_slide, end)
        if slides is None:
            return None
        # Every cell has two rows: with the slide of the junction before it, and with that of the one after it.
        rows = np.concatenate([spans.ends.start[None], np.repeat(headings, 2, axis=0)])
        every = np.concatenate([slides[:1], np.repeat(slides, 2)[1:-1]])
        q = configuration(spans.model, spans.ends.base, every, rows)
        q = q[np.concatenate([[True], np.abs(np.diff(q, axis=0)).max(axis=1) > 0])]
        if not check_by_distance(spans.model, q, spans.ends.base).free:
            return None
        return q if check_by_shapely(spans.model, q, spans.ends.base).free else None


def _unwrapped(headings: Floats) -> Floats:
    """Headings without jumps by a whole turn."""
    return np.asarray(np.unwrap(headings, axis=0, period=2 * math.pi))


def _junctions(low: Floats, high: Floats, start: float, end: float) -> Floats | None:
    """Slides at the start, between any two cells and at the end, (cells + 1,) [m]; None where two do not overlap.

    Each is as near to the middle of what both cells allow as half of the way from the one before.
    """
    least, most = np.maximum(low[:-1], low[1:]), np.minimum(high[:-1], high[1:])
    if (least > most).any() or not low[0] <= start <= high[0]:
        return None
    found = [start]
    for one, other in zip(least.tolist(), most.tolist(), strict=True):
        found.append(min(max((found[-1] + (one + other) / 2) / 2, one), other))
    return np.array([*found, end])
