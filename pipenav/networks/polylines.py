"""Lines without nodes, as geographic programs keep them: ends that lie close to each other become one node.

An end that lies on the inside of another line is a tee that nobody drew a node for: the other line is cut there.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Container, Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.errors import ConfigError
from pipenav.networks.draft import LineFacts, MapDraft, Point
from pipenav.networks.fields import ReadOptions
from pipenav.networks.model import NetworkMap
from pipenav.networks.units import FOOT, metres_per_degree

CELL = 25.0
"""Width of the cells in which segments near a point are looked up [m]."""

MOST_CELLS = 4000
"""Most cells that one segment is entered into: 100 km of it."""


ROUNDING = 1e-3
"""Distance that rounding stays below in coordinates of up to a million kilometres [m]."""


class PolyLine(NamedTuple):
    """A line of a file: its name, its points in the file's unit, its facts and its place in words."""

    name: str
    points: list[Point]
    facts: LineFacts
    place: str


def joined_map(draft: MapDraft, lines: Sequence[PolyLine], options: ReadOptions, degrees: bool) -> NetworkMap:
    """The map of lines that carry no nodes.

    Args:
        draft: an empty draft.
        lines: the lines.
        options: how close ends are to be, and the unit of the coordinates.
        degrees: whether the format says that coordinates are degrees where nothing else is known.

    Raises:
        ConfigError: coordinates whose unit cannot be told, or lines without two points.
    """
    if not lines:
        raise ConfigError(f"{draft.file} has no lines in it: give a file with the pipes as lines.")
    for line in lines:
        if len(line.points) < 2:
            raise draft.refuse(line.place, "a line needs two points or more: add them, or remove the line.")
        for point in line.points:
            draft.check_point(point, line.place)
    made = _cleaned(draft, _in_metres(draft, lines, options, degrees), options.snap)
    made = _cut_at_tees(draft, made, options.snap)
    numbers = _Nodes(draft, options.snap)
    for line in made:
        ends = (numbers.at(line.points[0], line.place), numbers.at(line.points[-1], line.place))
        if ends[0] == ends[1] and len(line.points) == 2:
            draft.note("short", "info", "lines shorter than --snap were left out", line.name)
            continue
        draft.line(line.name, ends, line.facts, line.points[1:-1], line.place)
    return draft.finish()


def _in_metres(draft: MapDraft, lines: Sequence[PolyLine], options: ReadOptions, degrees: bool) -> Sequence[PolyLine]:
    xy = np.array([(x, y) for line in lines for x, y, _ in line.points])
    like_degrees = bool((np.abs(xy) <= [180.0, 90.0]).all())
    unit = options.coordinates
    if unit == "auto":
        unit = "lonlat" if degrees and like_degrees else "m"
        if unit == "m" and like_degrees and (np.ptp(xy, axis=0) < 2.0).all():
            raise ConfigError(
                f"{draft.file} has coordinates that look like degrees of longitude and latitude: give --coordinates "
                "lonlat if they are, or --coordinates m."
            )
    if unit == "m":
        return lines
    if unit == "ft":
        return [line._replace(points=[_scaled(p, FOOT, FOOT, FOOT) for p in line.points]) for line in lines]
    if not like_degrees:
        raise ConfigError(f"{draft.file} has coordinates beyond 180 and 90 deg: give --coordinates m.")
    middle = xy.mean(axis=0)
    east, north = metres_per_degree(float(middle[1]))
    draft.note("projected", "info", "longitude and latitude were projected to metres about the middle", draft.file)
    return [
        line._replace(points=[_scaled((x - middle[0], y - middle[1], z), east, north, 1.0) for x, y, z in line.points])
        for line in lines
    ]


def _scaled(point: Point, x: float, y: float, z: float) -> Point:
    return (float(point[0] * x), float(point[1] * y), None if point[2] is None else point[2] * z)


def _cleaned(draft: MapDraft, lines: Iterable[PolyLine], snap: float) -> list[PolyLine]:
    """Lines without points that repeat the one before; a line of no length is left out."""
    kept = []
    for line in lines:
        points = [line.points[0]]
        points += [
            new for old, new in zip(line.points, line.points[1:], strict=False) if new[:2] != old[:2] or _up(old, new)
        ]
        if len(points) < 2:
            draft.note("short", "info", f"lines shorter than {snap:g} m were left out", line.name)
        else:
            kept.append(line._replace(points=points))
    return kept


def _up(old: Point, new: Point) -> bool:
    return old[2] is not None and new[2] is not None and old[2] != new[2]


class _Nodes:
    """Nodes by their places: a point within `snap` of an earlier node is that node."""

    def __init__(self, draft: MapDraft, snap: float) -> None:
        self._draft, self._snap = draft, snap
        self._cell = max(snap, 1e-6)
        self._cells: dict[tuple[int, int], list[tuple[Point, int]]] = defaultdict(list)

    def at(self, point: Point, place: str) -> int:
        """Number of the node at a point."""
        column, row = (math.floor(value / self._cell) for value in point[:2])
        for i in (column - 1, column, column + 1):
            for j in (row - 1, row, row + 1):
                for other, node in self._cells.get((i, j), ()):
                    if _distance(point, other) <= self._snap:
                        return node
        name = f"node {len(self._draft.nodes) + 1}"
        node = self._draft.node(name, point, place)
        self._cells[(column, row)].append((point, node))
        return node


