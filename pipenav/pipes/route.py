"""A route: several corners in a row, mitres, bends and reducers, with straights between, in one plane or in space.

Frame: as of `Pipe`. Every corner bends in a plane of its own, which is the plane of the corner before, turned by `roll`
about the direction of travel by the right-hand rule: from the left upwards, clockwise for the robot that looks ahead.
The first corner's plane is turned from the x-y plane. A roll of 180 deg makes a left turn a right one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Self, cast

import numpy as np
from pydantic import Field, model_validator

from pipenav.arrays import Flags, Floats, Ints
from pipenav.errors import PipenavError
from pipenav.pipes import route_checks
from pipenav.pipes.branch_pipes import BranchPipes, make_branches, meeting_branch, way_past
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_checks import check_range, default_leg
from pipenav.pipes.pipe import DEFAULT_WALL, LegFrames, Pipe, WallSide
from pipenav.pipes.rotations import about_x, in_space
from pipenav.pipes.route_corner import Corner, corner_of, leg_diameters
from pipenav.pipes.route_ends import PLAIN_ENDS, RouteEnds
from pipenav.pipes.route_legs import Frames, Legs, frozen, make_legs
from pipenav.pipes.route_walls import PlanarWalls, branched_walls, plain_walls
from pipenav.units import m_to_mm, mm_to_m, rad_to_deg

FLAT = 1e-9
"""Angle below which a plane counts as the x-y plane [rad]: rounding of angles."""


class PipeRoute(Pipe):
    """A row of corners. All lengths in metres, angles in radians; `PipeRoute.of` takes millimetres and degrees.

    Two routes are equal where their numbers are: a left turn and a right one rolled by pi differ.

    Attributes:
        diameter: inner diameter of all legs, or of those up to the first reducer [m].
        corners: corners, in the order in which the robot comes to them.
        straights: length of every leg along its centre line, from open end or corner to corner or open end
            (corners + 1) [m].
        wall: wall thickness [m].
        capped: whether a cap closes the far end.
        slope: angle by which the first leg climbs, where the route lies in space [rad]; its left stays level.
    """

    corners: tuple[Corner, ...] = Field(min_length=1, max_length=route_checks.MAX_CORNERS)
    straights: tuple[float, ...]
    capped: bool = False
    slope: float = 0.0

    @classmethod
    def of(
        cls,
        diameter_mm: float,
        corners: Sequence[tuple[float, str, float] | tuple[float, str, float, float]],
        straights_mm: Sequence[float | None] | None = None,
        wall_mm: float | None = None,
    ) -> Self:
        """A route from the numbers that people use.

        Args:
            diameter_mm: inner diameter.
            corners: interior angle [deg], turn, roll [deg] and, for a bend, radius of the centre line [mm] of each.
            straights_mm: length of every leg; None for a leg that is as long as the corners and a robot need.
            wall_mm: wall thickness.

        Raises:
            OutOfRange: a number outside its allowed range; for a straight that range begins past its mitres.
            CrossesItself: legs that are no neighbours would meet, or nearly so.
            PipenavError: an unknown turn, a wrong number of corners or straights.
        """
        route_checks.check_corner_count(len(corners))
        made = tuple(corner_of(*corner) for corner in corners)
        given = [None] * (len(made) + 1) if straights_mm is None else straights_mm
        wall = DEFAULT_WALL if wall_mm is None else mm_to_m(wall_mm)
        return cls.with_default_straights(mm_to_m(diameter_mm), made, given, wall)

    @classmethod
    def with_default_straights(
        cls,
        diameter: float,
        corners: tuple[Corner, ...],
        straights_mm: Sequence[float | None],
        wall: float,
        ends: RouteEnds = PLAIN_ENDS,
    ) -> Self:
        """A route some of whose straights are not given: these are as long as the corners and a robot need.

        Args:
            diameter: inner diameter at the first open end [m].
            corners: corners in order.
            straights_mm: length of every leg, or None.
            wall: wall thickness [m].
            ends: the slope of its beginning, and whether it ends in a cap.

        Raises:
            PipenavError: as `of`.
        """
        route_checks.check_numbers(
            diameter, corners, len(straights_mm), wall
        )  # before the straights, whose defaults follow
        least = route_checks.shortest_straights(diameter, corners, wall)
        diameters = leg_diameters(diameter, corners).tolist()
        straights = tuple(
            default_leg(shortest, own) if mm is None else mm_to_m(mm)
            for mm, shortest, own in zip(straights_mm, least, diameters, strict=True)
        )
        return cls(diameter=diameter, corners=corners, straights=straights, wall=wall, **ends._asdict())

    @classmethod
    def from_corner(cls, pipe: PipeCorner) -> Self:
        """A single corner as a route.

        Raises:
            OutOfRange: the corner is a bend of less than 0.75 diameters.
        """
        corner = Corner(angle=pipe.angle, turn=pipe.turn, bend_radius=pipe.bend_radius, branches=pipe.branches)
        return cls(diameter=pipe.diameter, corners=(corner,), straights=(pipe.leg, pipe.leg), wall=pipe.wall)

    @model_validator(mode="after")
    def _possible(self) -> Self:
        route_checks.check_numbers(self.diameter, self.corners, len(self.straights), self.wall)
        check_range("slope", rad_to_deg(self.slope), *route_checks.SLOPE_RANGE_DEG, "deg")
        least = route_checks.shortest_straights(self.diameter, self.corners, self.wall)
        route_checks.check_straights(self.straights, least)
        outside = self.legs.radius + self.wall
        if met := self.legs.meeting(outside):
            raise route_checks.StraightsMeet(met.first + 1, met.second + 1)
        if branch := meeting_branch(self.branches, self.legs.rods(outside), self.wall):
            raise route_checks.BranchMeets(branch.corner + 1, branch.other)
        return self

    def __hash__(self) -> int:
        """Hash over all fields, faster than pydantic's: pipes are keys of caches."""
        corners = tuple(tuple(corner.__dict__.values()) for corner in self.corners)
        return hash((self.diameter, corners, self.straights, self.wall, self.capped, self.slope))

    @property
    def planar(self) -> bool:
        """Whether the whole route lies in the x-y plane: every roll is a multiple of 180 deg."""
        flat = all(abs(math.remainder(corner.roll, math.pi)) < FLAT for corner in self.corners)
        return flat and self.branches.in_plane

    @property
    def ends(self) -> RouteEnds:
        """Its cap and its slope."""
        return RouteEnds(self.capped, self.slope)

    @property
    def name(self) -> str:
        """`run-d100-L90-R75roll90`: diameter [mm], then turn, interior angle and roll [deg] of every corner."""
        return "-".join(
            [f"run-d{m_to_mm(self.diameter):g}", *(corner.name for corner in self.corners), *self.ends.names]
        )

    @property
    def label(self) -> str:
        return ", ".join(
            [f"{m_to_mm(self.diameter):g} mm", *(corner.label for corner in self.corners), *self.ends.labels]
        )

    @property
    def in_space(self) -> bool:
        return self.slope != 0 or not self.planar

    @property
    def down(self) -> Floats:
        return np.array([-math.sin(self.slope), 0.0, -math.cos(self.slope)])

    @property
    def legs(self) -> Legs:
        """Geometry of the straights without twist, from which walls, tubes and lines are drawn; arrays are read-only.

        `leg_frames` is the part of it that every kind of pipe has; `frames` are the same legs with twist.
        """
        return _legs(self)

    @property
    def branches(self) -> BranchPipes:
        """The branches of its tees and crosses."""
        return _branches(self)

    @property
    def has_fittings(self) -> bool:
        """Whether it has a tee, a cross or a cap, so that its walls are more than lines along it."""
        return self.capped or any(corner.branches for corner in self.corners)

    @property
    def frames(self) -> Frames:
        """Frame of every leg, twisted with the corners' planes; the arrays are read-only."""
        return _frames(self)

    @property
    def distances(self) -> Floats:
        """Distances along the centre line of the open ends and, between them, of the corners, (corners + 2,) [m].

        The first corner is at 0, the first open end at minus the length of the first straight.
        """
        return np.concatenate([[-self.straights[0], 0.0], np.cumsum(self.straights[1:])])

    @property
    def centre_line(self) -> Floats:
        """Points of the open ends and, between them, of the corners, (corners + 2, 3) [m]; a bend leaves it."""
        end = self.legs.start[-1] + self.legs.length[-1] * self.legs.axes[-1, :, 0]
        return np.concatenate([self.legs.start, end[None]]) + 0.0  # no minus zeros in files

    @property
    def walls(self) -> PlanarWalls:
        """The walls of a planar route; the arrays are read-only.

        Raises:
            PipenavError: the route leaves the plane.
        """
        return _walls(self)

    @property
    def segments(self) -> Floats:
        return self.walls.segments

    @property
    def edges(self) -> Flags:
        return self.walls.edges

    @property
    def interior_angles(self) -> Floats:
        return np.array([corner.angle for corner in self.corners])

    @property
    def turn_signs(self) -> Floats:
        return np.where(np.cos(self.legs.inside) > 0, 1.0, -1.0)

    @property
    def inner_edges(self) -> Floats:
        edges = np.maximum(self.legs.bend, self.legs.radius[:-1]) * self.legs.reach
        edges = np.where(np.isnan(self.legs.taper), edges, self.legs.taper / 2)
        for i in np.flatnonzero(self.legs.taper == 0):
            edges[i] = way_past(self.corners[i], *self.legs.radius[i : i + 2].tolist())
        return edges

    @property
    def leg_frames(self) -> LegFrames:
        return LegFrames(self.legs.start, self.legs.axes, self.legs.length, self.legs.radius)

    @property
    def wall_sides(self) -> list[WallSide]:
        return self.walls.sides

    @property
    def corner(self) -> None:
        return None

    def with_ends(self, first: float, last: float) -> Self:
        straights = (max(self.straights[0], first), *self.straights[1:-1], max(self.straights[-1], last))
        return self if straights == self.straights else cast(Self, _with_straights(self, straights))

    def to_leg(self, points: Floats, leg: Ints) -> Floats:
        """Points (..., 3), or (..., 2) of the x-y plane, in the twisted frames of the legs (...): (..., 3) [m]."""
        origin, rotation = self.frames
        from_start = in_space(points) - origin[leg]
        return np.asarray((from_start[..., None, :] @ rotation[leg])[..., 0, :])

    def contains(self, points: Floats) -> Flags:
        """Flags of points (..., 3), or (..., 2) of the x-y plane, in the round bore, not past an open end: (...)."""
        points = in_space(points)
        inside = self.branches.contain(points)
        for i in range(len(self.straights)):
            inside |= self.legs.in_straight(points, i)
        for i in np.flatnonzero(self.legs.bend).tolist():
            inside |= self.legs.in_bend(points, i)
        return inside


