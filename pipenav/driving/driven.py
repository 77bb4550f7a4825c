"""A simulator whose robots are driven by people and policies: it stands between a task and another simulator."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Command, Reading
from pipenav.backends.wrapper import WrappedSimulator
from pipenav.driving.door import Door, Scene
from pipenav.driving.route_steps import corner_row
from pipenav.pipes.pipe import Pipe


class DrivenSimulator(WrappedSimulator):
    """n robots of another simulator, each behind a door of its own.

    Args:
        inner: the simulator.
        doors: the doors, n of them.
        has_policy: whether the commands that come are a policy's; where not, they are ignored.
        tip_gap: distance of the tips before the inner walls' bends at the start, about [m].
    """

    def __init__(self, inner: Simulator, doors: Sequence[Door], has_policy: bool, tip_gap: float) -> None:
        super().__init__(inner)
        self.doors, self._has_policy, self._tip_gap = doors, has_policy, tip_gap
        self.target: Callable[[int], Floats | None] = lambda _: None
        """Target of a robot in its own frame, by the robot's index; a task that has targets sets it."""
        self._begins: set[int] = set()
        self.bases = np.zeros(len(doors))
        """Origins of the robots' frames, x in their pipes' frames, (n,) [m]: for pictures."""
        self._pipes: list[Pipe | None] = [None] * len(doors)

    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:
        for i, pipe in zip(indices, pipes, strict=True):
            self._begins.add(int(i))
            self._pipes[i] = pipe
        self.bases[indices] = base
        return self._inner.reset(indices, pipes, q, base)

    def step(self, command: Command) -> None:
        """Advance every robot by a control period, as its door has it.

        Raises:
            OperatorLost: a person's device is gone; nothing has moved in this control period.
        """
        reading = self._inner.read()
        values = np.empty((len(self.doors), command.values.shape[1]))
        for i, door in enumerate(self.doors):
            row = reading.part(np.array([i]))
            if i in self._begins:
                pipe = self._pipes[i]
                corner = None if pipe is None else pipe.corner
                door.start(row, Scene(corner, self._tip_gap, self.target(i), corner_row(pipe)))
            values[i] = door.next(row, partial(np.copy, command.values[i]) if self._has_policy else None)
        self._begins.clear()
        self._inner.step(Command("position", values))
