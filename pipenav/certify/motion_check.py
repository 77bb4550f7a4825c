"""Two independent tests that a motion touches no wall: distances with a bound between samples, and shapely.

Neither uses the formulas by which motions are found. A motion is a polyline of configurations, straight in the joints'
coordinates from one to the next.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.certify.corner_walls import width_seen
from pipenav.certify.model import Model
from pipenav.certify.shapes import Shapes, shapes_of
from pipenav.robots import kinematics

FINEST = 2e-5
"""Least distance that parts move between two samples [m]: where they are nearer to a wall, the motion is refused."""

GROWN = 1e-4
"""Distance by which parts are grown in the test by shapely, so that samples stand for what is between them [m]."""

ROUND_POINTS = 48
"""Corners of the polygon around a disc in the test by shapely."""

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
    if not _inside(model, shapes, walls, q[:1], base):
        return Checked(False, 0.0, 0)
    place = np.arange(len(q), dtype=float)
    clear = _clearance(model, shapes, walls, q, base)
    ends = np.stack([place[:-1], place[1:]], axis=1)
    near = np.stack([clear[:-1], clear[1:]], axis=1)
    least = int(clear.argmin())
    worst = Checked(True, float(clear[least]), min(least, len(q) - 2))
    while len(ends):
        moved = _moved(model, _at(q, ends[:, 0]), _at(q, ends[:, 1]))
        open_ = near.sum(axis=1) <= moved
        if ((moved < FINEST) & open_).any() or (near[open_] <= 0).any():
            at = int(np.where(open_, near.min(axis=1), np.inf).argmin())
            return Checked(False, float(near[at].min()), int(ends[at, 0]))
        ends, near = ends[open_], near[open_]
        if not len(ends):
            break
        middle = ends.mean(axis=1)
        clear = _clearance(model, shapes, walls, _at(q, middle), base)
        if clear.min() < worst.clearance:
            worst = Checked(True, float(clear.min()), int(middle[clear.argmin()]))
        ends = np.concatenate([np.stack([ends[:, 0], middle], 1), np.stack([middle, ends[:, 1]], 1)])
        near = np.concatenate([np.stack([near[:, 0], clear], 1), np.stack([clear, near[:, 1]], 1)])
    return worst


def clearances(model: Model, q: Floats, base: float) -> Floats:
    """Smallest distance of any part to any wall in each of n configurations, (n,) [m]."""
    shapes, length = model.shapes(proof=True), reach_of(model, q, base)
    walls = {height: walls_seen(model, height, length) for height in _heights(shapes)}
    return _clearance(model, shapes, walls, q, base)


def check_by_shapely(model: Model, q: Floats, base: float) -> Checked:
    """Whether the pipe as a polygon holds all parts, grown a little, at samples that are as near to each other."""
    import shapely

    shapes = model.shapes(proof=True).inflated(GROWN)
    length = reach_of(model, q, base)
    steps = np.ceil(_moved(model, q[:-1], q[1:]) / (2 * GROWN)).astype(int)
    place = np.concatenate([[0.0], *(i + np.arange(1, n + 1) / n for i, n in enumerate(steps.tolist()) if n)])
    points, headings = poses(model, _at(q, place), base)
    regions = {h: shapely.Polygon(walls_seen(model, h, length).outline) for h in _heights(shapes)}
    shapely.prepare(list(regions.values()))
    for rings, height in _outlines(shapes, points, headings):
        held = shapely.contains_properly(regions[height], shapely.polygons(rings))
        if not held.all():
            return Checked(False, 0.0, int(place[int(np.argmin(held))]))
    return Checked(True, GROWN, 0)


def _heights(shapes: Shapes) -> list[float]:
    return sorted({*shapes.boxes.height.tolist(), *shapes.discs.height.tolist()})


def _at(q: Floats, place: Floats) -> Floats:
    """Configurations at places along a polyline, (n, coordinates); the integer part of a place is its waypoint."""
    row = np.minimum(place.astype(int), len(q) - 2)
    share = (place - row)[:, None]
    return np.asarray(q[row] + share * (q[row + 1] - q[row]))


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
    for rings, height in _outlines(shapes, points, headings):
        middle = rings[0].mean(axis=0)
        if not shapely.contains_xy(shapely.Polygon(walls[height].outline), *middle):
            return False
    return True


def _outlines(shapes: Shapes, points: Floats, headings: Floats) -> list[tuple[Floats, float]]:
    """Corners of every part in n poses, (n, corners, 2) [m], and its height; a disc is inside of its polygon."""
    found = []
    phi = (np.arange(ROUND_POINTS) + 0.5) * 2 * math.pi / ROUND_POINTS
    ring = np.stack([np.cos(phi), np.sin(phi)], axis=1) / math.cos(math.pi / ROUND_POINTS)
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    boxes, discs = shapes.boxes, shapes.discs
    parts = [*zip(boxes.link, boxes.centre, boxes.half[:, None] * square, boxes.height, strict=True)]
    parts += [*zip(discs.link, discs.centre, discs.radius[:, None, None] * ring, discs.height, strict=True)]
    for link, centre, corners, height in parts:
        cos, sin = np.cos(headings[:, link]), np.sin(headings[:, link])
        x, y = (centre + corners).T
        turned = np.stack([np.outer(cos, x) - np.outer(sin, y), np.outer(sin, x) + np.outer(cos, y)], axis=-1)
        found.append((points[:, link, None] + turned, float(height)))
    return found


def _clearance(model: Model, shapes: Shapes, walls: dict[float, _Walls], q: Floats, base: float) -> Floats:
    """Smallest distance of any part to any wall, (n,) [m]; 0 or less where they meet."""
    points, headings = poses(model, q, base)
    least = np.full(len(q), np.inf)
    boxes, discs = shapes.boxes, shapes.discs
    for link, centre, radius, height in zip(*discs, strict=True):
        middle = _placed(points[:, link], headings[:, link], centre)
        least = np.minimum(least, _to_segments(middle, walls[float(height)].segments) - radius)
    for link, centre, half, height in zip(*boxes, strict=True):
        cos, sin = np.cos(headings[:, link]), np.sin(headings[:, link])
        middle = _placed(points[:, link], headings[:, link], centre)
        ends = walls[float(height)].segments - middle[:, None, None]  # (n, s, 2, 2), then in the box's own frame
        x = ends[..., 0] * cos[:, None, None] + ends[..., 1] * sin[:, None, None]
        y = ends[..., 1] * cos[:, None, None] - ends[..., 0] * sin[:, None, None]
        least = np.minimum(least, _box_to_segments(np.stack([x, y], axis=-1), half))
    return least


def _placed(points: Floats, headings: Floats, centre: Floats) -> Floats:
    cos, sin = np.cos(headings), np.sin(headings)
    x, y = centre
    return np.asarray(points + np.stack([x * cos - y * sin, x * sin + y * cos], axis=-1))


def _to_segments(points: Floats, segments: Floats) -> Floats:
    """Smallest distance of points, (n, 2), to segments, (s, 2, 2): (n,) [m]."""
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    away = points[:, None] - start
    share = np.clip((away * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
    return np.asarray(np.hypot(*np.moveaxis(away - share[..., None] * along, -1, 0)).min(axis=1))


def _box_to_segments(segments: Floats, half: Floats) -> Floats:
    """Smallest distance of a box about the origin to segments, (n, s, 2, 2): (n,) [m]; 0 where one enters it.

    The two are nearest at an end of the segment or at a corner of the box, unless they meet.
    """
    ends = np.maximum(np.abs(segments) - half, 0.0)
    least = np.hypot(ends[..., 0], ends[..., 1]).min(axis=2)  # (n, s)
    start, along = segments[..., 0, :], segments[..., 1, :] - segments[..., 0, :]
    for corner in np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * half:
        away = corner - start
        share = np.clip((away * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
        gap = away - share[..., None] * along
        least = np.minimum(least, np.hypot(gap[..., 0], gap[..., 1]))
    # A segment meets the box where its stretches inside of the two pairs of sides have something in common.
    with np.errstate(divide="ignore", invalid="ignore"):
        bounds = np.sort(np.stack([(-half - start) / along, (half - start) / along]), axis=0)
    parallel = np.abs(along) < 1e-15
    within = np.abs(start) <= half
    enter = np.where(parallel, np.where(within, -np.inf, np.inf), bounds[0]).max(axis=-1)
    leave = np.where(parallel, np.where(within, np.inf, -np.inf), bounds[1]).min(axis=-1)
    meets = np.maximum(enter, 0.0) <= np.minimum(leave, 1.0)
    return np.asarray(np.where(meets, 0.0, least).min(axis=1))
