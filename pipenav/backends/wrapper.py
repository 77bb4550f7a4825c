"""A simulator that stands before another one, and changes only what it says."""

from __future__ import annotations

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Reading, Truth
from pipenav.backends.viewer import Viewer


class WrappedSimulator(Simulator):
    """Another simulator with all that it can do, but `vary`, which a wrapper may use for itself.

    Args:
        inner: the other simulator.
    """

    def __init__(self, inner: Simulator) -> None:
        self._inner = inner

    def read(self) -> Reading:
        return self._inner.read()

    def truth(self) -> Truth:
        return self._inner.truth()

    @property
    def can_incline(self) -> bool:
        return self._inner.can_incline

    def incline(self, indices: Ints, gravity: Floats) -> None:
        self._inner.incline(indices, gravity)

    @property
    def can_pull(self) -> bool:
        return self._inner.can_pull

    def pull(self, forces: Floats) -> None:
        self._inner.pull(forces)

    @property
    def has_viewer(self) -> bool:
        return self._inner.has_viewer

    def open_viewer(self) -> Viewer:
        return self._inner.open_viewer()

    def close(self) -> None:
        self._inner.close()
