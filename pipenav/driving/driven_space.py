"""A simulator of robots in space that people and policies drive: it stands between a task and another one."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.spatial import SpaceBackend, SpaceReading, SpaceTruth
from pipenav.backends.viewer import Viewer
from pipenav.driving.door import Scene
from pipenav.driving.route_steps import corner_row
from pipenav.driving.space_door import SpaceDoor
from pipenav.pipes.route import PipeRoute
from pipenav.tasks.rolling.manoeuvre import RollCommand


class DrivenSpace(SpaceBackend):
    """n robots in space, each behind a door of its own; arguments as those of `DrivenSimulator`."""

    def __init__(self, inner: SpaceBackend, doors: Sequence[SpaceDoor], has_policy: bool, tip_gap: float) -> None:
        self._inner, self.doors, self._has_policy, self._tip_gap = inner, doors, has_policy, tip_gap
        self._routes: list[PipeRoute | None] = [None] * len(doors)
        self._begins: set[int] = set()

    def incline(self, indices: Ints, gravity: Floats) -> None:
        self._inner.incline(indices, gravity)

    def reset(self, indices: Ints, routes: Sequence[PipeRoute], q: Floats, base: Floats, plane: Floats) -> SpaceReading:
        for i, route in zip(indices, routes, strict=True):
            self._begins.add(int(i))
            self._routes[i] = route
        return self._inner.reset(indices, routes, q, base, plane)

    def pull(self, forces: Floats) -> None:
        self._inner.pull(forces)

    def step(self, set_points: Floats, roll: Floats) -> None:
        """Advance every robot by a control period, as its door has it.

        Raises:
            OperatorLost: a person's device is gone; nothing has moved in this control period.
        """
        reading = self._inner.read()
        told = []
        for i, door in enumerate(self.doors):
            row, route = _row(reading, i), self._routes[i]
            if i in self._begins:
                assert route is not None
                door.start_in_space(row, Scene(None, self._tip_gap, None, corner_row(route)), route)
            policy = partial(RollCommand, set_points[i : i + 1], roll[i : i + 1]) if self._has_policy else None
            told.append(door.next_in_space(row, policy))
        self._begins.clear()
        self._inner.step(np.concatenate([one.values for one in told]), np.concatenate([one.roll for one in told]))

    def read(self) -> SpaceReading:
        return self._inner.read()

    def truth(self) -> SpaceTruth:
        return self._inner.truth()

    def open_viewer(self) -> Viewer:
        return self._inner.open_viewer()

    def close(self) -> None:
        self._inner.close()


def _row(reading: SpaceReading, i: int) -> SpaceReading:
    """Readings of one robot, rows of one."""
    part = slice(i, i + 1)
    body = reading.body.part(np.array([i]))
    return SpaceReading(body, reading.roll[part], reading.down[part], reading.turned[part])
