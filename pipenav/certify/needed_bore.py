"""The bore that a robot needs in a corner: the largest one proven impossible, and the smallest one with a motion."""

from __future__ import annotations

from typing import NamedTuple

from pipenav.certify.model import Model
from pipenav.certify.verdict import motion_of, not_covered, proof_of
from pipenav.pipes.corner_checks import DIAMETER_RANGE_MM
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.episode import START_WALL_DISTANCE
from pipenav.units import m_to_mm, mm_to_m, rad_to_deg

STEP = 2.5e-4
"""Accuracy of a bore [m]: a quarter of a millimetre."""

LARGEST = 0.2
"""Largest bore that is looked at [m]."""

BELOW = 2e-3
"""Distance below the smallest passable bore at which a proof is looked for first; it doubles from then on [m]."""


MOST_WORK = 250_000
"""Most cells of an arm that each proof looks at: a quarter of a single certificate's, as there are many."""


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

    Args:
        model: what is certified.
        resolution: width of the smallest cells [rad].
    """
    least = narrowest(model.robot)
    if not_covered(model):
        return NeededBore(None, None)
    passable = _smallest_passable(model, least)
    return NeededBore(_largest_impossible(model, resolution, least, passable or LARGEST), passable)


def narrowest(robot: RobotSpec) -> float:
    """Smallest bore that a pipe may have and in which a robot fits at rest [m]."""
    return max(mm_to_m(DIAMETER_RANGE_MM[0]), robot.width + 2 * START_WALL_DISTANCE)


def _smallest_passable(model: Model, least: float) -> float | None:
    low, high = least, LARGEST
    if motion_of(_with_bore(model, high), None) is None:
        return None
    if motion_of(_with_bore(model, low), None) is not None:
        return low
    while high - low > STEP:
        middle = (low + high) / 2
        if motion_of(_with_bore(model, middle), None) is None:
            low = middle
        else:
            high = middle
    return high


def _largest_impossible(model: Model, resolution: float, least: float, passable: float) -> float | None:
    high, below = passable, BELOW
    while True:
        low = max(least, passable - below)
        if proof_of(_with_bore(model, low), None, resolution, MOST_WORK) is not None:
            break
        if low <= least:
            return None
        high, below = low, 2 * below
    while high - low > STEP:
        middle = (low + high) / 2
        if proof_of(_with_bore(model, middle), None, resolution, MOST_WORK) is None:
            high = middle
        else:
            low = middle
    return low


def _with_bore(model: Model, diameter: float) -> Model:
    pipe = model.pipe
    bend = m_to_mm(pipe.bend_radius * diameter / pipe.diameter)
    return model._replace(pipe=type(pipe).of(m_to_mm(diameter), rad_to_deg(pipe.angle), pipe.turn, bend))
