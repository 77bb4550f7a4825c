"""The tether: a cable behind the robot that holds it back by its tail."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, WrapValidator

from pipenav.arrays import Floats, Ints, Table, ordered
from pipenav.pipes.centre_lines import CentreLines
from pipenav.robots.cable import CABLE_WEIGHT, PVC_FRICTION, capstan, drag_per_metre

_Cable = Annotated[float, Field(ge=0, le=100_000)]

STRETCH = 0.05
"""Distance that a robot rolls back until its cable is slack [m]: while it stands, friction in the pipe keeps the cable
as tight as it was."""


class TetherConfig(Table):
    """Settings of the tether."""

    length: Annotated[tuple[_Cable, _Cable], WrapValidator(ordered)] = Field(
        (0.0, 250.0),
        strict=False,
        description="length of straight, level pipe with cable behind the robot at the start [m]",
    )
    weight: float = Field(CABLE_WEIGHT, ge=0, le=100, description="weight of the cable [N/m]")
    friction: float = Field(
        PVC_FRICTION, ge=0, le=3, description="friction of the cable in the pipe; in corroded steel 0.6"
    )

    @property
    def per_metre(self) -> float:
        """Drag of a metre of cable in a straight, level pipe [N/m]."""
        return float(drag_per_metre(self.weight, self.friction))


class Tethers:
    """Cables of n robots.

    Args:
        config: weight and friction.
        n: number of robots.
    """

    def __init__(self, config: TetherConfig, n: int) -> None:
        self._config = config
        self._cable, self._start, self._furthest = np.zeros(n), np.zeros(n), np.zeros(n)

    def start(self, indices: Ints, cable: Floats, rear: Floats) -> None:
        """Begin anew with some robots.

        Args:
            indices: which robots, (k,).
            cable: length of cable behind each, (k,) [m].
            rear: distance of each rear end along the pipe, (k,) [m].
        """
        self._cable[indices], self._start[indices], self._furthest[indices] = cable, rear, rear

    def tension(self, rear: Floats, turned: Floats) -> Floats:
        """Tension of the cables at the robots' rear ends, (n,) [N].

        Args:
            rear: distance of the rear ends along the pipe, (n,) [m].
            turned: sum of the turns that the rear ends have passed, (n,) [rad].
        """
        self._furthest = np.maximum(self._furthest, rear)
        out = self._cable + self._furthest - self._start
        tight = np.clip(1.0 - (self._furthest - rear) / STRETCH, 0.0, 1.0)
        return np.asarray(self._config.per_metre * out * capstan(self._config.friction, turned) * tight)

    def forces(self, lines: CentreLines, rear_ends: Floats) -> Floats:
        """Forces on the rear ends, back along the legs that they are in, (n, dimensions) [N].

        Args:
            lines: the pipes' centre lines.
            rear_ends: points of the pipes' frames, (n, dimensions) [m].
        """
        leg = lines.locate(rear_ends[:, None]).leg[:, 0]
        rows = np.arange(len(leg))
        tension = self.tension(lines.distance(rear_ends[:, None])[:, 0], lines.turned[rows, leg])
        return np.asarray(-tension[:, None] * lines.axes[rows, leg, :, 0])
