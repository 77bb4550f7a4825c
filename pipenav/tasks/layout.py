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
    """

    name: str
    unit: str
    scale: Floats
