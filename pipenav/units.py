"""Conversions at the edge: inside, everything is SI and radians; millimetres and degrees are for people."""

from __future__ import annotations

import math

__all__ = ["deg_to_rad", "m_to_mm", "mm_to_m", "rad_to_deg"]


def mm_to_m(mm: float) -> float:
    return mm / 1000.0


def m_to_mm(m: float) -> float:
    return m * 1000.0


def deg_to_rad(deg: float) -> float:
    return math.radians(deg)


def rad_to_deg(rad: float) -> float:
    return math.degrees(rad)
