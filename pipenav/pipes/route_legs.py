"""The straight legs of a route in space: lines along them, and whether legs meet.

No leg is twisted against its neighbour: a line at one distance from the centre line and at one angle around it is a
polyline with a point in each mitre, or chords of an arc in each bend. Angles around the centre line count from the left
of the first leg upwards. A bend rounds every line like `pipenav.pipes.corner` rounds those of a single corner, in a
plane parallel to the corner's own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.pipes.convex import apart
from pipenav.pipes.corner_lines import ARC_TOLERANCE, arc_chords
from pipenav.pipes.rotations import about_x, about_z
from pipenav.pipes.route_corner import Corner, inside_angles

SPACING = 0.02
"""Least distance between the outsides of two legs [m]: the thickness of what simulators put behind a wall."""

SHORT_SPACING = 0.25
"""Least distance between two legs that one short leg joins, as a share of the shortest line along that leg: where its
mitres are parallel, and as sharp as they may be, their distance is 0.26 of it."""

STEP = 1e-4
"""Least length of a reducer [m], which a step gets too: solids without length are none."""

ROUND = 32
"""Sides of the prism around a leg, in the test whether legs are apart."""


class MeetingLegs(NamedTuple):
    """Two legs that meet, by their numbers from 0."""

    first: int
    second: int


class Frames(NamedTuple):
    """Frames of the legs, twisted with the corners: x along the leg, y to the left in the plane of the corner before.

    Attributes:
        origin: points where the legs begin on the centre line, (legs, 3) [m]: the open end, then every corner.
        rotation: the frames' axes as columns, (legs, 3, 3).
    """

    origin: Floats
    rotation: Floats


class _Rod(NamedTuple):
    """Points around a leg's rod, (points, 3), and the length of the shortest line along it [m]."""

    points: Floats
    shortest: float


