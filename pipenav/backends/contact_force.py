"""Contact forces as every simulator reports them: means over a fixed time, whatever the physics step."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats

FORCE_WINDOW = 0.01
"""Duration of a window; contact forces are means over windows, one after the other [s].

The force of a single physics step during an impact depends on the step and on the contact's stiffness, its impulse
does not; ten milliseconds is also what a force gauge resolves.
"""


class Windows:
    """Windows of a control period.

    Args:
        substeps: physics steps in the control period.
        timestep: physics step [s].

    Attributes:
        count: number of windows.
    """

    def __init__(self, substeps: int, timestep: float) -> None:
        window = np.arange(substeps) // max(1, round(FORCE_WINDOW / timestep))
        self.count = window[-1] + 1
        member = window == np.arange(self.count)[:, None]  # (windows, substeps)
        self._weights = member / member.sum(axis=1, keepdims=True)

    def means(self, records: Floats) -> Floats:
        """Mean over each window of the values of every physics step, (n, substeps, m) -> (n, windows, m)."""
        return np.asarray(self._weights @ records)


def strongest(forces: Floats) -> Floats:
    """Largest force on each link, in any number of axes, (n, windows, links, axes) -> (n, links, axes) [N]."""
    peak = (forces**2).sum(axis=-1).argmax(axis=1)  # (n, links)
    indices, links = np.ogrid[: peak.shape[0], : peak.shape[1]]
    return np.asarray(forces[indices, peak, links])
