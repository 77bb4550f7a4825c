"""Numbers that a route may have, and the least lengths of its straights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import PipenavError
from pipenav.pipes.branch_pipes import check_fitting, reaches_of
from pipenav.pipes.corner_checks import (
    ANGLE_RANGE_DEG,
    BEND_RADIUS_MAX_MM,
    DIAMETER_RANGE_MM,
    LEG_MAX_MM,
    ROLL_MAX_DEG,
    WALL_RANGE_MM,
    check_range,
)
from pipenav.pipes.route_corner import Corner, inside_angles, leg_diameters
from pipenav.units import m_to_mm, rad_to_deg

MAX_CORNERS = 50
"""Corners of the longest route: more is a slip of the keyboard."""

LEAST_BEND = 0.75
"""Least bend radius of a corner that is no mitre [diameters]: the walls inside a tighter bend would be too thin."""

REDUCER_MAX_MM = 2000.0
"""Length of the longest reducer."""

SLOPE_RANGE_DEG = (-90.0, 90.0)
"""Angles by which the first leg can climb."""


class CrossesItself(PipenavError):
    """Two pipes of a route that are no neighbours meet."""


class StraightsMeet(CrossesItself):
    """Two straights of a route that are no neighbours meet; their numbers count from 1."""

    def __init__(self, first: int, second: int) -> None:
        super().__init__(
            f"the route crosses itself: straights {first} and {second} would touch or nearly touch; make one of the "
            f"straights {first} to {second} longer or shorter, or turn a corner between them the other way."
        )


class BranchMeets(CrossesItself):
    """A branch of a route meets another pipe, which stands in words; the corner's number counts from 1."""

    def __init__(self, corner: int, other: str) -> None:
        super().__init__(
            f"the route crosses itself: the branch at corner {corner} and {other} would touch or nearly touch; make "
            "the branch shorter, a straight between them longer, or turn a corner between them the other way."
        )


def check_corner_count(corners: int) -> None:
    """Refuse a route of no corner or of too many.

    Raises:
        PipenavError: with the number of corners and the largest one.
    """
    if not 1 <= corners <= MAX_CORNERS:
        raise PipenavError(f"a route of {corners} corners is not possible: give it 1 to {MAX_CORNERS}.")


def check_numbers(diameter: float, corners: Sequence[Corner], straights: int, wall: float) -> None:
    """Refuse a route with a number outside its range; the lengths of the straights are not looked at.

    Args:
        diameter: inner diameter before the first reducer [m].
        corners: corners in order.
        straights: number of straights.
        wall: wall thickness [m].

    Raises:
        OutOfRange: with what was given and what is allowed.
        PipenavError: the straights do not fit the corners.
    """
    check_range("diameter", m_to_mm(diameter), *DIAMETER_RANGE_MM, "mm")
    check_range("wall thickness", m_to_mm(wall), *WALL_RANGE_MM, "mm")
    for i, (corner, (before, after)) in enumerate(
        zip(corners, pairwise(leg_diameters(diameter, corners)), strict=True), 1
    ):
        check_range(f"interior angle of corner {i}", rad_to_deg(corner.angle), *ANGLE_RANGE_DEG, "deg")
        check_range(f"roll of corner {i}", rad_to_deg(corner.roll), -ROLL_MAX_DEG, ROLL_MAX_DEG, "deg")
        if corner.branches:
            check_fitting(i, corner, before, after, wall)
        elif corner.bend_radius:
            low = LEAST_BEND * m_to_mm(before)
            what = f"bend radius of corner {i} (0 is a mitre)"
            check_range(what, m_to_mm(corner.bend_radius), low, BEND_RADIUS_MAX_MM, "mm")
        kind = "reducer" if corner.reducer else "corner"
        check_range(f"diameter behind {kind} {i}", m_to_mm(after), *DIAMETER_RANGE_MM, "mm")
        if not corner.reducer:
            check_range(f"length of corner {i}, which is no reducer,", m_to_mm(corner.length), 0.0, 0.0, "mm")
        else:
            check_range(f"length of reducer {i}", m_to_mm(corner.length), 0.0, REDUCER_MAX_MM, "mm")
            check_range(f"interior angle of reducer {i}", rad_to_deg(corner.angle), 180.0, 180.0, "deg")
            check_range(f"bend radius of reducer {i}", m_to_mm(corner.bend_radius), 0.0, 0.0, "mm")
    if straights != len(corners) + 1:
        raise PipenavError(
            f"{straights} straights do not fit {len(corners)} corners: "
            "give one before each corner and one after the last."
        )


def check_straights(straights: Sequence[float], shortest: Sequence[float]) -> None:
    """Refuse a straight that is too short or too long.

    Args:
        straights: lengths of the straights [m].
        shortest: least length of each [m].

    Raises:
        OutOfRange: with what was given and what is allowed.
    """
    for i, (given, least) in enumerate(zip(straights, shortest, strict=True), 1):
        low = math.ceil(m_to_mm(least) - 1e-9)
        check_range(f"length of straight {i}", m_to_mm(given), low, LEG_MAX_MM, "mm")


def shortest_straights(diameter: float, corners: Sequence[Corner], wall: float) -> list[float]:
    """Least length of each straight, (corners + 1) [m].

    Every line of the outer surface must reach past both corners, by a tenth of the diameter. A line at `around` loses
    reach x cos(around - inside) to each mitre: that is most where the two vectors' sum points. A bend takes its tangent
    length from every line, and from the outer surface's inside no less than a mitre would.

    Args:
        diameter: inner diameter [m].
        corners: corners in order.
        wall: wall thickness [m].
    """
    diameters, inside = leg_diameters(diameter, corners), inside_angles(corners)
    outside = diameters / 2 + wall  # (legs,)
    reach = 1 / np.tan([corner.angle / 2 for corner in corners])  # (corners,)
    mitred = np.array([not corner.bend_radius and not corner.branches for corner in corners])
    by_mitres = np.where(mitred, reach, 0.0)[:, None] * np.stack([np.cos(inside), np.sin(inside)], axis=1)
    before, after = np.array(
        [_lost_to(corner, *pair, wall) for corner, pair in zip(corners, pairwise(diameters), strict=True)]
    ).T
    lost = outside * np.linalg.norm(_beside_each_leg(by_mitres, by_mitres), axis=1)
    lost += _beside_each_leg(before[:, None], after[:, None])[:, 0]
    return [float(x) for x in lost + 0.1 * diameters]


def _lost_to(corner: Corner, before: float, after: float, wall: float) -> tuple[float, float]:
    """Lengths that a corner takes from all lines of the leg before it and of the leg after it [m]; 0 for a mitre."""
    if corner.branches:
        first, second = reaches_of(corner, before, after, wall)[:2].tolist()
        return first, second
    bent = max(corner.bend_radius, before / 2 + wall) / math.tan(corner.angle / 2)
    lost = bent if corner.bend_radius else corner.length / 2
    return lost, lost


def _beside_each_leg(before: Floats, after: Floats) -> Floats:
    """Sum of the values at the corners at either end of each leg, (corners + 1, k).

    Args:
        before: values of the corners for the leg before, (corners, k).
        after: values for the leg after, (corners, k).
    """
    return np.concatenate([before[:1], after[:-1] + before[1:], after[-1:]])