class Legs(NamedTuple):
    """Geometry of the straight legs, without twist; the arrays are read-only.

    Attributes:
        length: lengths along the centre line, (legs,) [m].
        start: points where the legs begin on the centre line, (legs, 3) [m]; the second leg begins at the origin.
        axes: unit vectors along the leg, to the left and upwards as columns, (legs, 3, 3).
        inside: direction of each corner's inside, the same around the legs before and after it, (corners,) [rad].
        reach: distance before the corner at which a line turns that lies 1 m to its inside, (corners,) [m].
        mitre: unit normals of the mitres, forwards, (corners, 3).
        turn_angle: change of direction in each corner, (corners,) [rad].
        bend: radius of the centre line's bend in each corner, 0 for a mitre, (corners,) [m].
        radius: radius of the bore in each leg, (legs,) [m].
        taper: length of the reducer at each corner, `STEP` or more; 0 in a tee or cross, where the legs end squarely at
            the crossing of their axes; NaN in every other corner, (corners,) [m].
    """

    length: Floats
    start: Floats
    axes: Floats
    inside: Floats
    reach: Floats
    mitre: Floats
    turn_angle: Floats
    bend: Floats
    radius: Floats
    taper: Floats

    def part(self, first: int, last: int) -> Legs:
        """The legs from one to another, counted from 0, with the corners between them."""
        legs, corners = slice(first, last + 1), slice(first, last)
        return Legs(
            self.length[legs],
            self.start[legs],
            self.axes[legs],
            self.inside[corners],
            self.reach[corners],
            self.mitre[corners],
            self.turn_angle[corners],
            self.bend[corners],
            self.radius[legs],
            self.taper[corners],
        )

    def line(self, distance: float | Floats, around: float) -> Floats:
        """Single line, with as few chords in each bend as the tolerance allows, (points, 3) [m]; see `lines`."""
        chords = self.line_chords(distance, around)
        return np.asarray(self.lines(np.atleast_2d(distance), np.array([around]), chords)[0])

    def line_chords(self, distance: float | Floats, around: float) -> list[int]:
        """Number of chords of one line in each corner: 0 where it has a point alone, 1 along a reducer.

        Args:
            distance: distance from the centre line, one for all legs or (legs,) [m].
            around: angle around the centre line [rad].
        """
        before = np.broadcast_to(distance, self.length.shape)[:-1]
        fillets = self.bend - np.clip(before * np.cos(around - self.inside), -self.bend, self.bend)
        arcs = [arc_chords(*pair) for pair in zip(fillets, self.turn_angle, strict=True)]
        return [arc if math.isnan(taper) else 1 for arc, taper in zip(arcs, self.taper, strict=True)]

    def chords(self, distance: float, tolerance: float = ARC_TOLERANCE) -> list[int]:
        """Number of chords of each corner for all lines up to a distance from the centre line [m]; 0 for mitres."""
        arcs = [
            arc_chords(bend + distance, turn, tolerance) if bend else 0
            for bend, turn in zip(self.bend, self.turn_angle, strict=True)
        ]
        return [arc if math.isnan(taper) else 1 for arc, taper in zip(arcs, self.taper, strict=True)]

    def lines(self, distance: float | Floats, around: Floats, chords: Sequence[int] | None = None) -> Floats:
        """Lines with a point at each open end and in each mitre, and the ends of all chords, (m, points, 3) [m].

        Args:
            distance: distance from the centre line, one for all, (m,) or, leg by leg, (m or 1, legs) [m].
            around: angles around the centre line, (m,) [rad].
            chords: number of chords of each corner; by default `chords` of the largest distance.
        """
        along, left, up = np.moveaxis(self.axes, -1, 0)  # (legs, 3) each
        given = np.asarray(distance, float)
        away = np.broadcast_to(given if given.ndim == 2 else given.reshape(-1, 1), (len(around), len(along)))
        left_of, above = away * np.cos(around)[:, None], away * np.sin(around)[:, None]
        sideways = left_of[..., None] * left + above[..., None] * up  # (m, legs, 3)
        offset = np.cos(around[:, None] - self.inside) * away[:, :-1]  # (m, corners)
        fillet = self.bend - np.clip(offset, -self.bend, self.bend)
        begin = self.start[1:] + sideways[:, :-1] - ((offset + fillet) * self.reach)[..., None] * along[:-1]
        end = self.start[-1] + self.length[-1] * along[-1]
        points = [(self.start[0] + sideways[:, :1])]
        for i, count in enumerate(self.chords(float(np.max(given))) if chords is None else chords):
            if not math.isnan(self.taper[i]):
                share = np.linspace(0.0, 1.0, count + 1)[:, None]
                half = self.taper[i] / 2 * along[i]
                ends = self.start[i + 1] + sideways[:, i] - half, self.start[i + 1] + sideways[:, i + 1] + half
                points.append(ends[0][:, None] + share * (ends[1] - ends[0])[:, None])
                continue
            phi = np.linspace(0.0, self.turn_angle[i], count + 1) if count else np.zeros(1)
            inwards = np.cos(self.inside[i]) * left[i] + np.sin(self.inside[i]) * up[i]
            arc = np.sin(phi)[:, None] * along[i] + (1 - np.cos(phi))[:, None] * inwards  # of radius 1, (count + 1, 3)
            points.append(begin[:, i, None] + fillet[:, i, None, None] * arc)
        return np.concatenate([*points, end + sideways[:, -1:]], axis=1)

    def in_straight(self, points: Floats, leg: int) -> Flags:
        """Flags of points (..., 3) in the bore of one leg, reducers included and bends left out: (...).

        Args:
            points: points in the route's frame [m].
            leg: the leg, counted from 0.
        """
        along, left, up = np.moveaxis((points - self.start[leg]) @ self.axes[leg], -1, 0)
        radius = np.full(along.shape, self.radius[leg])
        straight = (along >= 0) if leg == 0 else self._past_corner(points, along, leg - 1, 1.0)
        if leg == len(self.bend):
            straight &= along <= self.length[leg]
        else:
            straight &= self._past_corner(points, self.length[leg] - along, leg, -1.0)
        for corner, past in ((leg - 1, along), (leg, along - self.length[leg])):
            if 0 <= corner < len(self.bend) and self.taper[corner] > 0:
                share = np.clip(past / self.taper[corner] + 0.5, 0.0, 1.0)
                tapered = self.radius[corner] + share * (self.radius[corner + 1] - self.radius[corner])
                radius = np.where(np.abs(past) < self.taper[corner] / 2, tapered, radius)
        return np.asarray(straight & (np.hypot(left, up) <= radius))

    def _past_corner(self, points: Floats, along: Floats, corner: int, sign: float) -> Flags:
        """Flags of points (..., 3) on the side of a corner where its leg is: (...).

        Args:
            points: points in the route's frame [m].
            along: distance from the crossing of the axes along the leg, (...) [m].
            corner: the corner, counted from 0.
            sign: +1 for the leg after the corner, -1 for the leg before.
        """
        if self.bend[corner] or not math.isnan(self.taper[corner]):
            return np.asarray(along >= self.bend[corner] * self.reach[corner])
        return np.asarray(sign * ((points - self.start[corner + 1]) @ self.mitre[corner]) >= 0)

    def in_bend(self, points: Floats, corner: int) -> Flags:
        """Flags of points (..., 3) in the bore of a corner's bend, which is a piece of a torus: (...).

        Args:
            points: points in the route's frame [m].
            corner: the corner, counted from 0.
        """
        bend, around = self.bend[corner], self.inside[corner]
        along, left, up = np.moveaxis((points - self.start[corner]) @ self.axes[corner], -1, 0)
        forwards = along - (self.length[corner] - bend * self.reach[corner])
        outwards = bend - (left * np.cos(around) + up * np.sin(around))
        across = up * np.cos(around) - left * np.sin(around)
        angle = np.arctan2(forwards, outwards)
        near = np.hypot(np.hypot(forwards, outwards) - bend, across) <= self.radius[corner]
        return np.asarray(near & (angle >= 0) & (angle <= self.turn_angle[corner]))

    def rods(self, radius: Floats) -> list[Floats]:
        """Points around every leg as a solid rod, with half of each bend beside it, (points, 3) [m] each.

        Args:
            radius: radius of each leg's rod, (legs,) [m].
        """
        return [points for points, _ in self._rods(radius)]

    def meeting(self, radius: Floats) -> MeetingLegs | None:
        """Two legs that are no neighbours and yet meet, or nearly so (`SPACING`), as solid rods.

        Args:
            radius: radius of each leg's rod, (legs,) [m].
        """
        rods = self._rods(radius)
        for i, j in combinations(range(len(rods)), 2):
            spacing = SPACING if j > i + 2 else min(SPACING, SHORT_SPACING * rods[i + 1].shortest)
            if j > i + 1 and not apart(rods[i].points, rods[j].points, spacing):
                return MeetingLegs(i, j)
        return None

    def _rods(self, radius: Floats) -> list[_Rod]:
        around = rod_angles()
        # A leg's rod takes half of each bend beside it.
        halves = [(count + 1) // 2 for count in self.chords(float(radius.max()))]
        lines = self.lines(radius[None] / math.cos(math.pi / ROUND), around, [2 * half for half in halves])
        bends = np.cumsum([0, *(2 * half + 1 for half in halves)])  # the point before each bend, and the last but one
        first, last = bends, bends + 1
        middle = np.array([0, *(bends[:-1] + 1 + np.array(halves, int)), lines.shape[1] - 1])
        shortest = np.linalg.norm(lines[:, last] - lines[:, first], axis=2).min(axis=0)  # (legs,)
        ends = zip(pairwise(middle), shortest.tolist(), strict=True)
        return [_Rod(lines[:, a : b + 1].reshape(-1, 3), least) for (a, b), least in ends]


def rod_angles() -> Floats:
    """Angles of the corners of a rod's prism around its axis, (ROUND,) [rad]."""
    return np.asarray((np.arange(ROUND) + 0.5) * 2 * math.pi / ROUND)


def make_legs(corners: Sequence[Corner], straights: Floats, radius: Floats) -> Legs:
    """The legs of a route, the first one along x, the second one from the origin.

    Args:
        corners: corners in order.
        straights: lengths of the legs, (corners + 1,) [m].
        radius: radius of the bore in each leg, (corners + 1,) [m].
    """
    angles, bends = np.array([(corner.angle, corner.bend_radius) for corner in corners]).T.copy()
    tapers = np.array([_taper(corner) for corner in corners])
    inside = inside_angles(corners)
    axes = [np.eye(3)]
    for angle, around in zip(angles, inside, strict=True):
        axes.append(axes[-1] @ about_x(around) @ about_z(math.pi - angle) @ about_x(-around))
    stacked = np.stack(axes)
    along = stacked[:, :, 0]
    steps = np.cumsum(straights[1:-1, None] * along[1:-1], axis=0)
    start = np.concatenate([[-straights[0] * along[0]], np.zeros((1, 3)), steps])
    mitre = along[:-1] + along[1:]
    mitre /= np.linalg.norm(mitre, axis=1, keepdims=True)
    reach = 1 / np.tan(angles / 2)
    turns = math.pi - angles
    return Legs(*map(frozen, (straights, start, stacked, inside, reach, mitre, turns, bends, radius, tapers)))


def _taper(corner: Corner) -> float:
    """Length of a corner's reducer, see `Legs.taper` [m]."""
    if corner.branches:
        return 0.0
    return math.nan if corner.to_diameter is None else max(corner.length, STEP)


def frozen(array: Floats) -> Floats:
    """The array itself, made read-only."""
    array.setflags(write=False)
    return array
