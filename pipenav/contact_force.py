"""Contact forces as every simulator reports them: means over a fixed time, whatever the physics step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FORCE_WINDOW = 0.01
"""Contact forces are means over this time, one window after the other [s].

The force of a single physics step during an impact depends on the step and on the contact's stiffness, its impulse
does not; ten milliseconds is also what a force gauge resolves.
"""


class Windows:
    """The windows of a control period of so many physics steps."""

    def __init__(self, substeps: int, timestep: float) -> None:
        self._starts = np.arange(0, substeps, max(1, round(FORCE_WINDOW / timestep)))
        self._share = (1 / np.diff(self._starts, append=substeps))[:, None]

    def means(self, records: Array) -> Array:
        """Mean over each window of values recorded in each physics step, (n, substeps, m) -> (n, windows, m)."""
        return np.asarray(np.add.reduceat(records, self._starts, axis=1) * self._share)


def strongest(forces: Array) -> Array:
    """The largest of each link's forces in the plane, (n, windows, links, 2) -> (n, links, 2) [N]."""
    peak = (forces[..., 0] ** 2 + forces[..., 1] ** 2).argmax(axis=1)  # (n, links)
    return np.asarray(np.take_along_axis(forces, peak[:, None, :, None], axis=1)[:, 0])
