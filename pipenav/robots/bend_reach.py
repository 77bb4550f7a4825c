"""The reach of an arm on a mount along a swept bend, for k bends at once.

An arm passes a bend in several steps: each time the front half reaches a target, and the rear half follows. A step is
as long as the arm's slide and its hinged links let it be. Through a mitre that is always enough; through a bend of
three diameters it is not, and a target behind such a bend could be reached by no controller.

The frame here is the canonical one, moved along the first leg: x = 0 is where the inner wall starts to bend, the first
leg's axis is y = 0, and the bend turns left around its turning point, (0, rho). rho is the radius of the middle line,
the line that keeps one bore radius from the inner wall: the bend radius, or the bore's radius where the bend is so
tight that its inner edge is sharp. Distances along the middle line count from x = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats
from pipenav.robots.robot import RobotSpec

RESERVE = 0.05
"""Share of a joint's travel that a reach leaves at either end: ten times what ends an episode, and for the shipped arms
20 mm of the slide, one step of its set-point."""

CLEARANCE = 0.003
"""Distance from the walls that a reach keeps [m]: one and a half times the overlap that ends an episode."""

ADVANCES = np.array([0.0, 0.02, 0.04, 0.06])
"""Positions of the slide that are tried, back from its last [m]: half a link, which decides how links lie in a bend."""

SWINGS = 12
"""Distances of the hinges from the turning point that are tried."""


class Bends(NamedTuple):
    """Swept bends of k pipes.

    Attributes:
        radius: radius of the bore, (k,) [m].
        bend_radius: radius of the centre line's bend, (k,) [m].
        turn_angle: change of heading, (k,) [rad].
    """

    radius: Floats
    bend_radius: Floats
    turn_angle: Floats

    @property
    def middle_radius(self) -> Floats:
        """Radius rho of the middle line's bend, (k,) [m]."""
        return np.maximum(self.bend_radius, self.radius)

    @property
    def end(self) -> Floats:
        """Distance along the middle line at which the bend ends, (k,) [m]."""
        return self.middle_radius * self.turn_angle

    def part(self, rows: Flags) -> Bends:
        """Bends of some rows."""
        return Bends(*(column[rows] for column in self))

    def points(self, distance: Floats, aside: Floats) -> Floats:
        """Points at distances along the middle line, and aside of it towards the inside of the turn, (k, 2) [m].

        Args:
            distance: distances along the middle line, (k,) [m].
            aside: distances from it, (k,) [m].
        """
        rho = self.middle_radius
        turned = np.clip(distance, 0.0, self.end) / rho
        straight = distance - rho * turned  # before the bend it is negative, past it positive
        sin, cos = np.sin(turned), np.cos(turned)
        return np.stack([straight * cos + (rho - aside) * sin, rho + straight * sin - (rho - aside) * cos], axis=-1)

    def distance(self, points: Floats) -> Floats:
        """Distances along the middle line of points (k, 2): (k,) [m]; each counts to the leg or arc abreast of it."""
        return _distance(_Polar.of(points, self), self)


class _Polar(NamedTuple):
    """Points (...) seen from the turning points of k bends, the k along the first axis.

    Attributes:
        away: distance from the turning point, (...) [m].
        turned: angle around it, 0 at the bend's start, (...) [rad].
    """

    away: Floats
    turned: Floats

    @classmethod
    def of(cls, points: Floats, bends: Bends) -> _Polar:
        """Points (k, ..., 2) in polar coordinates."""
        rho, half = (_spread(column, points.ndim - 1) for column in (bends.middle_radius, bends.turn_angle / 2))
        x, y = points[..., 0], rho - points[..., 1]
        cos, sin = np.cos(half), np.sin(half)
        middle = np.arctan2(cos * x - sin * y, sin * x + cos * y)  # counted from the bend's middle it never wraps
        return cls(np.hypot(x, y), middle + half)


