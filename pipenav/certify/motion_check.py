"""Two independent tests that a motion touches no wall: distances with a bound between samples, and shapely.

Neither uses the formulas by which motions are found. A motion is a polyline of configurations, straight in the joints'
coordinates from one to the next.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Self

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.certify.corner_walls import width_seen
from pipenav.certify.model import Model
from pipenav.certify.shapes import Shapes, shapes_of
from pipenav.certify.wall_distance import SQUARE, box_to_segments, placed, to_segments
from pipenav.robots import kinematics

FINEST = 2e-5
"""Least distance that parts move between two samples [m]: where they are nearer to a wall, the motion is refused."""

FIRST = 1.6e-2
"""Distance that parts move at most between the first samples of the test by distances [m]."""

GROWN = (3.2e-3, 8e-4, 2e-4, 1e-4)
"""Distances by which parts are grown in the test by shapely, so that samples stand for what is around them [m]."""

AROUND = 3.0
"""Length of the legs beyond the motion's reach in the test by shapely, in robot lengths."""


class Checked(NamedTuple):
    """Result of a test of a motion.

    Attributes:
        free: whether no part touches a wall.
        clearance: smallest distance of a part to a wall that was seen, negative inside of it [m].
        row: waypoint before the place where it was seen.
    """

    free: bool
    clearance: float
    row: int


class _Walls(NamedTuple):
    """Wall segments that parts of one height see, (s, 2, 2) [m] in the canonical frame, and the pipe as a polygon."""

    segments: Floats
    outline: Floats


def walls_seen(model: Model, height: float, length: float) -> _Walls:
    """Walls of a corner with legs of at least some length, for parts of a height [m]."""
    pipe = model.pipe
    half = float(width_seen(pipe.diameter, height, model.bore)) / 2
    long = pipe.model_copy(update={"leg": length, "turn": "left", "branches": ()})
    outer, inner = long.line(-half), long.line(half)
    segments = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in (outer, inner)])
    return _Walls(segments, np.concatenate([outer, inner[::-1]]))


def poses(model: Model, q: Floats, base: float) -> tuple[Floats, Floats]:
    """Rear ends, (n, links, 2) [m], and headings, (n, links) [rad], of links in the canonical frame of the pipe.

    Args:
        model: what is certified.
        q: configurations in the robot's own frame, (n, coordinates).
        base: x of that frame in the pipe's frame [m].
    """
    found = kinematics.forward(model.robot, q)
    sign = model.pipe.turn_sign
    return found.joints * [1.0, sign] + [base, 0.0], found.headings * sign


def reach_of(model: Model, q: Floats, base: float) -> float:
    """Length of legs in which the whole motion lies, with room to spare [m]."""
    points = poses(model, q, base)[0]
    return float(np.abs(points).max()) * 2 + AROUND * model.robot.length + model.pipe.leg


def check_by_distance(model: Model, q: Floats, base: float) -> Checked:
    """Distances of all parts to all walls, sampled so finely that nothing can touch between two samples.

    Between two samples no point moves further than a bound; where the distances at both add up to more than it, the
    stretch is free. Others are halved.
    """
    shapes = model.shapes(proof=True)
    length = reach_of(model, q, base)
    walls = {height: walls_seen(model, height, length) for height in _heights(shapes)}
    way = _Way.of(model, q)
    if not _inside(model, shapes, walls, q[:1], base):
        return Checked(False, 0.0, 0)
    place = np.linspace(0.0, way.length, math.ceil(way.length / FIRST) + 2)
    clear = _clearance(model, shapes, walls, way.at(place), base)
    ends = np.stack([place[:-1], place[1:]], axis=1)
    near = np.stack([clear[:-1], clear[1:]], axis=1)
    worst = Checked(True, float(clear.min()), way.row(float(place[clear.argmin()])))
    while True:
        moved = ends[:, 1] - ends[:, 0]
        open_ = near.sum(axis=1) <= moved
        if ((moved < FINEST) & open_).any() or (near[open_] <= 0).any():
            at = int(np.where(open_, near.min(axis=1), np.inf).argmin())
            return Checked(False, float(near[at].min()), way.row(float(ends[at, 0])))
        ends, near = ends[open_], near[open_]
        if not len(ends):
            return worst
        middle = ends.mean(axis=1)
        clear = _clearance(model, shapes, walls, way.at(middle), base)
        if clear.min() < worst.clearance:
            worst = Checked(True, float(clear.min()), way.row(float(middle[clear.argmin()])))
        ends = np.concatenate([np.stack([ends[:, 0], middle], 1), np.stack([middle, ends[:, 1]], 1)])
        near = np.concatenate([np.stack([near[:, 0], clear], 1), np.stack([clear, near[:, 1]], 1)])