def as_route(pipe: Pipe) -> PipeRoute:
    """A pipe as a route.

    Raises:
        OutOfRange: the pipe is a bend of less than 0.75 diameters.
    """
    return pipe if isinstance(pipe, PipeRoute) else PipeRoute.from_corner(pipe.require_corner())


# Caches lie beside the routes, as those of corners do.
@lru_cache(maxsize=4096)
def _legs(route: PipeRoute) -> Legs:
    return make_legs(route.corners, np.array(route.straights), leg_diameters(route.diameter, route.corners) / 2)


@lru_cache(maxsize=1024)
def _with_straights(route: PipeRoute, straights: tuple[float, ...]) -> PipeRoute:
    """The route with other straights; cached, as it takes long to find out that a route does not cross itself."""
    fields = {name: getattr(route, name) for name in PipeRoute.model_fields}
    return PipeRoute(**(fields | {"straights": straights}))


@lru_cache(maxsize=4096)
def _frames(route: PipeRoute) -> Frames:
    rolls = np.cumsum([0.0, *(corner.roll for corner in route.corners)])
    return Frames(route.legs.start, frozen(route.legs.axes @ np.stack([about_x(roll) for roll in rolls])))


@lru_cache(maxsize=4096)
def _branches(route: PipeRoute) -> BranchPipes:
    return make_branches(route.corners, route.legs.start, route.legs.axes)


@lru_cache(maxsize=4096)
def _walls(route: PipeRoute) -> PlanarWalls:
    if not route.planar:
        raise PipenavError(
            f"{route.name} leaves the plane, so it has no walls in the plane: choose a route without rolls."
        )
    if route.has_fittings:
        return branched_walls(route.legs, route.branches, route.wall, route.capped)
    return plain_walls(route.legs, route.wall)
