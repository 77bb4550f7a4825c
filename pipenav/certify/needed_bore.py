"""The bore that a robot needs in a corner: the largest one proven impossible, and the smallest one with a motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.certify.cell_search import MOST_WORK
from pipenav.certify.model import Model
from pipenav.certify.verdict import not_covered, passable, proof_of
from pipenav.pipes.corner_checks import DIAMETER_RANGE_MM
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.episode import START_WALL_DISTANCE
from pipenav.units import m_to_mm, mm_to_m

STEP = 2.5e-4
"""Accuracy of a bore [m]: a quarter of a millimetre."""

LARGEST = 0.2
"""Largest bore that is looked at [m]."""

BELOW = 2e-3
"""Distance below the smallest passable bore at which a proof is looked for first; it doubles from then on [m]."""


AGAIN = (1e-3, 2e-3, 4e-3, 6e-3, 8e-3)
"""Distances below the smallest passable bore that was found at which a motion is looked for once more [m]."""

FRONTIER_WORK = MOST_WORK // 4
"""Most cells of an arm that each proof looks at: a quarter of a single certificate's, as there are many."""

APART_ARM, APART_WHOLE = 2.5e-3, 5e-4
"""Distance of the two bores from which they are looked at again, for arms and for whole robots [m]."""


class NeededBore(NamedTuple):
    """Bores between which the frontier lies.

    Attributes:
        impossible: largest bore that is proven impossible [m]; None where none was found to be.
        passable: smallest bore with a motion [m]; None where none was found up to `LARGEST`.
    """

    impossible: float | None
    passable: float | None

    def __str__(self) -> str:
        """The two bores in mm, with a dash for one that is not known."""
        return " to ".join("-" if bore is None else f"{m_to_mm(bore):.1f}" for bore in self)


def needed_bore(model: Model, resolution: float) -> NeededBore:
    """Bores between which the frontier of pipes like the given one lies; the bend keeps its radius in bores.

    Where they lie far apart, motions are looked for at every step between them, and proofs with all cells of a single
    certificate's.

    Args:
        model: what is certified.
        resolution: width of the smallest cells [rad].
    """
    least = narrowest(model.robot)
    if not_covered(model):
        return NeededBore(None, None)
    smallest = _smallest_passable(model, least)
    bores = (least, smallest or LARGEST)
    largest = _largest_impossible(model, resolution, bores, FRONTIER_WORK)
    if smallest is None or smallest - (largest or least) <= (APART_WHOLE if model.robot.free else APART_ARM):
        return NeededBore(largest, smallest)
    between = np.arange((largest or least) + STEP, smallest, STEP).tolist()
    smallest = next((bore for bore in between if passable(model.with_bore(bore), None) is not None), smallest)
    return NeededBore(_largest_impossible(model, resolution, (largest or least, smallest), MOST_WORK), smallest)


def narrowest(robot: RobotSpec) -> float:
    """Smallest bore that a pipe may have and in which a robot fits at rest [m]."""
    return max(mm_to_m(DIAMETER_RANGE_MM[0]), robot.width + 2 * START_WALL_DISTANCE)


def _smallest_passable(model: Model, least: float) -> float | None:
    if passable(model.with_bore(LARGEST), None) is None:
        return None
    if passable(model.with_bore(least), None) is not None:
        return least
    low, high = least, LARGEST
    while True:
        while high - low > STEP:
            middle = (low + high) / 2
            if passable(model.with_bore(middle), None) is None:
                low = middle
            else:
                high = middle
        # Motions are found with luck: a bore without one may lie above others that have one.
        narrower = (high - below for below in AGAIN if high - below > least)
        found = next((bore for bore in narrower if passable(model.with_bore(bore), None) is not None), None)
        if found is None:
            return high
        low, high = least, found


def _largest_impossible(model: Model, resolution: float, bores: tuple[float, float], work: int) -> float | None:
    """Largest bore with a proof among those from one on to below one with a motion [m], with so many cells each."""
    least, smallest = bores
    high, below = smallest, BELOW
    while True:
        low = max(least, smallest - below)
        if proof_of(model.with_bore(low), None, resolution, work) is not None:
            break
        if low <= least:
            return None
        high, below = low, 2 * below
    while high - low > STEP:
        middle = (low + high) / 2
        if proof_of(model.with_bore(middle), None, resolution, work) is None:
            high = middle
        else:
            low = middle
    return low
