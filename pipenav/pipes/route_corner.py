"""A corner of a route, and the direction of its inside."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pydantic import ConfigDict

from pipenav.arrays import Floats, Table
from pipenav.pipes.pipe import Turn
from pipenav.units import m_to_mm, rad_to_deg


class Corner(Table):
    """A corner of a route.

    Attributes:
        angle: interior angle between its legs [rad]; pi joins two legs in line.
        turn: side that the pipe turns to, in the corner's own plane.
        roll: angle from the plane of the corner before to the plane of this one, about the direction of travel [rad].
        bend_radius: radius of the centre line's bend [m]; 0 is a mitre.
    """

    model_config = ConfigDict(allow_inf_nan=True)  # the route checks ranges, with a sentence of its own

    angle: float
    turn: Turn = "left"
    roll: float = 0.0
    bend_radius: float = 0.0

    @property
    def name(self) -> str:
        """`R75r150roll90`: turn, interior angle [deg], bend radius [mm] and roll [deg], usable in a file name."""
        bend = f"r{m_to_mm(self.bend_radius):g}" if self.bend_radius else ""
        roll = f"roll{rad_to_deg(self.roll):g}" if self.roll else ""
        return f"{self.turn[0].upper()}{rad_to_deg(self.angle):g}{bend}{roll}"

    @property
    def label(self) -> str:
        """Description in words, for tables and messages."""
        bend = f" in {m_to_mm(self.bend_radius):g} mm" if self.bend_radius else ""
        roll = f" rolled {rad_to_deg(self.roll):g} deg" if self.roll else ""
        return f"{rad_to_deg(self.angle):g} deg {self.turn}{bend}{roll}"


def inside_angles(corners: Sequence[Corner]) -> Floats:
    """Directions of the insides of the turns, as angles from left to up of the legs without twist, (corners,) [rad]."""
    right = np.array([corner.turn == "right" for corner in corners])
    return np.cumsum([corner.roll for corner in corners]) + math.pi * right
