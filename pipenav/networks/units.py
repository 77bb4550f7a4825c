"""Units that files of networks use, in metres."""

from __future__ import annotations

import math

from pipenav.errors import ConfigError, PipenavError, shown

INCH = 0.0254
"""Inch [m]: the international one, exact since 1959."""

FOOT = 0.3048
"""Foot [m]: twelve international inches."""

LENGTHS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": INCH, "ft": FOOT}
"""Lengths by the names of their units [m]."""

EARTH_RADIUS, FLATTENING = 6378137.0, 1 / 298.257223563
"""Equatorial radius [m] and flattening of the ellipsoid WGS 84."""


def unit_of(name: str) -> float:
    """Length of a unit by its name [m].

    Raises:
        PipenavError: an unknown unit.
    """
    if name not in LENGTHS:
        raise PipenavError(f"unit {shown(name)} is unknown: choose {', '.join(LENGTHS)}.")
    return LENGTHS[name]


def number(text: object, what: str, where: str) -> float:
    """A finite number of a file.

    Args:
        text: what stands in the file.
        what: words for the number.
        where: file and line or feature.

    Raises:
        ConfigError: it is no number, or not a finite one.
    """
    try:
        value = float(text) if isinstance(text, str | int | float) and not isinstance(text, bool) else math.nan
    except (ValueError, OverflowError):
        value = math.nan
    if not math.isfinite(value):
        raise ConfigError(f"{where}: {what} {shown(text)} is not a finite number: correct it there.")
    return value


def metres_per_degree(latitude: float) -> tuple[float, float]:
    """Lengths of a degree of longitude and of one of latitude at a latitude [deg], on WGS 84 [m].

    Source: radii of curvature in the prime vertical and in the meridian, NIMA TR8350.2, "Department of Defense World
    Geodetic System 1984".
    """
    squared = FLATTENING * (2 - FLATTENING)
    sine = math.sin(math.radians(latitude))
    root = math.sqrt(1 - squared * sine * sine)
    vertical, meridian = EARTH_RADIUS / root, EARTH_RADIUS * (1 - squared) / root**3
    return math.radians(vertical * math.cos(math.radians(latitude))), math.radians(meridian)