def reach_along(robot: RobotSpec, bends: Bends, base: Floats) -> Floats:
    """Farthest distance along the middle line at which the tip can stand on it, (k,) [m].

    The slide is out, the hinges stand on one line around the turning point, forward of each other, and the tip stands
    on the middle line. Of all such poses that keep `CLEARANCE` from the walls and `RESERVE` from the joints' limits the
    one that reaches farthest counts. A link's outline lies in the strip of the robot's width around its axis. The outer
    wall bounds a convex space and the inner wall a convex obstacle, so the strip is free where its ends keep off the
    outer wall and it keeps off the turning point. In elbows of a diameter or more, up to 90 deg, no pose comes 50 mm
    farther: a string from the first hinge, pulled taut around the inner wall, would be longer than the links. Where no
    pose is found, as in corners so tight that links lie across them, the reach is infinite: nothing is known.

    Args:
        robot: an arm on a mount.
        bends: the bends.
        base: x of the robot's frame, (k,) [m].
    """
    k = len(base)
    first = int(np.argmax(robot.hinges))  # links before the first hinge only advance
    travel = RESERVE * (robot.upper - robot.lower)
    low, high = robot.lower + travel, robot.upper - travel
    advances = high[:first].sum() - ADVANCES + robot.lengths[:first].sum()
    apart = robot.width / 2 + CLEARANCE
    nearest, widest = bends.middle_radius - bends.radius + apart, bends.middle_radius + bends.radius - apart
    swings = np.linspace(bends.middle_radius - bends.radius / 2, widest, SWINGS, axis=-1)  # (k, SWINGS)
    shape = (k, len(ADVANCES), SWINGS)
    point = np.zeros((*shape, 2))
    point[..., 0] = (base[:, None] + advances)[..., None]
    heading, free = np.zeros(shape), np.broadcast_to((widest >= nearest)[:, None, None], shape)
    for j, length in enumerate(robot.lengths[first:], start=first):
        last = j == len(robot.lengths) - 1
        away = np.broadcast_to(_spread(bends.middle_radius, 3) if last else swings[:, None], shape)
        end = _meet(bends, point, float(length), away)
        direction = np.arctan2(*np.moveaxis(end - point, -1, 0)[::-1])
        bent = np.mod(direction - heading + np.pi, 2 * np.pi) - np.pi
        with np.errstate(invalid="ignore"):  # a link that does not come to its line is nowhere, NaN
            free = free & (_off_turning_point(bends, point, end) >= _spread(nearest, 3))
            free &= (bent >= low[j]) & (bent <= high[j])
        point, heading = end, direction
    along = np.where(free, _distance(_Polar.of(np.nan_to_num(point), bends), bends), -np.inf).reshape(k, -1)
    return np.where(free.reshape(k, -1).any(axis=1), along.max(axis=1), np.inf)


def _meet(bends: Bends, point: Floats, length: float, away: Floats) -> Floats:
    """Far ends of links on lines around the turning point, forward of their near ends, (k, ..., 2) [m].

    Args:
        bends: the bends.
        point: near ends, (k, ..., 2) [m].
        length: length of the links [m].
        away: distances of the lines from the turning point, (k, ...) [m].
    """
    dimensions = point.ndim - 1
    rho, turn = _spread(bends.middle_radius, dimensions), _spread(bends.turn_angle, dimensions)
    seen = _Polar.of(point, bends)
    off = point[..., 1] - (rho - away)
    cosine = (seen.away**2 + away**2 - length**2) / (2 * seen.away * away)
    along, across = seen.away * np.sin(seen.turned - turn), seen.away * np.cos(seen.turned - turn) - away
    with np.errstate(invalid="ignore"):
        before = point[..., 0] + np.sqrt(length**2 - off**2)
        turned = seen.turned + np.arccos(cosine)
        past = along + np.sqrt(length**2 - across**2)
    straight = np.where(before <= 0, before, np.where(turned <= turn, 0.0, past))
    turned = np.where(before <= 0, 0.0, np.where(turned <= turn, turned, turn))
    sin, cos = np.sin(turned), np.cos(turned)
    return np.stack([straight * cos + away * sin, rho + straight * sin - away * cos], axis=-1)


def _off_turning_point(bends: Bends, start: Floats, end: Floats) -> Floats:
    """Distances of segments (k, ..., 2) from the turning points, negative where they pass inside: (k, ...) [m]."""
    (dx, dy), (x, y) = np.moveaxis(end - start, -1, 0), np.moveaxis(-start, -1, 0)
    y = y + _spread(bends.middle_radius, y.ndim)
    share = np.clip((x * dx + y * dy) / (dx * dx + dy * dy), 0.0, 1.0)
    return np.asarray(np.copysign(np.hypot(x - share * dx, y - share * dy), dx * y - dy * x))


def _distance(seen: _Polar, bends: Bends) -> Floats:
    """Distances along the middle line of points in polar coordinates, (k, ...) [m]."""
    dimensions = seen.turned.ndim
    rho, turn = _spread(bends.middle_radius, dimensions), _spread(bends.turn_angle, dimensions)
    on_arc = np.clip(seen.turned, 0.0, turn)
    return np.asarray(rho * on_arc + seen.away * np.sin(seen.turned - on_arc))


def _spread(column: Floats, dimensions: int) -> Floats:
    """A column (k,) with so many dimensions, to be broadcast along all but the first."""
    return column.reshape(-1, *[1] * (dimensions - 1))
