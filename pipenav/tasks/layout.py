"""The named parts of an observation vector."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Part(NamedTuple):
    """One named stretch of the observation vector."""

    name: str
    unit: str
    scale: Array