def _distance(one: Point, other: Point) -> float:
    up = 0.0 if one[2] is None or other[2] is None else one[2] - other[2]
    return math.hypot(one[0] - other[0], one[1] - other[1], up)


def _cut_at_tees(draft: MapDraft, lines: list[PolyLine], snap: float) -> list[PolyLine]:
    """Lines cut where the end of another one lies on them."""
    cuts: dict[int, list[tuple[int, float, Point]]] = defaultdict(list)
    for found in ends_on_lines([line.points for line in lines], snap):
        cuts[found.line].append((found.segment, found.share, found.end))
        name = lines[found.other].name
        draft.note("tee-without-node", "assumed", "ends inside other lines were taken for tees", name)
    return [part for i, line in enumerate(lines) for part in (_parts(line, cuts[i]) if i in cuts else [line])]


class EndOnLine(NamedTuple):
    """An end of a line that lies on the inside of another one.

    Attributes:
        line: number of the line that it lies on.
        segment: segment of that line, counted from 0.
        share: share of the segment's length at which it lies.
        end: the end.
        other: number of the line that ends there.
    """

    line: int
    segment: int
    share: float
    end: Point
    other: int


def ends_on_lines(
    lines: Sequence[Sequence[Point]], snap: float, among: Container[Point] | None = None
) -> list[EndOnLine]:
    """Ends of lines within a distance of the inside of another line, which has no end there.

    Args:
        lines: points of the lines.
        snap: the distance [m].
        among: ends that are looked at; None for all.
    """
    near = snap + ROUNDING
    cells: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
    for i, points in enumerate(lines):
        for j, (a, b) in enumerate(pairwise(points)):
            for cell in _crossed(a, b):
                cells[cell].append((i, j))
    found = []
    for i, points in enumerate(lines):
        for end in (points[0], points[-1]):
            if among is not None and end not in among:
                continue
            x, y = end[:2]
            for other, segment in cells.get((math.floor(x / CELL), math.floor(y / CELL)), ()):
                (x1, y1, _), (x2, y2, _) = lines[other][segment : segment + 2]
                beside = x < min(x1, x2) - near or x > max(x1, x2) + near
                if beside or y < min(y1, y2) - near or y > max(y1, y2) + near:
                    continue  # most are: told apart at once
                if other != i and (share := _on_inside(lines[other], segment, end, snap)) is not None:
                    found.append(EndOnLine(other, segment, share, end, i))
    return found


def _crossed(a: Point, b: Point) -> list[tuple[int, int]]:
    """Cells that a segment passes or lies next to."""
    steps = min(int(math.hypot(b[0] - a[0], b[1] - a[1]) / (CELL / 2)) + 1, MOST_CELLS)
    near = set()
    for step in range(steps + 1):
        share = step / steps
        x, y = a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share
        column, row = math.floor(x / CELL), math.floor(y / CELL)
        near |= {(column + i, row + j) for i in (-1, 0, 1) for j in (-1, 0, 1)}
    return list(near)


def _on_inside(points: Sequence[Point], segment: int, end: Point, snap: float) -> float | None:
    """Share of a segment at which an end lies on it; None where it is not near, or near an end of the line."""
    a, b = points[segment : segment + 2]
    if min(_distance(end, points[0]), _distance(end, points[-1])) <= snap:
        return None
    dx, dy = b[0] - a[0], b[1] - a[1]
    long = dx * dx + dy * dy
    if long == 0:
        return None
    share = min(max(((end[0] - a[0]) * dx + (end[1] - a[1]) * dy) / long, 0.0), 1.0)
    low, high = a[2], b[2]
    up = None if low is None or high is None else low + share * (high - low)
    return share if _distance(end, (a[0] + share * dx, a[1] + share * dy, up)) <= snap else None


def _parts(line: PolyLine, cuts: list[tuple[int, float, Point]]) -> list[PolyLine]:
    """A line cut at some points, each part with a name of its own."""
    parts, points, done = [], [line.points[0]], 0
    cut_at: Floats = np.zeros(0)
    for segment, _, at in sorted(set(cuts), key=lambda cut: cut[:2]):
        points += line.points[done + 1 : segment + 1]
        done = segment
        if len(cut_at) and tuple(cut_at) == at[:2]:
            continue
        cut_at = np.array(at[:2])
        parts.append([*points, at])
        points = [at]
    parts.append([*points, *line.points[done + 1 :]])
    whole = [part for part in parts if len(part) > 1]
    return [line._replace(name=f"{line.name}.{k}", points=part) for k, part in enumerate(whole, 1)]
