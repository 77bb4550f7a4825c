"""A run of pipe: several mitred corners in a row, with straights between them, in one plane or in space.

Frame: as of `PipeCorner`. The first corner is the origin, the first leg lies along -x, the robot comes from -x moving towards
+x, a left turn of the first corner goes towards +y, z points up. Every corner bends in a plane of its own, which is the
plane of the corner before, turned by `roll` about the direction of travel by the right-hand rule: from the left
upwards, clockwise for the robot that looks ahead. The first corner's plane is turned from the x-y plane. A roll of
180 deg makes a left turn a right one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, Self, cast

import numpy as np
from pydantic import Field, model_validator

from pipenav.arrays import Flags, Floats, Ints, Table
from pipenav.errors import PipenavError
from pipenav.pipes.centre_lines import CentreLines
from pipenav.pipes.corner import (
    ANGLE_RANGE_DEG,
    DIAMETER_RANGE_MM,
    LEG_MAX_MM,
    WALL_RANGE_MM,
    PipeCorner,
    Turn,
    check_range,
    check_turn,
    default_leg,
)
from pipenav.pipes.pipe import DEFAULT_WALL, LegFrames, Pipe, WallSide
from pipenav.pipes.route_legs import Legs, about_x, frozen, make_legs
from pipenav.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

MAX_CORNERS = 50
"""Corners of the longest run: more is a slip of the keyboard."""

ROLL_MAX_DEG = 360.0
"""Largest roll to either side."""

FLAT = 1e-9
"""A plane that is turned from the x-y plane by less than this [rad] is the x-y plane: rounding of angles."""


class CrossesItself(PipenavError):
    """Two straights of a run that are no neighbours meet."""

    def __init__(self, first: int, second: int) -> None:
        super().__init__(
            f"the run crosses itself: straights {first} and {second} would meet or nearly so; make one of the "
            f"straights {first} to {second} longer or shorter, or turn a corner between them the other way."
        )


class Corner(Table):
    """One corner of a run.

    Attributes:
        angle: interior angle between its legs [rad]; pi joins two legs in line.
        turn: the side that the pipe turns to, in the corner's own plane.
        roll: how far its plane is turned from the plane of the corner before, about the direction of travel [rad].
    """

    angle: float
    turn: Turn = "left"
    roll: float = 0.0


class Frames(NamedTuple):
    """One frame per leg: x along the leg, y to the left and z up in the plane of the corner before it.

    Attributes:
        origin: where the leg begins on the centre line, (legs, 3) [m]: the open end, then every corner.
        rotation: the frames' axes as columns, (legs, 3, 3).
    """

    origin: Floats
    rotation: Floats


class Sides(NamedTuple):
    """The two walls of a planar run as polylines, points in order along the run [m], each (corners + 2, 2)."""

    left: Floats
    right: Floats


class PipeRoute(Pipe):
    """Corners in a row. All lengths in metres, angles in radians; `PipeRoute.of` takes millimetres and degrees.

    Attributes:
        diameter: inner diameter [m].
        corners: the corners, in the order in which the robot comes to them.
        straights: length of every leg along its centre line, from open end or corner to corner or open end
            (corners + 1) [m].
        wall: wall thickness [m].

    Two runs are equal where their numbers are: a left turn and a right one rolled by pi differ.
    """

    corners: tuple[Corner, ...] = Field(min_length=1, max_length=MAX_CORNERS)
    straights: tuple[float, ...]

    @classmethod
    def of(
        cls,
        diameter_mm: float,
        corners: Sequence[tuple[float, str, float]],
        straights_mm: Sequence[float | None] | None = None,
        wall_mm: float | None = None,
    ) -> Self:
        """A run from the numbers that people use.

        Args:
            diameter_mm: inner diameter.
            corners: interior angle [deg], turn and roll [deg] of each.
            straights_mm: length of every leg; None for one that is as long as the corners and a robot need.
            wall_mm: wall thickness.

        Raises:
            OutOfRange: a number outside its allowed range; for a straight that range begins past its mitres.
            CrossesItself: legs that are no neighbours would meet, or nearly so.
            PipenavError: an unknown turn, a wrong number of corners or straights.
        """
        if not 1 <= len(corners) <= MAX_CORNERS:
            raise PipenavError(f"a run of {len(corners)} corners is not possible: give it 1 to {MAX_CORNERS}.")
        wall = DEFAULT_WALL if wall_mm is None else mm_to_m(wall_mm)
        made = tuple(Corner(angle=deg_to_rad(a), turn=check_turn(t), roll=deg_to_rad(r)) for a, t, r in corners)
        given = [None] * (len(made) + 1) if straights_mm is None else straights_mm
        diameter = mm_to_m(diameter_mm)
        _check_numbers(diameter, made, len(given), wall)  # before the straights, whose defaults follow from these
        straights = tuple(
            default_leg(shortest, diameter) if mm is None else mm_to_m(mm)
            for mm, shortest in zip(given, _shortest_straights(diameter, made, wall), strict=True)
        )
        return cls(diameter=diameter, corners=made, straights=straights, wall=wall)

    @classmethod
    def from_corner(cls, pipe: PipeCorner) -> Self:
        """A corner as a run of one.

        Raises:
            PipenavError: the corner is a bend.
        """
        if pipe.bend_radius:
            raise PipenavError(f"pipe {pipe.name} has a bend radius: the corners of a run are mitres.")
        corner = Corner(angle=pipe.angle, turn=pipe.turn)
        return cls(diameter=pipe.diameter, corners=(corner,), straights=(pipe.leg, pipe.leg), wall=pipe.wall)

    @model_validator(mode="after")
    def _possible(self) -> Self:
        _check_numbers(self.diameter, self.corners, len(self.straights), self.wall)
        shortest = _shortest_straights(self.diameter, self.corners, self.wall)
        for i, (given, least) in enumerate(zip(self.straights, shortest, strict=True), 1):
            low = math.ceil(m_to_mm(least) - 1e-9)
            check_range(f"length of straight {i}", m_to_mm(given), low, LEG_MAX_MM, "mm")
        met = self.legs.meeting(self.radius + self.wall)
        if met:
            raise CrossesItself(met[0] + 1, met[1] + 1)
        return self

    def __hash__(self) -> int:
        """Over the fields, as `PipeCorner`: runs are keys of what is worked out once for each."""
        corners = tuple((corner.angle, corner.turn, corner.roll) for corner in self.corners)
        return hash((self.diameter, corners, self.straights, self.wall))

    @property
    def planar(self) -> bool:
        """Whether all of it lies in the x-y plane: every roll is 0 or 180 deg, to either side, whole turns apart."""
        return all(abs(math.remainder(corner.roll, math.pi)) < FLAT for corner in self.corners)

    @property
    def name(self) -> str:
        """`run-d100-L90-R75roll90`: diameter [mm], then turn, interior angle and roll [deg] of every corner."""
        return "-".join([f"run-d{m_to_mm(self.diameter):g}", *map(_corner_name, self.corners)])

    @property
    def label(self) -> str:
        """The run in words, for tables and messages."""
        return ", ".join([f"{m_to_mm(self.diameter):g} mm", *map(_corner_words, self.corners)])

    @property
    def legs(self) -> Legs:
        """The legs without twist; the arrays are read-only."""
        return _legs(self)

    @property
    def frames(self) -> Frames:
        """A frame per leg, turned with the corners' planes; the arrays are read-only."""
        return _frames(self)

    @property
    def distances(self) -> Floats:
        """Where along the centre line open ends and corners are, (corners + 2,) [m]; 0 is the first corner."""
        return np.concatenate([[-self.straights[0], 0.0], np.cumsum(self.straights[1:])])

    @property
    def centre_line(self) -> Floats:
        """The open ends and between them the corners, (corners + 2, 3) [m]; z is 0 in a planar run."""
        return np.asarray(self.legs.lines(0.0, np.zeros(1))[0])

    @property
    def walls(self) -> Sides:
        """The walls of a planar run, left and right; the arrays are read-only.

        Raises:
            PipenavError: the run leaves the plane.
        """
        return _walls(self)

    @property
    def segments(self) -> Floats:
        """Wall segments `[[x1, y1], [x2, y2]]` of a planar run, free space on the left of each, read-only.

        The right wall along the run, then the left wall back: (2 corners + 2, 2, 2) [m].

        Raises:
            PipenavError: the run leaves the plane.
        """
        return _segments(self)

    @property
    def edges(self) -> Flags:
        """Which ends of the segments lie at an inner edge, (s, 2); an open end counts as its segment's other end."""
        to_left = np.cos(self.legs.inside) * self.legs.reach  # of a planar run; positive where it turns to the left
        inner = np.stack([to_left < -FLAT, to_left > FLAT])  # (2, corners): at the right wall, at the left wall
        inner = np.concatenate([inner[:, :1], inner, inner[:, -1:]], axis=1)
        right, left = np.stack([inner[:, :-1], inner[:, 1:]], axis=2)  # (legs, 2) each
        return np.concatenate([right, left[::-1, ::-1]])

    @property
    def interior_angles(self) -> Floats:
        return np.array([corner.angle for corner in self.corners])

    @property
    def turn_signs(self) -> Floats:
        return np.where(np.cos(self.legs.inside) > 0, 1.0, -1.0)

    @property
    def inner_edges(self) -> Floats:
        return self.radius * self.legs.reach

    @property
    def leg_frames(self) -> LegFrames:
        return LegFrames(self.legs.start, self.legs.axes, self.legs.length)

    @property
    def wall_sides(self) -> list[WallSide]:
        backs = self.legs.lines(self.radius + self.wall, np.array([0.0, math.pi]))[..., :2]
        return [WallSide(*sides) for sides in zip(self.walls, backs, strict=True)]

    @property
    def corner(self) -> None:
        return None

    @property
    def route(self) -> Self:
        return self

    def with_ends(self, first: float, last: float) -> Self:
        straights = (max(self.straights[0], first), *self.straights[1:-1], max(self.straights[-1], last))
        return self if straights == self.straights else cast(Self, _with_straights(self, straights))

    def to_leg(self, points: Floats, leg: Ints) -> Floats:
        """Points (..., 3), or (..., 2) of the x-y plane, in the frames of the legs (...): (..., 3) [m]."""
        origin, rotation = self.frames
        from_start = in_space(points) - origin[leg]
        return np.asarray((from_start[..., None, :] @ rotation[leg])[..., 0, :])

    def contains(self, points: Floats) -> Flags:
        """Whether points (..., 3), or (..., 2) of the x-y plane, are in the round bore, not past an open end: (...)."""
        points = in_space(points)
        _, local, beyond = CentreLines.of([self], 3).locate(points.reshape(1, -1, 3))
        inside = (beyond == 0) & (np.hypot(local[..., 1], local[..., 2]) <= self.radius)
        return np.asarray(inside.reshape(points.shape[:-1]))


