"""Numbers that a corner may have, and lengths of legs that are not given."""

from __future__ import annotations

import math
from typing import cast

from pipenav.errors import OutOfRange, PipenavError, shown
from pipenav.pipes.corner_lines import tangent_length
from pipenav.pipes.pipe import Turn
from pipenav.units import m_to_mm, rad_to_deg

DIAMETER_RANGE_MM = (40.0, 300.0)
ANGLE_RANGE_DEG = (30.0, 180.0)
BEND_RADIUS_MAX_MM = 3000.0
WALL_RANGE_MM = (0.5, 50.0)
LEG_MAX_MM = 20000.0

ROLL_MAX_DEG = 360.0
"""Largest roll to either side."""

MIN_DEFAULT_LEG = 0.6
"""Shortest default leg [m]: the longest half robot (0.39 m) and its way to the corner fit in it."""


def check_corner(diameter: float, angle: float, bend_radius: float, wall: float) -> None:
    """Refuse a corner with a number outside its range.

    Args:
        diameter: inner diameter [m].
        angle: interior angle [rad].
        bend_radius: radius of the centre line's bend [m].
        wall: wall thickness [m].

    Raises:
        OutOfRange: with what was given and what is allowed.
    """
    check_range("diameter", m_to_mm(diameter), *DIAMETER_RANGE_MM, "mm")
    check_range("interior angle", rad_to_deg(angle), *ANGLE_RANGE_DEG, "deg")
    check_range("bend radius", m_to_mm(bend_radius), 0.0, BEND_RADIUS_MAX_MM, "mm")
    check_range("wall thickness", m_to_mm(wall), *WALL_RANGE_MM, "mm")


def check_turn(turn: str) -> Turn:
    """The turn of a name.

    Raises:
        PipenavError: neither left nor right.
    """
    if turn not in ("left", "right"):
        raise PipenavError(f"turn {shown(turn)} is unknown: choose 'left' or 'right'.")
    return cast(Turn, turn)


def check_range(what: str, given: float, low: float, high: float, unit: str) -> None:
    """Refuse a number outside its range, NaN too.

    Raises:
        OutOfRange: with what was given and what is allowed.
    """
    if not low - 1e-9 <= given <= high + 1e-9:  # also false for NaN
        raise OutOfRange(what, given, low, high, unit)


def shortest_leg(diameter: float, angle: float, bend_radius: float, wall: float) -> float:
    """Least length of a leg [m]: past every bend, of the outer surface too, by a tenth of the diameter.

    Args:
        diameter: inner diameter [m].
        angle: interior angle [rad].
        bend_radius: radius of the centre line's bend [m].
        wall: wall thickness [m].
    """
    outside = diameter / 2 + wall
    reach = max(tangent_length(offset, bend_radius, angle) for offset in (-outside, outside))
    return max(reach, 0.0) + 0.1 * diameter


def default_leg(shortest: float, diameter: float) -> float:
    """Length of a leg where none is given, in whole centimetres [m].

    Args:
        shortest: least length that is allowed [m].
        diameter: inner diameter [m].
    """
    return max(MIN_DEFAULT_LEG, math.ceil((shortest + diameter) * 100) / 100)
