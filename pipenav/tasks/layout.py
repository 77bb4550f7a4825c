"""The named parts of an observation vector."""

from __future__ import annotations

from typing import NamedTuple

from pipenav.arrays import Floats


class ObservationField(NamedTuple):
    """A named part of the observation vector.

    Attributes:
        name: name of the part in policy files.
        unit: unit of its values before scaling.
        scale: number that each value is divided by, (size,).
        bound: largest size of a scaled value, generous: no reading of a sound simulation reaches it.
    """

    name: str
    unit: str
    scale: Floats
    bound: float = 1.0


BEYOND_STOP = 2.0
"""Bound of joint positions, in ranges of the joint: a stop gives way a little."""

IMPACT = 1000.0
"""Bound of speeds, in no-load speeds of the motor: an impact turns a joint faster than its motor can."""
