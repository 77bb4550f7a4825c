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

from pipenav.arrays import Flags, Floats, Ints
from pipenav.pipes.convex import apart
from pipenav.pipes.corner_lines import ARC_TOLERANCE, arc_chords
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
        taper: length of the reducer at each corner, `STEP` or more, and NaN where there is none, (corners,) [m].
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

    def in_straight(self, leg: Ints, local: Floats) -> Flags:
        """Flags of points in the bore of their legs, reducers included and bends left out: (...).

        Args:
            leg: leg of each point, (...).
            local: position from the leg's start: along it, to its left and upwards, (..., 3) [m].
        """
        along, radius = local[..., 0], self.radius[leg]
        straight = np.ones(leg.shape, bool)
        for i in range(len(self.bend)):
            past_corner = np.where(leg == i, along - self.length[i], np.where(leg == i + 1, along, np.inf))
            if math.isnan(self.taper[i]):
                straight &= ~(np.abs(past_corner) < self.bend[i] * self.reach[i])
                continue
            share = np.clip(past_corner / self.taper[i] + 0.5, 0.0, 1.0)
            tapered = self.radius[i] + share * (self.radius[i + 1] - self.radius[i])
            radius = np.where(np.isinf(past_corner), radius, tapered)
        return np.asarray(straight & (np.hypot(local[..., 1], local[..., 2]) <= radius))

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

    def meeting(self, radius: Floats) -> MeetingLegs | None:
        """Two legs that are no neighbours and yet meet, or nearly so (`SPACING`), as solid rods.

        Args:
            radius: radius of each leg's rod, (legs,) [m].
        """
        around = (np.arange(ROUND) + 0.5) * 2 * math.pi / ROUND
        # A leg's rod takes half of each bend beside it.
        halves = [(count + 1) // 2 for count in self.chords(float(radius.max()))]
        lines = self.lines(radius[None] / math.cos(math.pi / ROUND), around, [2 * half for half in halves])
        bends = np.cumsum([0, *(2 * half + 1 for half in halves)])  # the point before each bend, and the last but one
        first, last = bends, bends + 1
        middle = np.array([0, *(bends[:-1] + 1 + np.array(halves, int)), lines.shape[1] - 1])
        rods = [lines[:, a : b + 1].reshape(-1, 3) for a, b in pairwise(middle)]
        shortest = np.linalg.norm(lines[:, last] - lines[:, first], axis=2).min(axis=0)  # (legs,)
        for i, j in combinations(range(len(rods)), 2):
            spacing = SPACING if j > i + 2 else min(SPACING, SHORT_SPACING * shortest[i + 1])
            if j > i + 1 and not apart(rods[i], rods[j], spacing):
                return MeetingLegs(i, j)
        return None


def make_legs(corners: Sequence[Corner], straights: Floats, radius: Floats) -> Legs:
    """The legs of a route, the first one along x, the second one from the origin.

    Args:
        corners: corners in order.
        straights: lengths of the legs, (corners + 1,) [m].
        radius: radius of the bore in each leg, (corners + 1,) [m].
    """
    angles, bends = np.array([(corner.angle, corner.bend_radius) for corner in corners]).T.copy()
    tapers = np.array([np.nan if one.to_diameter is None else max(one.length, STEP) for one in corners])
    inside = inside_angles(corners)
    axes = [np.eye(3)]
    for angle, around in zip(angles, inside, strict=True):
        axes.append(axes[-1] @ about_x(around) @ _about_z(math.pi - angle) @ about_x(-around))
    stacked = np.stack(axes)
    along = stacked[:, :, 0]
    steps = np.cumsum(straights[1:-1, None] * along[1:-1], axis=0)
    start = np.concatenate([[-straights[0] * along[0]], np.zeros((1, 3)), steps])
    mitre = along[:-1] + along[1:]
    mitre /= np.linalg.norm(mitre, axis=1, keepdims=True)
    reach = 1 / np.tan(angles / 2)
    turns = math.pi - angles
    return Legs(*map(frozen, (straights, start, stacked, inside, reach, mitre, turns, bends, radius, tapers)))


def frozen(array: Floats) -> Floats:
    """The array itself, made read-only."""
    array.setflags(write=False)
    return array


def about_x(angle: float) -> Floats:
    """Rotation about x, (3, 3)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _about_z(angle: float) -> Floats:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
