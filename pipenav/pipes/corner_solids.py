"""A corner as solids: meshes of its boards and of its tube, and its walls as boxes.

Simulators collide a concave mesh as its convex hull, so scenes are made of boxes. Each has one face flush with its
wall segment and lies in the wall's material entirely: nothing stands out into free space, however sharp the corner.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Floats
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_lines import ARC_TOLERANCE
from pipenav.units import m_to_mm

MESH_GRID_MM = 1e-3
"""Grid to which mesh points are rounded [mm]: the 32-bit numbers of an STL must not part or join them by chance."""

THINNING = 8.0
"""Ratio of the thicknesses of two neighbouring boxes towards a sharp inner edge."""

EDGE_TOLERANCE = 5e-5
"""Length [m] at the very tip of a sharp inner edge that no box needs to fill."""

OVERLAP = 2e-3
"""Least length by which neighbouring boxes overlap, where they can [m]: Bullet rounds every box by 1 mm."""

Faces = NDArray[np.int64]


class Mesh(NamedTuple):
    """A closed surface in MILLIMETRES: vertices (v, 3) and triangles (f, 3), counter-clockwise seen from outside."""

    vertices: Floats
    faces: Faces


class Box(NamedTuple):
    """A part of a wall, as high as the pipe, centred on the pipe's plane: position and size [m], yaw [rad]."""

    name: str
    x: float
    y: float
    yaw: float
    length: float
    thickness: float


class Stair(NamedTuple):
    """Thickness that a box may have on a part of a face, from low to high along it [m]."""

    low: float
    high: float
    thickness: float


def boards_mesh(pipe: PipeCorner) -> Mesh:
    """The two boards: the inner and the outer wall, as high as the diameter."""
    chords = _chords(pipe)
    boards = [
        (pipe.line(near, chords), pipe.line(near + pipe.wall, chords))
        for near in (pipe.radius, -pipe.radius - pipe.wall)
    ]
    return boards_between(boards, pipe.radius, mirrored=pipe.turn == "right")


def tube_mesh(pipe: PipeCorner) -> Mesh:
    """The hollow tube: every generator, at offset r cos(phi) and height r sin(phi), is a line along the pipe."""
    chords, outside = _chords(pipe), pipe.radius + pipe.wall
    inner, outer = (
        np.stack([at_height(pipe.line(r * math.cos(phi), chords), r * math.sin(phi)) for phi in round_angles(outside)])
        for r in (pipe.radius, outside)
    )
    return tube_between(inner, outer, mirrored=pipe.turn == "right")


def boards_between(boards: list[tuple[Floats, Floats]], half_height: float, mirrored: bool = False) -> Mesh:
    """Boards that stand on the plane's lower side, half above and half below it.

    Args:
        boards: right and left side of each board, seen along the pipe, points (k, 2) [m].
        half_height: half of the boards' height [m].
        mirrored: whether right and left are exchanged.
    """
    caps = np.array([[0, 1, 2], [0, 2, 3]])
    points: list[Floats] = []
    triangles: list[Faces] = []
    for near, far in boards:
        # Around a board's section: near side below, near above, far above, far below.
        ring = [at_height(side, z * half_height) for side, z in ((near, -1), (near, 1), (far, 1), (far, -1))]
        grid = np.stack(ring, axis=1)  # (stations, 4, 3)
        faces = [_grid_faces(len(grid), 4, closed=False), caps, 4 * len(grid) - 4 + caps[:, ::-1]]
        triangles.append(np.concatenate(faces) + sum(map(len, points)))
        points.append(grid.reshape(-1, 3))
    return mesh_of(np.concatenate(points), np.concatenate(triangles), mirrored)


def tube_between(inner: Floats, outer: Floats, mirrored: bool = False) -> Mesh:
    """The tube between two surfaces, with both ends open.

    Args:
        inner, outer: lines along the surfaces, in order around them from left upwards, (lines, stations, 3) [m].
        mirrored: whether right and left are exchanged.
    """
    # A ring goes along the inner surface and back along the outer one, which closes the ends of the wall.
    grid = np.concatenate([inner, outer[:, ::-1]], axis=1).swapaxes(0, 1)  # (2 stations, lines, 3)
    return mesh_of(grid.reshape(-1, 3), _grid_faces(len(grid), len(inner), closed=True), mirrored)


def round_angles(radius: float) -> Floats:
    """Angles of lines that stand for a circle of a radius [m], within half the tolerance of arcs, (lines,) [rad]."""
    count = 4 * math.ceil(math.pi / 4 / math.acos(1 - ARC_TOLERANCE / 2 / radius))
    return np.asarray(np.arange(count) * (2 * math.pi / count))


def at_height(line: Floats, z: float) -> Floats:
    """Points (k, 2) of the plane, raised to a height, (k, 3)."""
    return np.column_stack([line, np.full(len(line), z)])


