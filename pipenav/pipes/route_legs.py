"""The straight legs of a route in space: lines along them, and whether legs meet.

No leg is twisted against its neighbour: a line at one distance from the centre line and at one angle around it is a
polyline with a point in each mitre. Angles around the centre line count from the left of the first leg upwards.
"""

from __future__ import annotations

import math
from itertools import combinations
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.pipes.convex import apart

SPACING = 0.02
"""Least distance between the outsides of two legs [m]: the thickness of what simulators put behind a wall."""

SHORT_SPACING = 0.25
"""Least distance between two legs that one short leg joins, as a share of the shortest line along that leg: where its
mitres are parallel, and as sharp as they may be, their distance is 0.26 of it."""

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
    """

    length: Floats
    start: Floats
    axes: Floats
    inside: Floats
    reach: Floats
    mitre: Floats

    def lines(self, distance: float | Floats, around: Floats) -> Floats:
        """Lines with a point at each open end and in each mitre, (m, legs + 1, 3) [m].

        Args:
            distance: distance from the centre line, one for all or (m,) [m].
            around: angles around the centre line, (m,) [rad].
        """
        along, left, up = np.moveaxis(self.axes, -1, 0)  # (legs, 3) each
        left_of, above = (distance * np.cos(around))[:, None, None], (distance * np.sin(around))[:, None, None]
        sideways = left_of * left + above * up  # (m, legs, 3)
        inwards = np.cos(around[:, None] - self.inside) * np.reshape(distance, (-1, 1))  # (m, corners)
        mitred = self.start[1:] + sideways[:, :-1] - (inwards * self.reach)[..., None] * along[:-1]
        end = self.start[-1] + self.length[-1] * along[-1]
        return np.concatenate([self.start[0] + sideways[:, :1], mitred, end + sideways[:, -1:]], axis=1)

    def meeting(self, radius: float) -> MeetingLegs | None:
        """Two legs that are no neighbours and yet meet, or nearly so (`SPACING`), as solid rods of a radius [m]."""
        around = (np.arange(ROUND) + 0.5) * 2 * math.pi / ROUND
        lines = self.lines(radius / math.cos(math.pi / ROUND), around)
        rods = [lines[:, i : i + 2].reshape(-1, 3) for i in range(len(self.length))]
        shortest = np.linalg.norm(np.diff(lines, axis=1), axis=2).min(axis=0)  # (legs,)
        for i, j in combinations(range(len(rods)), 2):
            spacing = SPACING if j > i + 2 else min(SPACING, SHORT_SPACING * shortest[i + 1])
            if j > i + 1 and not apart(rods[i], rods[j], spacing):
                return MeetingLegs(i, j)
        return None


def make_legs(angles: Floats, inside: Floats, straights: Floats) -> Legs:
    """The legs of a route, the first one along x, the second one from the origin.

    Args:
        angles: interior angles, (corners,) [rad].
        inside: direction of each corner's inside, as in `Legs`, (corners,) [rad].
        straights: lengths of the legs, (corners + 1,) [m].
    """
    axes = [np.eye(3)]
    for angle, around in zip(angles, inside, strict=True):
        axes.append(axes[-1] @ about_x(around) @ _about_z(math.pi - angle) @ about_x(-around))
    stacked = np.stack(axes)
    along = stacked[:, :, 0]
    steps = np.cumsum(straights[1:-1, None] * along[1:-1], axis=0)
    start = np.concatenate([[-straights[0] * along[0]], np.zeros((1, 3)), steps])
    mitre = along[:-1] + along[1:]
    mitre /= np.linalg.norm(mitre, axis=1, keepdims=True)
    return Legs(*map(frozen, (straights, start, stacked, inside, 1 / np.tan(angles / 2), mitre)))


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
