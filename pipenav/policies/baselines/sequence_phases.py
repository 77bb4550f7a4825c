"""Phases of `baseline:sequence`, and what it remembers of one robot from phase to phase."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.policies.baselines.sequence_plan import Poses

APART = 0.001
"""Least distance between poses that are kept of the front half's motion [m]."""

REAR, FRONT = 1, 4
"""Joint in the middle of either half, which presses."""


class TurnPhase(IntEnum):
    """Phase of the sequence; the letters are the thesis's (1.2)."""

    CLAMP_REAR = 0
    """The rear half clamps, the front half stretches: (a)."""
    FRONT_TO_TARGET = 1
    """The rear half drives, the arm's policy brings the tip to a target beyond the corner: (b)."""
    FRONT_ON = 2
    """The rear half drives on, the front half follows the line, until the middle link spans the corner: (b)."""
    CLAMP_FRONT = 3
    """The front half clamps too: (c)."""
    REAR_THROUGH = 4
    """The rear half unclamps, the front half drives and draws it through: (c), (d)."""
    CLAMP_REAR_AGAIN = 5
    """All wheels are past the corner: the rear half clamps and all of them drive: (e)."""


PRESSING = {
    TurnPhase.CLAMP_REAR: [REAR],
    TurnPhase.FRONT_TO_TARGET: [REAR],
    TurnPhase.FRONT_ON: [REAR],
    TurnPhase.CLAMP_FRONT: [REAR, FRONT],
    TurnPhase.REAR_THROUGH: [FRONT],
    TurnPhase.CLAMP_REAR_AGAIN: [REAR, FRONT],
}
"""Joints that press in each phase."""

CLAMPING = (TurnPhase.CLAMP_REAR, TurnPhase.CLAMP_FRONT)
"""Phases in which the wheels stand."""


class RobotState(NamedTuple):
    """Pose of one robot, as in a left turn.

    Attributes:
        bends: joint angles, (joints,) [rad].
        points: rear end, joints and tip, (links + 1, 2) [m].
        distances: distances of these points along the pipe, (links + 1,) [m].
    """

    bends: Floats
    points: Floats
    distances: Floats

    @property
    def rearmost_wheel(self) -> float:
        """Distance of the rear half's last wheel along the pipe [m]."""
        return float(self.distances[1])

    @property
    def rear_clamp(self) -> float:
        """Distance along the pipe of the rear half's wheel at the middle link [m]."""
        return float(self.distances[3])

    @property
    def front_clamp(self) -> float:
        """Distance along the pipe of the front half's wheel at the middle link [m]."""
        return float(self.distances[4])

    @property
    def tip(self) -> float:
        """Distance of the tip along the pipe [m]."""
        return float(self.distances[-1])

    @property
    def wheels(self) -> Floats:
        """Positions of the wheels, (wheels, 2) [m]."""
        return self.points[1:-1]


class Course:
    """Memory of one robot in one episode.

    Attributes:
        phase: the phase now.
        since: control steps of this phase so far.
        start: x of the front half's first joint when the policy took over [m].
        ahead: poses in which the front half goes on along the line.
    """

    def __init__(self) -> None:
        self.phase, self.since, self.start = TurnPhase.CLAMP_REAR, 0, 0.0
        self.ahead: Poses | None = None
        self._distances: list[float] = []
        self._bends: list[Floats] = []

    def begin(self, phase: TurnPhase) -> None:
        """Begin a phase."""
        self.phase, self.since = phase, 0

    def keep(self, distance: float, bends: Floats) -> None:
        """Keep a pose of the front half's motion, as in `Poses`, where it lies far enough ahead of the last one."""
        if not self._distances or distance >= self._distances[-1] + APART:
            self._distances.append(distance)
            self._bends.append(bends)

    @property
    def front_motion(self) -> Poses:
        """The front half's motion so far."""
        return Poses(np.array(self._distances), np.array(self._bends))
