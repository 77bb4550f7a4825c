"""Branches of a tee or a cross: the pipes that join at a corner and that the robot's route does not take."""

from __future__ import annotations

import math

from pydantic import ConfigDict

from pipenav.arrays import Table
from pipenav.pipes.pipe import Turn
from pipenav.units import m_to_mm, rad_to_deg

IN_LINE = 1e-6
"""Largest angle between two pipes that count as one straight run [rad]: rounding of angles."""

MAX_BRANCHES = 2
"""Branches of a cross; a tee has one."""


class Branch(Table):
    """A straight pipe that leaves a corner, in which the route does not go on.

    Attributes:
        angle: interior angle between it and the leg by which the robot comes [rad]; pi is straight on.
        turn: side on which it leaves, in its own plane.
        roll: angle from the plane of the corner before to its plane, as the roll of a `Corner` [rad].
        diameter: inner diameter [m].
        length: length along its centre line, from the crossing of the axes to its end [m].
        closed: whether a cap closes its end.
    """

    model_config = ConfigDict(allow_inf_nan=True)  # the route checks ranges, with a sentence of its own

    angle: float
    turn: Turn = "left"
    roll: float = 0.0
    diameter: float
    length: float
    closed: bool = False

    @property
    def mirrored(self) -> Branch:
        """Its mirror image about the plane across the x-y plane that the leg before lies in."""
        return self.model_copy(update={"turn": "right" if self.turn == "left" else "left", "roll": -self.roll})

    @property
    def name(self) -> str:
        """`tR90d80roll45c`: turn, interior angle [deg], diameter [mm], roll [deg], and c where it is closed."""
        roll = f"roll{rad_to_deg(self.roll):g}" if self.roll else ""
        side = "S" if math.pi - self.angle < IN_LINE else self.turn[0].upper()
        angle = "" if side == "S" else f"{rad_to_deg(self.angle):g}"
        return f"t{side}{angle}d{m_to_mm(self.diameter):g}{roll}{'c' if self.closed else ''}"

    @property
    def course(self) -> str:
        """Its direction in words."""
        side = "straight on" if math.pi - self.angle < IN_LINE else f"{rad_to_deg(self.angle):g} deg {self.turn}"
        return side + (f" rolled {rad_to_deg(self.roll):g} deg" if self.roll else "")

    @property
    def label(self) -> str:
        """Description in words, for tables and messages."""
        return f"a {'capped ' if self.closed else ''}branch of {m_to_mm(self.diameter):g} mm {self.course}"