# Kept beside the runs and not in them, as for pipes.
@lru_cache(maxsize=4096)
def _legs(route: PipeRoute) -> Legs:
    angles = np.array([corner.angle for corner in route.corners])
    return make_legs(angles, _inside(route.corners), np.array(route.straights))


@lru_cache(maxsize=1024)
def _with_straights(route: PipeRoute, straights: tuple[float, ...]) -> PipeRoute:
    """Made once each: that a route does not cross itself takes long to find out."""
    return PipeRoute(diameter=route.diameter, corners=route.corners, straights=straights, wall=route.wall)


@lru_cache(maxsize=4096)
def _frames(route: PipeRoute) -> Frames:
    rolls = np.cumsum([0.0, *(corner.roll for corner in route.corners)])
    return Frames(route.legs.start, frozen(route.legs.axes @ np.stack([about_x(roll) for roll in rolls])))


@lru_cache(maxsize=4096)
def _walls(route: PipeRoute) -> Sides:
    if not route.planar:
        raise PipenavError(
            f"{route.name} leaves the plane, so it has no walls in the plane: choose a run without rolls."
        )
    left, right = route.legs.lines(route.radius, np.array([0.0, math.pi]))[..., :2]
    return Sides(frozen(left), frozen(right))


@lru_cache(maxsize=4096)
def _segments(route: PipeRoute) -> Floats:
    walls = [route.walls.right, route.walls.left[::-1]]
    return frozen(np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in walls]))


