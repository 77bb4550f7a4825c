"""The plane of a robot in a route in space, as its sensors tell it, and the roll into the next corner's plane."""

from __future__ import annotations

import math

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.spatial import SpaceReading
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Turn
from pipenav.pipes.route import PipeRoute
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.rolling import senses
from pipenav.tasks.rolling.clamp import check_robot
from pipenav.tasks.rolling.manoeuvre import Roll, RollCommand, RollPhase
from pipenav.tasks.rolling.pilot import TOLERANCE
from pipenav.units import m_to_mm, rad_to_deg

ROW = np.arange(1)


class PlaneRoll:
    """Plane of one robot, and its roll.

    Gyroscopes count how far the plane turned; where the robot lies along a straight that is not too steep, its
    accelerometers put that right.

    Args:
        robot: two mirrored halves with a roll joint between them.
        route: the route, as it is drawn.

    Attributes:
        plane: angle of the robot's plane from the untwisted frame of the straight [rad].

    Raises:
        PipenavError: the robot is built otherwise.
    """

    def __init__(self, robot: RobotSpec, route: PipeRoute) -> None:
        check_robot(robot)
        self._robot, self._route, self._legs = robot, route, route.legs
        self.plane = float(route.corners[0].roll)
        self._roll = Roll(robot, 1)

    @property
    def done(self) -> bool:
        """Whether no roll goes on."""
        return bool(self._roll.phase[0] == RollPhase.DONE)

    def see(self, reading: SpaceReading) -> None:
        """Take in the readings after a control period, whoever drove in it; rows of one."""
        self.plane += float(reading.turned[0, :, 0].mean())

    def lies(self, reading: SpaceReading, corner: int) -> None:
        """Put the plane right where a robot lies along the straight before a corner, by what it feels of its weight."""
        told = senses.plane_angle(self._robot, reading.body.q, reading.down, self._legs.axes[corner][None])[0]
        if not np.isnan(told):
            self.plane = float(told)

    def turn_sign(self, corner: int) -> float:
        """+1 where a corner turns to the robot's left as it lies, -1 where it turns to its right."""
        return 1.0 if math.cos(self._legs.inside[corner] - self.plane) > 0 else -1.0

    def away(self, corner: int) -> float:
        """Angle by which the plane is to be turned into that of a corner, in [-pi/2, pi/2] [rad]."""
        return math.remainder(float(self._legs.inside[corner]) - self.plane, math.pi)

    def fits(self, corner: int) -> bool:
        """Whether the robot lies in a corner's plane."""
        return abs(self.away(corner)) <= TOLERANCE

    def begin(self, reading: SpaceReading, corner: int) -> None:
        """Begin to turn the plane into that of a corner; an unfinished turn to it goes on."""
        if not self.done:
            return
        self.lies(reading, corner)
        radius, away = self._legs.radius[corner], self.away(corner)
        self._roll.begin(ROW, np.array([radius]), np.array([away]), reading.body.q, reading.down)

    def goal(self, reading: SpaceReading) -> RollCommand:
        """Set-points of the roll that goes on, rows of one."""
        assert reading.body.wheel_speeds is not None
        return self._roll.act(ROW, reading.body.q, reading.roll, reading.body.wheel_speeds, reading.down)

    def projected(self, points: Floats, corner: int) -> Floats:
        """Points of the route's frame, (m, 3), in the robot's plane, (m, 2) [m]: x along the straight before a corner,
        from where the axes of its legs meet, y to the left of the robot."""
        along, left, up = self._legs.axes[corner].T
        away = points - self._legs.start[corner + 1]
        return np.stack([away @ along, away @ (math.cos(self.plane) * left + math.sin(self.plane) * up)], axis=1)

    def down(self, corner: int) -> Floats:
        """Direction downwards in the straight before a corner, as the drawing has it: along the straight, to the
        robot's left and square to its plane, (3,)."""
        along, left, up = self._legs.axes[corner].T
        cos, sin = math.cos(self.plane), math.sin(self.plane)
        return np.stack([along, cos * left + sin * up, cos * up - sin * left]) @ np.asarray(self._route.down)

    def walls(self, corner: int) -> Floats:
        """Walls of a corner in the robot's plane, (k, 2, 2) [m]; where it lies in another, those of the straight."""
        given, diameter = self._route.corners[corner], m_to_mm(2 * float(self._legs.radius[corner]))
        turn: Turn = "left" if self.turn_sign(corner) > 0 else "right"
        pipe = PipeCorner.of(diameter, rad_to_deg(given.angle), turn, m_to_mm(given.bend_radius))
        if self.fits(corner):
            return pipe.segments
        x = np.array([-pipe.leg, pipe.leg])
        return np.array([np.stack([x, np.full(2, side * pipe.radius)], axis=1) for side in (1.0, -1.0)])


WAYS = ("→ ahead", "↗ ahead left", "↑ left", "↖ back left", "← back", "↙ back right", "↓ right", "↘ ahead right")
"""Eighths of a turn from a robot's heading to its left, with arrows as in a picture of its plane."""

ACROSS = math.radians(60.0)
"""Least angle between down and the picture's plane at which down points through the picture."""


def down_words(down: Floats) -> str:
    """Words for a direction downwards in a picture of the robot's plane.

    Args:
        down: unit vector downwards: along the straight, to the robot's left, and to the viewer, (3,).
    """
    along, left, to_viewer = down
    if abs(to_viewer) > math.sin(ACROSS):
        return "down points out of the picture" if to_viewer > 0 else "down points into the picture"
    return f"down {WAYS[round(math.atan2(left, along) / (math.pi / 4)) % len(WAYS)]}"
