"""A pipe corner: two straight legs, joined by a mitre, a bend, a tee or a cross, in the plane of the robot.

Frame: the corner (the crossing of the two centre lines) is the origin; the first leg lies along -x, the robot comes
from -x moving towards +x, and a left turn goes towards +y. `angle` is the INTERIOR angle between the legs, so the
heading changes by pi - angle.

Every line along the pipe (a wall, the centre line, a generator of the tube) is the mitred polyline at one lateral
offset `o` from the centre line (positive towards the inside of the turn), rounded by a fillet of radius
`R - clip(o, -R, R)`, R being the bend radius of the centre line. For R = 0 that is a mitre; for R >= d/2 it is the
swept bend (concentric arcs); in between, the inner edge stays sharp while the outer one is rounded, as in a short
elbow. One formula serves walls, tube and drawing.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple, Self

import numpy as np
from pydantic import model_validator

from pipenav.arrays import Flags, Floats
from pipenav.pipes.branch import Branch
from pipenav.pipes.branch_pipes import check_fitting, make_branches, reaches_of
from pipenav.pipes.corner_checks import LEG_MAX_MM, check_corner, check_range, check_turn, default_leg, shortest_leg
from pipenav.pipes.corner_lines import arc_chords, fillet_radius, tangent_length
from pipenav.pipes.pipe import DEFAULT_WALL, LegFrames, Pipe, Turn, WallSide
from pipenav.pipes.route_corner import Corner
from pipenav.pipes.route_legs import make_legs
from pipenav.pipes.route_walls import PlanarWalls, branched_walls
from pipenav.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg


class Lines(NamedTuple):
    """The two walls as polylines, points in order along the pipe [m], each (k, 2)."""

    inner: Floats
    outer: Floats


class PipeCorner(Pipe):
    """A single corner. All lengths in metres, angles in radians; `PipeCorner.of` takes millimetres and degrees.

    Attributes:
        diameter: inner diameter of both legs [m].
        angle: interior angle between the legs [rad]; pi is a straight pipe.
        turn: side that the pipe turns to, seen by the robot.
        bend_radius: radius of the centre line's bend [m]; 0 is a mitre.
        leg: length of each leg along its centre line, from the corner [m].
        branches: in a tee or a cross, the pipes that the robot does not take.
        wall: wall thickness [m].
    """

    angle: float
    turn: Turn = "left"
    bend_radius: float = 0.0
    leg: float
    branches: tuple[Branch, ...] = ()

    @classmethod
    def of(
        cls,
        diameter_mm: float,
        angle_deg: float,
        turn: str = "left",
        bend_radius_mm: float = 0.0,
        leg_mm: float | None = None,
        wall_mm: float | None = None,
    ) -> Self:
        """A corner from the numbers that people use.

        Raises:
            OutOfRange: a number outside its allowed range; for the leg that range begins past the bend.
            PipenavError: an unknown turn.
        """
        checked_turn = check_turn(turn)
        wall = DEFAULT_WALL if wall_mm is None else mm_to_m(wall_mm)
        diameter, angle, bend = mm_to_m(diameter_mm), deg_to_rad(angle_deg), mm_to_m(bend_radius_mm)
        check_corner(diameter, angle, bend, wall)  # before the leg, whose default follows from these
        shortest = shortest_leg(diameter, angle, bend, wall)
        leg = default_leg(shortest, diameter) if leg_mm is None else mm_to_m(leg_mm)
        return cls(diameter=diameter, angle=angle, turn=checked_turn, bend_radius=bend, leg=leg, wall=wall)

    @model_validator(mode="after")
    def _within_ranges(self) -> Self:
        check_corner(self.diameter, self.angle, self.bend_radius, self.wall)
        shortest = m_to_mm(shortest_leg(self.diameter, self.angle, self.bend_radius, self.wall))
        if self.branches:
            fitting = self.as_route_corner
            check_fitting(1, fitting, self.diameter, self.diameter, self.wall)
            past = reaches_of(fitting, self.diameter, self.diameter, self.wall)[:2].max()
            shortest = max(shortest, m_to_mm(past + 0.1 * self.diameter))
        check_range("leg length", m_to_mm(self.leg), math.ceil(shortest - 1e-9), LEG_MAX_MM, "mm")
        return self

    def __hash__(self) -> int:
        """Hash over all fields, ten times faster than pydantic's: pipes are keys of caches."""
        return hash((self.diameter, self.angle, self.turn, self.bend_radius, self.leg, self.wall, self.branches))

    @property
    def as_route_corner(self) -> Corner:
        """The corner as a part of a route."""
        return Corner(angle=self.angle, turn=self.turn, bend_radius=self.bend_radius, branches=self.branches)

    @property
    def mirrored(self) -> Self:
        """The corner that turns to the other side."""
        turn: Turn = "right" if self.turn == "left" else "left"
        return self.model_copy(update={"turn": turn, "branches": tuple(branch.mirrored for branch in self.branches)})

    @property
    def turned_round(self) -> Self:
        """The corner as it is for a robot that comes by the second leg; without branches it is the mirrored one."""
        branches = tuple(self._from_second_leg(branch) for branch in self.branches)
        return self.mirrored.model_copy(update={"branches": branches})

    def _from_second_leg(self, branch: Branch) -> Branch:
        """A branch in the plane as it is for a robot that comes by the second leg."""
        sign = 1.0 if branch.turn == "left" else -1.0
        heading = math.remainder(sign * (math.pi - branch.angle) - self.heading_change - math.pi, 2 * math.pi)
        turn: Turn = "left" if heading >= 0 else "right"
        return branch.model_copy(update={"angle": math.pi - abs(heading), "turn": turn})

    @property
    def turn_sign(self) -> float:
        """+1 for a left turn, -1 for a right one: y of the canonical frame times this is y of the pipe's frame."""
        return 1.0 if self.turn == "left" else -1.0

    @property
    def heading_change(self) -> float:
        """Signed change of heading from the first leg to the second [rad], positive to the left."""
        return self.turn_sign * (math.pi - self.angle)

    @property
    def second_leg(self) -> Floats:
        """Unit vector along the second leg, away from the corner, (2,)."""
        return np.array([math.cos(self.heading_change), math.sin(self.heading_change)])

    @property
    def inner_edge(self) -> float:
        """Distance along either leg from the corner to where the inner wall's bend ends [m].

        It is 0 where the pipe goes straight on, past a branch too.
        """
        return self.tangent_length(self.radius)

    @property
    def gap(self) -> float:
        """Free width along the corner's bisector, from inner to outer wall [m]; d / sin(angle/2) for a mitre."""
        return self.apex(self.radius) - self.apex(-self.radius)

    @property
    def name(self) -> str:
        """`corner-d100-a75-left`: diameter [mm], interior angle [deg], turn; a bend radius [mm] before the turn.

        Branches follow the turn.
        """
        bend = f"-r{m_to_mm(self.bend_radius):g}" if self.bend_radius else ""
        branches = "".join(f"-{branch.name}" for branch in self.branches)
        return f"corner-d{m_to_mm(self.diameter):g}-a{rad_to_deg(self.angle):g}{bend}-{self.turn}{branches}"

    @property
    def label(self) -> str:
        if self.branches:
            return f"{m_to_mm(self.diameter):g} mm, {self.as_route_corner.label}"
        bend = f", in {m_to_mm(self.bend_radius):g} mm" if self.bend_radius else ""
        return f"{m_to_mm(self.diameter):g} mm, {rad_to_deg(self.angle):g} deg, {self.turn}{bend}"

    def tangent_length(self, offset: float) -> float:
        """Distance along a leg from the corner to where the line at `offset` starts to bend [m]."""
        return tangent_length(offset, self.bend_radius, self.angle)

    def apex(self, offset: float) -> float:
        """Position at which the line at `offset` crosses the corner's bisector [m], positive towards the inside."""
        fillet = fillet_radius(offset, self.bend_radius)
        return (offset + fillet) / math.sin(self.angle / 2) - fillet

    def line(self, offset: float, arc_segments: int | None = None) -> Floats:
        """The line at lateral `offset` [m] (positive: inside of the turn), points (k, 2) from start to end.

        Args:
            offset: distance from the centre line.
            arc_segments: chords that stand for the arc, 0 for a corner; by default as few as the tolerance allows.
        """
        half = self.angle / 2
        radius = fillet_radius(offset, self.bend_radius)
        start = self.tangent_length(offset)
        turn_angle = math.pi - self.angle
        if arc_segments is None:
            arc_segments = arc_chords(radius, turn_angle)
        phi = np.linspace(0.0, turn_angle, arc_segments + 1) if arc_segments else np.zeros(1)  # (k,)
        centre = np.array([-start, offset + radius])
        arc = centre + radius * np.stack([np.sin(phi), -np.cos(phi)], axis=1)
        if arc_segments == 0:
            arc = np.array([[-offset / math.tan(half), offset]])
        direction = np.array([math.cos(turn_angle), math.sin(turn_angle)])
        normal = np.array([-math.sin(turn_angle), math.cos(turn_angle)])
        first = np.array([[-self.leg, offset]])
        last = (self.leg * direction + offset * normal)[None]
        points = np.concatenate([first, arc, last])
        return np.asarray(points * np.array([1.0, self.turn_sign]))

    @property
    def walls(self) -> Lines:
        """Inner and outer wall of the two legs, as if there were no branches; the arrays are read-only."""
        return _walls(self)

    @property
    def segments(self) -> Floats:
        return _segments(self)

    @property
    def edges(self) -> Flags:
        if self.branches:
            return _fitting_walls(self).edges
        inner = np.arange(len(self.segments)) >= len(self.walls.outer) - 1
        return np.stack([inner, inner], axis=1)

    def contains(self, points: Floats) -> Flags:
        """Flags of points (..., 2) inside the pipe, not in or beyond a wall, nor beyond an open end: (...)."""
        outline = np.concatenate([self.walls.outer, self.walls.inner[::-1]])
        if self.branches:
            outline = self.segments.reshape(-1, 2)
        x, y = np.moveaxis(np.asarray(points, float), -1, 0)
        inside = np.zeros(x.shape, bool)
        # A point is inside where a ray from it towards +x crosses the outline an odd number of times.
        for (x1, y1), (x2, y2) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            if y1 != y2:
                crosses = (y1 > y) != (y2 > y)
                inside ^= crosses & (x < x1 + (y - y1) * (x2 - x1) / (y2 - y1))
        return inside

    def along_second_leg(self, points: Floats) -> Floats:
        """Points (..., 2) of the pipe's frame as (distance past the corner, offset to the left) of the second leg."""
        u = self.second_leg
        return np.stack([points @ u, points @ np.array([-u[1], u[0]])], axis=-1)

    @property
    def planar(self) -> bool:
        """Always True: a corner lies in the plane."""
        return True

    @property
    def interior_angles(self) -> Floats:
        return np.array([self.angle])

    @property
    def turn_signs(self) -> Floats:
        return np.array([self.turn_sign])

    @property
    def inner_edges(self) -> Floats:
        return np.array([self.inner_edge])

    @property
    def leg_frames(self) -> LegFrames:
        return _leg_frames(self)

    @property
    def wall_sides(self) -> list[WallSide]:
        if self.branches:
            return _fitting_walls(self).sides
        back = self.radius + self.wall
        return [WallSide(self.walls.inner, self.line(back)), WallSide(self.walls.outer, self.line(-back))]

    @property
    def corner(self) -> Self:
        return self

    def with_ends(self, first: float, last: float) -> Self:
        """The corner with legs of one length: at least the longer of the two [m]."""
        need = max(first, last)
        return self if self.leg >= need else self.model_copy(update={"leg": need})