def in_space(points: Floats) -> Floats:
    """Points (..., 2) of the x-y plane as points (..., 3)."""
    points = np.asarray(points, float)
    if points.shape[-1] == 3:
        return points
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)


def _inside(corners: Sequence[Corner]) -> Floats:
    """Where the inside of each turn is, as an angle from left to up of the legs without twist, (corners,) [rad]."""
    right = np.array([corner.turn == "right" for corner in corners])
    return np.cumsum([corner.roll for corner in corners]) + math.pi * right


def _shortest_straights(diameter: float, corners: Sequence[Corner], wall: float) -> list[float]:
    """Every line of the outer surface must reach past both mitres, by a tenth of the diameter (corners + 1) [m].

    A line at `around` loses reach x cos(around - inside) to each: that is most where the two vectors' sum points.
    """
    inside = _inside(corners)
    reach = 1 / np.tan([[corner.angle / 2] for corner in corners])  # (corners, 1)
    lost = reach * np.stack([np.cos(inside), np.sin(inside)], axis=1)  # (corners, 2)
    lost = np.concatenate([lost[:1], lost[:-1] + lost[1:], lost[-1:]])
    return [float(x) for x in (diameter / 2 + wall) * np.linalg.norm(lost, axis=1) + 0.1 * diameter]


def _check_numbers(diameter: float, corners: Sequence[Corner], straights: int, wall: float) -> None:
    check_range("diameter", m_to_mm(diameter), *DIAMETER_RANGE_MM, "mm")
    check_range("wall thickness", m_to_mm(wall), *WALL_RANGE_MM, "mm")
    for i, corner in enumerate(corners, 1):
        check_range(f"interior angle of corner {i}", rad_to_deg(corner.angle), *ANGLE_RANGE_DEG, "deg")
        check_range(f"roll of corner {i}", rad_to_deg(corner.roll), -ROLL_MAX_DEG, ROLL_MAX_DEG, "deg")
    if straights != len(corners) + 1:
        raise PipenavError(
            f"{straights} straights do not fit {len(corners)} corners: "
            "give one before each corner and one after the last."
        )


def _corner_name(corner: Corner) -> str:
    roll = f"roll{rad_to_deg(corner.roll):g}" if corner.roll else ""
    return f"{corner.turn[0].upper()}{rad_to_deg(corner.angle):g}{roll}"


def _corner_words(corner: Corner) -> str:
    roll = f" rolled {rad_to_deg(corner.roll):g} deg" if corner.roll else ""
    return f"{rad_to_deg(corner.angle):g} deg {corner.turn}{roll}"