def clearances(model: Model, q: Floats, base: float) -> Floats:
    """Smallest distance of any part to any wall in each of n configurations, (n,) [m]."""
    shapes, length = model.shapes(proof=True), reach_of(model, q, base)
    walls = {height: walls_seen(model, height, length) for height in _heights(shapes)}
    return _clearance(model, shapes, walls, q, base)


def check_by_shapely(model: Model, q: Floats, base: float) -> Checked:
    """Whether the pipe as a polygon holds all parts at samples, grown by as much as anything moves to the next one.

    Where the pipe does not hold the grown parts, samples are taken nearer to each other and parts are grown less.
    """
    import shapely

    shapes, way = model.shapes(proof=True), _Way.of(model, q)
    outlines = {h: walls_seen(model, h, reach_of(model, q, base)).outline for h in _heights(shapes)}
    regions = {h: _Region(shapely.Polygon(outline), shapely.LinearRing(outline)) for h, outline in outlines.items()}
    shapely.prepare([geometry for region in regions.values() for geometry in region])
    grown = min(GROWN[0], way.length + GROWN[-1])
    place = np.asarray((np.arange(math.ceil(way.length / (2 * grown)) + 1) + 0.5) * 2 * grown)
    for more in GROWN:
        if more > grown:
            continue
        if more < grown:  # the stretch around each sample in parts
            parts = math.ceil(grown / more - 1e-9)
            place = (place[:, None] + (2 * np.arange(parts) + 1 - parts) * more).ravel()
        grown = more
        place = place[_not_held(shapes.inflated(grown), regions, poses(model, way.at(place), base))]
        if not len(place):
            return Checked(True, grown, 0)
    return Checked(False, 0.0, way.row(float(place[0])))


class _Region(NamedTuple):
    """The pipe for parts of one height, in shapely's terms: as a polygon, and as its boundary."""

    polygon: Any
    boundary: Any


def _not_held(shapes: Shapes, regions: dict[float, _Region], at: tuple[Floats, Floats]) -> Ints:
    """Poses, of which a part is not inside of the pipe as shapely has it, as indices in order."""
    import shapely

    points, headings = at
    held = np.arange(len(points))
    for link, centre, radius, height in zip(*shapes.discs, strict=True):
        region = regions[float(height)]
        middle = shapely.points(placed(points[held, link], headings[held, link], centre))
        inside = shapely.contains(region.polygon, middle) & ~shapely.dwithin(region.boundary, middle, radius)
        held = held[inside]
    for link, centre, half, height in zip(*shapes.boxes, strict=True):
        rings = _rings(points[held, link], headings[held, link], centre + half * SQUARE)
        held = held[shapely.contains_properly(regions[float(height)].polygon, shapely.polygons(rings))]
    return np.setdiff1d(np.arange(len(points)), held)


class _Way(NamedTuple):
    """A motion with the distance that its points have moved at most.

    Attributes:
        q: waypoints, (rows, coordinates).
        moved: largest distance that a point of the robot has moved up to each waypoint, (rows,) [m].
    """

    q: Floats
    moved: Floats

    @classmethod
    def of(cls, model: Model, q: Floats) -> Self:
        """The way along the waypoints."""
        return cls(q, np.concatenate([[0.0], np.cumsum(_moved(model, q[:-1], q[1:]))]))

    @property
    def length(self) -> float:
        """Distance that is moved in all [m]."""
        return float(self.moved[-1])

    def at(self, place: Floats) -> Floats:
        """Configurations where points have moved by some distances, (n, coordinates)."""
        return np.stack([np.interp(place, self.moved, column) for column in self.q.T], axis=1)

    def row(self, place: float) -> int:
        """Waypoint before a place."""
        return int(np.clip(np.searchsorted(self.moved, place, "right") - 1, 0, max(len(self.q) - 2, 0)))


