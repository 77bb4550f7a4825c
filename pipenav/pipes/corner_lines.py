"""Lines along a corner that keep one lateral offset: radius of their fillet, and chords for its arc."""

from __future__ import annotations

import math

ARC_TOLERANCE = 1e-4
"""Largest distance between an arc and the chords that stand for it [m]."""

SHARP = 1e-6
"""Radius below which an arc is drawn as a corner [m]: its chords would be shorter than any tool resolves."""


def fillet_radius(offset: float, bend_radius: float) -> float:
    """Radius of the fillet that rounds the line at a lateral offset, R - clip(o, -R, R) [m]; 0 for a mitre."""
    return bend_radius - min(max(offset, -bend_radius), bend_radius)


def tangent_length(offset: float, bend_radius: float, angle: float) -> float:
    """Distance along a leg from the corner to where the line at a lateral offset starts to bend [m].

    Args:
        offset: lateral offset, positive towards the inside of the turn [m].
        bend_radius: radius of the centre line's bend [m].
        angle: interior angle of the corner [rad].
    """
    return (offset + fillet_radius(offset, bend_radius)) / math.tan(angle / 2)


def arc_chords(radius: float, turn_angle: float, tolerance: float = ARC_TOLERANCE) -> int:
    """Least number of chords that stay within a tolerance [m] of an arc; 0 for a sharp or straight one."""
    if radius < SHARP or turn_angle < 1e-9:
        return 0
    step = 2 * math.acos(1 - min(tolerance / radius, 1.0))
    return max(1, math.ceil(turn_angle / step))
