"""A backend's own window on an episode while it runs, in real time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager

import numpy as np

from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.simulators import open_simulator
from pipenav.backends.viewer import HasWindow, Sight, Viewer
from pipenav.motions.trajectory import Trajectory
from pipenav.recording.record import RecordingSettings, Weight, live_text

Clock = Callable[[], float]
Sleep = Callable[[float], None]


class Window:
    """Shows one episode after another: an `Onlooker`. Where a window is closed, the episode goes on.

    Args:
        clock: gives the time [s].
        sleep: waits for a time [s].
    """

    def __init__(self, clock: Clock = time.monotonic, sleep: Sleep = time.sleep) -> None:
        self._clock, self._sleep = clock, sleep
        self._backend: HasWindow | None = None
        self._viewer: Viewer | None = None
        self._due, self._sight = 0.0, Sight()

    def __call__(self, backend: HasWindow, sight: Sight) -> None:
        """Show the backend's first robot, one control period after the call before."""
        self._sight = sight
        if backend is not self._backend:
            self.close()
            self._backend, self._viewer = backend, backend.open_viewer()
            self._due = self._clock()
        if self._viewer is not None and self._viewer.show(sight):
            self._due += CONTROL_PERIOD
            self._sleep(max(0.0, self._due - self._clock()))

    def wait(self) -> None:
        """Stay until the window is closed."""
        while self._viewer is not None and self._viewer.show(self._sight):
            self._sleep(CONTROL_PERIOD)

    def close(self) -> None:
        if self._viewer is not None:
            self._viewer.close()
        self._viewer = None


@contextmanager
def live_window() -> Iterator[Window]:
    """A window that stays until it is closed, or until an error or an interrupt."""
    window = Window()
    try:
        yield window
        window.wait()
    finally:
        window.close()


def play(trajectories: Sequence[Trajectory], simulator: RecordingSettings) -> None:
    """Show recorded poses one after another, without physics."""
    for one in trajectories:
        header = one.header
        weight = Weight.of(header.gravity_mps2 and (*header.gravity_mps2, 0.0))
        label = ", ".join(part for part in (header.pipe.label, weight.words) if part)
        opened = open_simulator(simulator.backend, one.robot, 1, simulator.options, len(header.pipe.segments))
        with closing(opened) as backend:
            for seconds, q in zip(one.time, one.q, strict=True):
                backend.reset(np.arange(1), [header.pipe], q[None], np.array([header.base_m]))
                if simulator.watch is not None:
                    simulator.watch(backend, Sight(live_text(label, seconds), header.goal_m, weight.down))
