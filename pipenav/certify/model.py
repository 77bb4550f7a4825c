"""Subject of a certificate: a robot, a corner, the kind of bore, and how much overlap is allowed."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.certify.corner_walls import corner_walls
from pipenav.certify.shapes import Shapes, shapes_of
from pipenav.certify.slide_interval import SeenWalls
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec
from pipenav.units import m_to_mm, rad_to_deg

ANY_ANGLE = 10.0
"""Limit of a hinge without limits [rad]: more than a whole turn to either side."""


class Model(NamedTuple):
    """Subject of a certificate.

    Attributes:
        robot: the robot.
        pipe: the corner.
        bore: `plane` or `round`.
        overlap: overlap with the wall that is allowed [m].
        freed: numbers of joints whose limits do not count, to see whether they are the reason.
    """

    robot: RobotSpec
    pipe: PipeCorner
    bore: str = "plane"
    overlap: float = 0.0
    freed: tuple[int, ...] = ()

    @property
    def turn(self) -> float:
        """Change of heading in the canonical frame [rad]."""
        return math.pi - self.pipe.angle

    def with_bore(self, diameter: float) -> Model:
        """The same in another bore [m]; the bend keeps its radius in bores."""
        pipe = self.pipe
        bend = m_to_mm(pipe.bend_radius * diameter / pipe.diameter)
        other = PipeCorner.of(m_to_mm(diameter), rad_to_deg(pipe.angle), pipe.turn, bend)
        return self._replace(pipe=other)

    def shapes(self, proof: bool, margin: float = 0.0) -> Shapes:
        """Parts of the robot in the canonical frame, for a proof smaller by the overlap, for a motion with a margin."""
        shapes = shapes_of(self.robot, self.pipe.turn_sign).eroded(self.overlap)
        return shapes if proof else shapes.inflated(margin)

    def walls(self, shapes: Shapes, proof: bool) -> SeenWalls:
        """Walls that the parts see."""
        boxes, discs = (corner_walls(self.pipe, part.height, self.bore, proof) for part in (shapes.boxes, shapes.discs))
        return SeenWalls(boxes, discs)

    @property
    def limits(self) -> tuple[Floats, Floats]:
        """Smallest and largest positions of the joints in the canonical frame, (joints,) each [rad or m]."""
        lower, upper = np.array(self.robot.lower), np.array(self.robot.upper)
        for joint in self.freed:
            more = ANY_ANGLE if self.robot.hinges[joint] else 2 * self.robot.length
            lower[joint], upper[joint] = lower[joint] - more, upper[joint] + more
        if self.pipe.turn_sign < 0:
            hinges = self.robot.hinges
            return np.where(hinges, -upper, lower), np.where(hinges, -lower, upper)
        return lower, upper