def _heights(shapes: Shapes) -> list[float]:
    return sorted({*shapes.boxes.height.tolist(), *shapes.discs.height.tolist()})


def _moved(model: Model, one: Floats, other: Floats) -> Floats:
    """Largest distance that a point of the robot moves on the straight way between two configurations, (n,) [m].

    Headings change evenly on that way. A link's rear end moves with the first link's, and by each change of a heading
    before it times that link's length; its points besides by its own change times their distance from it.
    """
    robot = model.robot
    change = np.abs(other - one)
    at = kinematics.forward(robot, one).headings, kinematics.forward(robot, other).headings
    turned = np.abs(at[1] - at[0])
    sliding = change[:, : len(robot.hinges)][:, ~robot.hinges].sum(axis=1)
    rear = np.hypot(change[:, 0], change[:, 1]) if robot.free else sliding
    largest = np.zeros(len(one))
    furthest = _furthest(shapes_of(robot))
    for link, length in enumerate(robot.lengths.tolist()):
        largest = np.maximum(largest, rear + turned[:, link] * furthest[link])
        rear = rear + turned[:, link] * length
    return largest


def _furthest(shapes: Shapes) -> Floats:
    """Largest distance of a link's points from its rear end, (links,) [m]."""
    largest = np.zeros(len(shapes.lengths))
    corners = np.hypot(*(np.abs(shapes.boxes.centre) + shapes.boxes.half).T)
    np.maximum.at(largest, shapes.boxes.link, corners)
    np.maximum.at(largest, shapes.discs.link, np.hypot(*shapes.discs.centre.T) + shapes.discs.radius)
    return largest


def _inside(model: Model, shapes: Shapes, walls: dict[float, _Walls], q: Floats, base: float) -> bool:
    """Whether the middle of every part lies in the pipe, in the first configuration."""
    import shapely

    points, headings = poses(model, q, base)
    parts = [*zip(shapes.boxes.link, shapes.boxes.centre, shapes.boxes.height, strict=True)]
    parts += [*zip(shapes.discs.link, shapes.discs.centre, shapes.discs.height, strict=True)]
    regions = {height: shapely.Polygon(seen.outline) for height, seen in walls.items()}
    middles = [(regions[float(height)], placed(points[:, link], headings[:, link], at)) for link, at, height in parts]
    return all(bool(shapely.contains_xy(region, *middle[0])) for region, middle in middles)


def _rings(points: Floats, headings: Floats, corners: Floats) -> Floats:
    """Corners of a box, (4, 2) in its link's frame, in n poses of the link: (n, 4, 2) [m]."""
    cos, sin, (x, y) = np.cos(headings), np.sin(headings), corners.T
    turned = np.stack([np.outer(cos, x) - np.outer(sin, y), np.outer(sin, x) + np.outer(cos, y)], axis=-1)
    return np.asarray(points[:, None] + turned)


def _clearance(model: Model, shapes: Shapes, walls: dict[float, _Walls], q: Floats, base: float) -> Floats:
    """Smallest distance of any part to any wall, (n,) [m]; 0 or less where they meet."""
    points, headings = poses(model, q, base)
    least = np.full(len(q), np.inf)
    boxes, discs = shapes.boxes, shapes.discs
    for link, centre, radius, height in zip(*discs, strict=True):
        middle = placed(points[:, link], headings[:, link], centre)
        least = np.minimum(least, to_segments(middle, walls[float(height)].segments) - radius)
    for link, centre, half, height in zip(*boxes, strict=True):
        cos, sin = np.cos(headings[:, link]), np.sin(headings[:, link])
        middle = placed(points[:, link], headings[:, link], centre)
        ends = walls[float(height)].segments - middle[:, None, None]  # (n, s, 2, 2), then in the box's own frame
        x = ends[..., 0] * cos[:, None, None] + ends[..., 1] * sin[:, None, None]
        y = ends[..., 1] * cos[:, None, None] - ends[..., 0] * sin[:, None, None]
        least = np.minimum(least, box_to_segments(np.stack([x, y], axis=-1), half))
    return least
