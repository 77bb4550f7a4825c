"""Program of the processes of a `Crew`.

It executes the orders that arrive at its end of a pipe, and ends when the other end closes, for whatever reason.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends import Control, Variation, worker_end
from pipenav.pipes import Pipe
from pipenav.robots import RobotSpec
from pipenav_pybullet.world import WORLD_SIZE, Motion, Setting, World, shares


class Share:
    """Robots of a process, numbered from its first, in worlds of WORLD_SIZE or fewer."""

    def open(self, robot: RobotSpec, count: int, setting: Setting) -> None:
        """Make the worlds of `count` robots."""
        self._bounds = [*range(0, count, WORLD_SIZE), count]
        self._worlds = [World(robot, last - first, setting) for first, last in pairwise(self._bounds)]

    def reset(self, indices: Ints, pipes: list[Pipe], q: Floats, base: Floats) -> Floats:
        """Reset some robots as `World.reset` does."""
        distances = []
        for world, first, rows in zip(self._worlds, self._bounds, shares(indices, self._bounds), strict=False):
            if len(rows):
                mine = [pipes[row] for row in rows]
                distances.append(world.reset((indices[rows] - first).tolist(), mine, q[rows], base[rows]))
        return np.concatenate(distances)

    def vary(self, indices: Ints, variation: Variation) -> None:
        """Vary some robots as `World.vary` does."""
        for world, first, rows in zip(self._worlds, self._bounds, shares(indices, self._bounds), strict=False):
            world.vary((indices[rows] - first).tolist(), variation.part(rows))

    def pull(self, forces: Floats) -> None:
        """Let forces act on all robots as `World.pull` does."""
        for world, (first, last) in zip(self._worlds, pairwise(self._bounds), strict=True):
            world.pull(forces[first:last])

    def step(self, control: Control, values: Floats) -> Motion:
        """Advance all robots as `World.step` does."""
        parts = zip(self._worlds, pairwise(self._bounds), strict=True)
        motions = [world.step(control, values[first:last]) for world, (first, last) in parts]
        return Motion(*(np.concatenate(column) for column in zip(*motions, strict=True)))


def serve(end: Connection[Any, Any]) -> None:
    """Answer orders until the other end closes."""
    share = Share()
    while True:
        try:
            what, order = end.recv()
        except (EOFError, ConnectionError):
            return
        try:
            answer = getattr(share, what)(*order)
        except Exception as error:  # the parent raises it: here nobody would see it
            answer = error
        try:
            end.send(answer)
        except ConnectionError:
            return


def main(arguments: Sequence[str]) -> None:
    serve(worker_end(arguments))
