"""The named parts of an observation vector."""

from __future__ import annotations

from typing import NamedTuple

from pipenav.arrays import Floats


class ObservationField(NamedTuple):
    """One named stretch of the observation vector."""

    name: str
    unit: str
    scale: Floats
