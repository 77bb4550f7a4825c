"""Interval of the slide in which a chain with given headings lies free in a corner.

With all headings fixed, the chain moves along the first leg alone. The outer wall bounds a convex region, open towards
-x, so it limits the slide from above; the inner wall is convex and reaches to -x, so it limits it from below. Hence the
free slides are one interval, for any bend radius.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.certify.corner_walls import CornerWalls, Wedge
from pipenav.certify.shapes import Shapes

TANGENT = 1e-9
"""Sine of a direction below which it counts as parallel to the first leg."""


TOUCH = 1e-12
"""Distance beyond a wall that rounding errors make [m]."""


class Interval(NamedTuple):
    """Free slides: x of the first link's rear end in the pipe's frame; empty where `low` is above `high`.

    Attributes:
        low: smallest, (n,) [m].
        high: largest, (n,) [m].
    """

    low: Floats
    high: Floats


class Height(NamedTuple):
    """Heights of chains.

    Attributes:
        y: y of the first link's rear end, (n,) [m].
        spread: largest difference of it, for intervals as with a spread of the headings [m].
    """

    y: Floats
    spread: float


class SeenWalls(NamedTuple):
    """Walls that each part of a chain sees.

    Attributes:
        boxes: walls for each box, numbers (boxes,).
        discs: walls for each disc, numbers (discs,).
    """

    boxes: CornerWalls
    discs: CornerWalls


def slide_interval(
    shapes: Shapes, walls: SeenWalls, headings: Floats, spread: float = 0.0, height: Height | None = None
) -> Interval:
    """Free slides of a chain.

    With a spread, the interval holds every slide at which any chain is free whose headings differ by at most that much
    from the given ones: boxes are taken back by what they can have moved along and across, discs by the distance, and
    where a part is smaller than that, the walls by the rest.

    Args:
        shapes: parts of the chain.
        walls: walls that its parts see.
        headings: absolute headings of the links, (n, links) [rad].
        spread: largest difference of each heading, the first link's aside, which keeps its own [rad].
        height: y of the first link's rear end, by default on the first leg's axis.
    """
    low, high = np.full(len(headings), -np.inf), np.full(len(headings), np.inf)
    active = np.arange(len(headings))
    x, (y, raised) = np.zeros(len(headings)), height or Height(np.zeros(len(headings)), 0.0)
    before: list[_Arm] = []
    moved = raised
    for link, length in enumerate(shapes.lengths.tolist()):
        turned = spread if link else 0.0
        cos, sin = np.cos(headings[active, link]), np.sin(headings[active, link])
        pose = _Pose(x, y, cos, sin)
        spread_of = _Spread(moved, turned, *_moved(before, pose, raised, spread))
        found = _link_interval(shapes, walls, link, pose, spread_of)
        low[active], high[active] = np.maximum(low[active], found.low), np.minimum(high[active], found.high)
        free = low[active] <= high[active]
        active, x, y = active[free], (x + length * cos)[free], (y + length * sin)[free]
        moved += length * turned
        before = [_Arm(arm.length, arm.cos[free], arm.sin[free]) for arm in before]
        if link:
            before.append(_Arm(length, cos[free], sin[free]))
    return Interval(low, high)


class _Arm(NamedTuple):
    """A link that turns others: its length [m], and the cosine and sine of its heading, (n,) each."""

    length: float
    cos: Floats
    sin: Floats


def _moved(before: list[_Arm], pose: _Pose, raised: float, spread: float) -> tuple[Floats, Floats]:
    """Largest ways of a link's rear end along the link and across it, where links before it turn, (n,) each [m].

    A link of length l that turns by up to e moves its end by l sin e across itself and l (1 - cos e) along, which is
    less than l e and l e^2 / 2.
    """
    along, across = np.full(len(pose.x), raised), np.full(len(pose.x), raised)
    for length, cos, sin in before:
        more = length * spread**2 / 2
        along += length * spread * np.abs(sin * pose.cos - cos * pose.sin) + more
        across += length * spread * np.abs(cos * pose.cos + sin * pose.sin) + more
    return along, across


class _Pose(NamedTuple):
    """Pose of a link for a slide of 0: its rear end and the cosine and sine of its heading, (n,) each."""

    x: Floats
    y: Floats
    cos: Floats
    sin: Floats


class _Spread(NamedTuple):
    """Differences that a pose stands for.

    Attributes:
        moved: largest way of the link's rear end [m].
        turned: largest difference of its heading [rad].
        along: largest way of the rear end along the link, (n,) [m].
        across: largest way of the rear end across it, (n,) [m].
    """

    moved: float
    turned: float
    along: Floats
    across: Floats


def _link_interval(shapes: Shapes, walls: SeenWalls, link: int, pose: _Pose, spread: _Spread) -> Interval:
    low, high = np.full(len(pose.x), -np.inf), np.full(len(pose.x), np.inf)
    for i in np.flatnonzero(shapes.boxes.link == link).tolist():
        centre, half = shapes.boxes.centre[i], shapes.boxes.half[i]
        furthest, turned = np.abs(centre) + half, spread.turned
        ways = np.array(
            [
                spread.along + turned * furthest[1] + turned**2 / 2 * furthest[0],
                spread.across + turned * furthest[0] + turned**2 / 2 * furthest[1],
            ]
        )
        shrunk = np.minimum(ways, half[:, None])
        rest = np.minimum(np.hypot(*(ways - shrunk)), spread.moved + turned * math.hypot(*furthest))
        found = _box_interval(_placed(pose, centre), half[:, None] - shrunk, _one(walls.boxes, i).opened(rest))
        low, high = np.maximum(low, found.low), np.minimum(high, found.high)
    for i in np.flatnonzero(shapes.discs.link == link).tolist():
        centre, radius = shapes.discs.centre[i], float(shapes.discs.radius[i])
        distance = spread.moved + spread.turned * math.hypot(*centre)  # turning a disc about its middle changes nothing
        shrunk = min(distance, radius)
        seen = _one(walls.discs, i).opened(distance - shrunk)
        at = _placed(pose, centre)
        low = np.maximum(low, _boundary(seen.inner, seen.turn, radius - shrunk, at.y) - at.x)
        high = np.minimum(high, _boundary(seen.outer, seen.turn, shrunk - radius, at.y) - at.x)
    return Interval(low, high)


def _one(walls: CornerWalls, i: int) -> CornerWalls:
    """Walls that one part sees."""
    return CornerWalls(walls.turn, Wedge(*(v[i] for v in walls.inner)), Wedge(*(v[i] for v in walls.outer)))


def _placed(pose: _Pose, centre: Floats) -> _Pose:
    """The pose with a part's middle in place of the link's rear end."""
    x, y = centre.tolist()
    return pose._replace(x=pose.x + x * pose.cos - y * pose.sin, y=pose.y + x * pose.sin + y * pose.cos)


def _boundary(wedge: Wedge, turn: float, grown: float, y: Floats) -> Floats:
    """x at which a line along the first leg meets a wedge's boundary; -inf where it passes the wedge by, (n,) [m].

    Args:
        wedge: the wedge, numbers or (n,).
        turn: change of heading at the corner [rad].
        grown: distance by which the wedge is grown; negative for one that is eroded [m].
        y: height of the line, (n,) [m].
    """
    radius, sin, cos = wedge.radius + grown, math.sin(turn), math.cos(turn)
    dy = y - wedge.y
    x = (radius + cos * dy) / sin
    if (radius > 0).any():
        on_arc = (radius > 0) & (dy <= -radius * cos)
        x = np.where(on_arc, np.sqrt(np.maximum(radius**2 - dy**2, 0.0)), x)
    return np.asarray(np.where(dy < -radius - TOUCH, -np.inf, wedge.x + x))


def _box_interval(pose: _Pose, half: Floats, walls: CornerWalls) -> Interval:
    """Free slides of a box.

    Outside: the box lies in the convex outer region if its vertices do. Inside: the distance from the box to the inner
    wall's boundary along x is concave on each side of the box, so that its extremes lie at vertices, where a side
    enters the wall's range of y, or where a side is tangent to the wall's rounding.
    """
    n = len(pose.x)
    along = np.array([half[0] * pose.cos, half[0] * pose.sin])
    across = np.array([-half[1] * pose.sin, half[1] * pose.cos])
    at = np.array([pose.x, pose.y])
    corners = [at + along + across, at - along + across, at - along - across, at + along - across]
    low, high = np.full(n, -np.inf), np.full(n, np.inf)
    for x, y in corners:
        high = np.minimum(high, _boundary(walls.outer, walls.turn, 0.0, y) - x)
        low = np.maximum(low, _boundary(walls.inner, walls.turn, 0.0, y) - x)
    bottom = walls.inner.y - walls.inner.radius
    directions = ((pose.cos, pose.sin), (-pose.sin, pose.cos))
    for side in range(4):
        levels = [np.broadcast_to(bottom, n)]
        if (walls.inner.radius > 0).any():
            levels.append(_tangent_level(walls, *directions[side % 2]))
        for level in levels:
            low = np.maximum(low, _crossing(walls, corners[side], corners[(side + 1) % 4], level))
    return Interval(low, high)


def _tangent_level(walls: CornerWalls, cos: Floats, sin: Floats) -> Floats:
    """y at which a side of this direction touches the inner wall's rounding; its bottom where it does not, (n,) [m]."""
    upwards = np.where(sin < 0, -cos, cos)
    touches = (upwards >= math.cos(walls.turn)) & (np.abs(sin) > TANGENT)
    return np.asarray(walls.inner.y - walls.inner.radius * np.where(touches, upwards, 1.0))


def _crossing(walls: CornerWalls, start: Floats, end: Floats, level: Floats) -> Floats:
    """Slide at which the point of a side at some y lies on the inner wall's boundary; -inf where it has none, (n,)."""
    rise = end[1] - start[1]
    share = (level - start[1]) / np.where(np.abs(rise) > TANGENT, rise, np.inf)
    x = start[0] + share * (end[0] - start[0])
    meets = (share >= 0) & (share <= 1) & (np.abs(rise) > TANGENT)
    return np.asarray(np.where(meets, _boundary(walls.inner, walls.turn, 0.0, level) - x, -np.inf))