def corner_boxes(pipe: PipeCorner) -> list[Box]:
    """The walls as boxes; only the last `EDGE_TOLERANCE` of a sharp inner edge stays unfilled."""
    count = len(pipe.walls.outer) - 1
    order = 1 if pipe.turn == "left" else -1  # segments have the pipe on their left: those of a right turn run back
    outer, inner = pipe.segments[:count][::order], pipe.segments[count:][::order]
    if pipe.angle == math.pi:
        outer, inner = (np.array([[chain[0, 0], chain[-1, 1]]]) for chain in (outer, inner))
    return _outer_boxes(outer, pipe.wall) + _inner_boxes(inner, pipe.wall)


def _chords(pipe: PipeCorner) -> int:
    """Number of chords for every arc of a mesh: twice that of the largest arc, for a quarter of the tolerance."""
    return 2 * (len(pipe.line(-pipe.radius - pipe.wall)) - 3)


def _grid_faces(rows: int, columns: int, closed: bool) -> Faces:
    """Triangles of a grid of points that is closed across its columns and, if asked, across its rows too."""
    a = np.arange(rows * columns).reshape(rows, columns)
    b = np.roll(a, -1, axis=0)
    if not closed:
        a, b = a[:-1], b[:-1]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    return np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))])


def mesh_of(points: Floats, triangles: Faces, mirrored: bool) -> Mesh:
    """The mesh of points (p, 3) [m] and triangles (t, 3); points that coincide, as along an arc without radius, merge.

    Args:
        points: points [m].
        triangles: indices of the corners, counter-clockwise seen from outside.
        mirrored: whether right and left are exchanged, which turns the triangles round.
    """
    rounded = np.round(m_to_mm(1.0) * points / MESH_GRID_MM) * MESH_GRID_MM
    vertices, index = np.unique(rounded.astype(np.float32) + 0.0, axis=0, return_inverse=True)
    faces = index.reshape(-1)[triangles]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    return Mesh(vertices.astype(float), faces[:, ::-1] if mirrored else faces)


def _outer_boxes(chain: Floats, wall: float) -> list[Box]:
    """Boxes behind a chain of segments (s, 2, 2) that bends towards free space, lengthened to close the outside."""
    along, length = _steps(chain)
    cosine = np.sum(along[:-1] * along[1:], axis=1)
    mitre = np.maximum(wall * np.minimum(np.sqrt((1 - cosine) / (1 + cosine)), 1.0), OVERLAP)
    before, after = np.append(0.0, mitre), np.append(mitre, 0.0)
    stairs = [Stair(-before[i], length[i] + after[i], wall) for i in range(len(chain))]
    return [_box(f"outer_{i}", chain[i, 0], along[i], stair) for i, stair in enumerate(stairs)]


def _inner_boxes(chain: Floats, wall: float) -> list[Box]:
    """Boxes behind a chain of segments (s, 2, 2) that bends away from free space.

    A box as thick as the wall would come out on the other side of a sharp edge. So where the material thins out, a
    staircase of ever thinner boxes follows the face.
    """
    along, length = _steps(chain)
    boxes: list[Box] = []
    for start, direction, reach in zip(chain[:, 0], along, length, strict=True):
        for stair in _stairs(start, direction, reach, chain[:, 0], along, wall):
            boxes.append(_box(f"inner_{len(boxes)}", start, direction, stair))
    return boxes


def _stairs(
    start: Floats, direction: Floats, length: float, points: Floats, along: Floats, wall: float
) -> Iterator[Stair]:
    """The stairs on one face, thickest first.

    The material is convex: all that lies to the right of the lines through `points` (s, 2) along `along` (s, 2).
    """
    slope = _right(along) @ direction  # (s,) depth in the material gained per metre along the face
    done: Stair | None = None
    for step in range(10):
        thickness = wall / THINNING**step
        depth = np.sum((start + thickness * _right(direction) - points) * _right(along), axis=1)  # (s,) at the start
        rising, falling = slope > 1e-9, slope < -1e-9
        low = max([0.0, *(-depth[rising] / slope[rising])])
        high = min([length, *(-depth[falling] / slope[falling])])
        if low >= high:
            continue
        if done is None:
            done = Stair(low, high, thickness)
            yield done
        else:
            yield from (
                s for s in (Stair(low, done.low, thickness), Stair(done.high, high, thickness)) if s.low < s.high
            )
            done = Stair(low, high, thickness)
        if low < EDGE_TOLERANCE and high > length - EDGE_TOLERANCE:
            return


class _Steps(NamedTuple):
    """Unit vectors (s, 2) and lengths (s,) [m] of segments."""

    along: Floats
    length: Floats


def _steps(chain: Floats) -> _Steps:
    """Directions and lengths of segments (s, 2, 2)."""
    step = chain[:, 1] - chain[:, 0]
    length = np.linalg.norm(step, axis=1)
    return _Steps(step / length[:, None], length)


def _right(direction: Floats) -> Floats:
    """The right-hand normals of unit vectors (..., 2): for a wall segment, into the material."""
    return np.stack([direction[..., 1], -direction[..., 0]], axis=-1)


def _box(name: str, start: Floats, direction: Floats, stair: Stair) -> Box:
    x, y = start + direction * (stair.low + stair.high) / 2 + _right(direction) * stair.thickness / 2
    yaw = math.atan2(direction[1], direction[0])
    return Box(name, float(x), float(y), yaw, float(stair.high - stair.low), stair.thickness)
