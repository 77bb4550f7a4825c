"""A corner of a route, which can be a reducer, a tee or a cross, and the direction of its inside."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pydantic import ConfigDict

from pipenav.arrays import Floats, Table
from pipenav.pipes.branch import IN_LINE, Branch
from pipenav.pipes.corner_checks import check_turn
from pipenav.pipes.pipe import Turn
from pipenav.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg


class Corner(Table):
    """A corner of a route: a mitre, a bend, a reducer, which goes straight on to another diameter, a tee or a cross.

    Attributes:
        angle: interior angle between its legs [rad]; pi joins two legs in line.
        turn: side that the pipe turns to, in the corner's own plane.
        roll: angle from the plane of the corner before to the plane of this one, about the direction of travel [rad].
        bend_radius: radius of the centre line's bend [m]; 0 is a mitre.
        to_diameter: inner diameter behind a reducer, or behind a tee or cross if it changes [m]; None where it stays.
        length: length of a reducer along the centre line, half of it to either side [m]; 0 is a step.
        branches: the pipes of a tee or a cross that the route does not take; it can go straight on there.
    """

    model_config = ConfigDict(allow_inf_nan=True)  # the route checks ranges, with a sentence of its own

    angle: float
    turn: Turn = "left"
    roll: float = 0.0
    bend_radius: float = 0.0
    to_diameter: float | None = None
    length: float = 0.0
    branches: tuple[Branch, ...] = ()

    @property
    def mitre(self) -> bool:
        """Whether it is neither a bend nor a reducer, tee or cross."""
        return not self.bend_radius and self.to_diameter is None and not self.branches

    @property
    def reducer(self) -> bool:
        """Whether it goes straight on to another diameter."""
        return self.to_diameter is not None and not self.branches

    @property
    def straight_on(self) -> bool:
        """Whether the next leg is in line with the one before."""
        return math.pi - self.angle < IN_LINE

    @property
    def name(self) -> str:
        """`R75r150roll90`, `D90` or `L90tSd100`: turn and interior angle [deg], bend radius [mm], roll [deg]; diameter.

        It is usable in a file name. Branches follow, each from its t, with their diameters [mm].
        """
        to_diameter = "" if self.to_diameter is None else f"D{m_to_mm(self.to_diameter):g}"
        if self.reducer:
            return to_diameter + (f"l{m_to_mm(self.length):g}" if self.length else "")
        bend = f"r{m_to_mm(self.bend_radius):g}" if self.bend_radius else ""
        roll = f"roll{rad_to_deg(self.roll):g}" if self.roll else ""
        branches = "".join(branch.name for branch in self.branches)
        return f"{self.turn[0].upper()}{rad_to_deg(self.angle):g}{bend}{roll}{to_diameter}{branches}"

    @property
    def label(self) -> str:
        """Description in words, for tables and messages."""
        if self.reducer and self.to_diameter is not None:
            return f"to {m_to_mm(self.to_diameter):g} mm over {m_to_mm(self.length):g} mm"
        bend = f" in {m_to_mm(self.bend_radius):g} mm" if self.bend_radius else ""
        roll = f" rolled {rad_to_deg(self.roll):g} deg" if self.roll else ""
        to = f" to {m_to_mm(self.to_diameter):g} mm" if self.to_diameter is not None else ""
        past = "".join(f" past {branch.label}" for branch in self.branches)
        turn = "straight on" if self.branches and self.straight_on else f"{rad_to_deg(self.angle):g} deg {self.turn}"
        return f"{turn}{bend}{roll}{to}{past}"


def corner_of(angle_deg: float, turn: str, roll_deg: float = 0.0, bend_radius_mm: float = 0.0) -> Corner:
    """A mitre or a bend from the numbers that people use.

    Raises:
        PipenavError: an unknown turn.
    """
    angle, roll, bend_radius = deg_to_rad(angle_deg), deg_to_rad(roll_deg), mm_to_m(bend_radius_mm)
    return Corner(angle=angle, turn=check_turn(turn), roll=roll, bend_radius=bend_radius)


def reducer_corner(to_diameter_mm: float, length_mm: float) -> Corner:
    """A reducer to another diameter over a length."""
    return Corner(angle=math.pi, to_diameter=mm_to_m(to_diameter_mm), length=mm_to_m(length_mm))


def leg_diameters(first: float, corners: Sequence[Corner]) -> Floats:
    """Inner diameters of the legs, of which the first is given, (corners + 1,) [m]."""
    diameters = [first]
    for corner in corners:
        diameters.append(diameters[-1] if corner.to_diameter is None else corner.to_diameter)
    return np.array(diameters)


def inside_angles(corners: Sequence[Corner]) -> Floats:
    """Directions of the insides of the turns, as angles from left to up of the legs without twist, (corners,) [rad]."""
    right = np.array([corner.turn == "right" for corner in corners])
    return np.cumsum([corner.roll for corner in corners]) + math.pi * right