# Caches lie beside the pipes: a cached array inside a model breaks its equality and outlives a copy's update.
# They hold every pipe of the largest shipped training set.
@lru_cache(maxsize=4096)
def _walls(pipe: PipeCorner) -> Lines:
    lines = Lines(pipe.line(pipe.radius), pipe.line(-pipe.radius))
    for line in lines:
        line.setflags(write=False)
    return lines


@lru_cache(maxsize=4096)
def _leg_frames(pipe: PipeCorner) -> LegFrames:
    (x, y), length, radius = pipe.second_leg, np.full(2, pipe.leg), np.full(2, pipe.radius)
    start = np.array([[-pipe.leg, 0.0, 0.0], [0.0, 0.0, 0.0]])
    axes = np.stack([np.eye(3), np.array([[x, -y, 0.0], [y, x, 0.0], [0.0, 0.0, 1.0]])])
    for array in (start, axes, length, radius):
        array.setflags(write=False)
    return LegFrames(start, axes, length, radius)


@lru_cache(maxsize=4096)
def _segments(pipe: PipeCorner) -> Floats:
    if pipe.branches:
        return _fitting_walls(pipe).segments
    # A left turn's outer wall has the pipe on its left as it runs forwards, its inner wall as it runs backwards.
    walls = [pipe.walls.outer, pipe.walls.inner[::-1]]
    stacked = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in walls])
    if pipe.turn == "right":
        stacked = stacked[:, ::-1]
    stacked.setflags(write=False)
    return stacked


@lru_cache(maxsize=4096)
def _fitting_walls(pipe: PipeCorner) -> PlanarWalls:
    corners = [pipe.as_route_corner]
    legs = make_legs(corners, np.full(2, pipe.leg), np.full(2, pipe.radius))
    return branched_walls(legs, make_branches(corners, legs.start, legs.axes), pipe.wall, capped=False)
