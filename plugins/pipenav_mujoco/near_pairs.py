"""Pairs of a robot's part and a piece of wall that can touch within a control period.

MuJoCo collides exactly the pairs that a model lists, so that it searches no trees of bounding boxes, which took half of
a physics step. A list holds every pair nearer than a slack to the way on which the robot is expected to move. As long
as no point strays further from its way, the contacts are those of all pairs, in the same order. A robot whose next way
lies in the one that was listed keeps its list.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints
from pipenav.robots import RobotSpec
from pipenav_mujoco.model import ROBOT, WALL
from pipenav_mujoco.ways import SLACK, Way

ROUNDING = 1e-5
"""Distance added to the slack in the search, which computes in single precision [m]."""

ROAM = 0.08
"""Distance from a robot's points up to which its neighbourhood reaches [m]; further for a way that needs it."""

NEIGHBOURS = 64
"""Pieces of wall that neighbourhoods have room for at first."""

Singles = NDArray[np.float32]
"""Array of single-precision numbers."""


class Parts(NamedTuple):
    """Parts of a robot that meet walls, g in number, each within a distance of a line between two of its points.

    Points are the rear end, the joints and the tip.

    Attributes:
        geom: geoms, ascending, (g,).
        body: bodies of the geoms, (g,).
        ends: points at the ends of the line, (2, g); both are the same for a wheel on a joint.
        reach: largest distance of the part from the line, (g,) [m].
        friction: coefficients of friction, (g,).
    """

    geom: Ints
    body: Ints
    ends: Ints
    reach: Floats
    friction: Floats

    @classmethod
    def of(cls, robot: RobotSpec, model: Any, front: str) -> Parts:
        """Parts of a robot by its model.

        Args:
            robot: robot with a roll joint.
            model: compiled model of the robot in a route.
            front: name of the body that is the front half of the divided link.
        """
        assert robot.roll is not None
        lines = {}
        for i, link in enumerate(robot.links):
            lines[link.name] = i, 0.0, link.length, i + 1
            if link.name == robot.roll.link:
                lines[front] = i, robot.roll.x, link.length, i + 1
            if link.wheel is not None:
                on_joint = link.wheel.x == 0
                lines[link.wheel.name] = i, link.wheel.x, 0.0 if on_joint else link.length, i if on_joint else i + 1
        geoms = np.flatnonzero(model.geom_contype == ROBOT)
        rows = []
        for geom in geoms:
            first, x, length, last = lines[model.body(model.geom_bodyid[geom]).name]
            rows.append((first, last, _reach(model, int(geom), x, length)))
        ends = np.array([row[:2] for row in rows]).T
        reach = np.array([row[2] for row in rows])
        friction = np.maximum(model.geom_friction[geoms, 0], robot.friction)  # the walls have the links'
        return cls(geoms, model.geom_bodyid[geoms].copy(), ends, reach, friction)


def _reach(model: Any, geom: int, x: float, length: float) -> float:
    """Largest distance of a geom [m] from the line of its link, in whose frame the geom's body stands at x [m]."""
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_SPHERE:
        corners, ball = np.zeros((1, 3)), float(model.geom_size[geom, 0])
    else:
        corners, ball = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3) * model.geom_size[geom], 0.0
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, model.geom_quat[geom])
    corners = model.geom_pos[geom] + corners @ turned.reshape(3, 3).T + [x, 0.0, 0.0]
    beside = corners[:, 0] - np.clip(corners[:, 0], 0.0, length)
    return float(np.sqrt(beside**2 + corners[:, 1] ** 2 + corners[:, 2] ** 2).max() + ball)


class _Boxes(NamedTuple):
    """Boxes, w in number; more dimensions may come before the ones named.

    Attributes:
        axes: axes of the boxes as columns, (3, 3 axes, w).
        middle: middles of the boxes along these axes, (3 axes, w) [m].
        half: half sizes of the boxes along them, (3 axes, w) [m]; -inf for an empty one.
    """

    axes: Singles
    middle: Singles
    half: Singles

    @classmethod
    def none(cls, n: int, w: int) -> _Boxes:
        """Empty boxes of n robots."""
        half = np.full((n, 3, w), -np.inf, np.float32)
        return cls(np.zeros((n, 3, 3, w), np.float32), np.zeros((n, 3, w), np.float32), half)

    def some(self, indices: Ints, width: int | None = None) -> _Boxes:
        """The first boxes of some robots, all by default."""
        return _Boxes(*(values[..., :width][indices] for values in self))

    def widened(self, w: int) -> _Boxes:
        """The same boxes with room for w."""
        wide = self.none(len(self.half), w)
        for values, before in zip(wide, self, strict=True):
            values[..., : before.shape[-1]] = before
        return wide


class Walls(NamedTuple):
    """Pieces of wall in the route's frame, w in number; those of a layout's parked geoms are empty.

    Attributes:
        geom: geoms, ascending, (w,).
        body: bodies of the geoms, (w,).
        boxes: boxes around the geoms.
    """

    geom: Ints
    body: Ints
    boxes: _Boxes

    @classmethod
    def of(cls, model: Any) -> Walls:
        """Walls of a compiled model of a route."""
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        geom = np.flatnonzero(model.body_weldid[model.geom_bodyid] == 0)
        turned, box = data.geom_xmat[geom].reshape(-1, 3, 3), model.geom_aabb[geom]
        middle = (data.geom_xpos[geom, None] @ turned)[:, 0] + box[:, :3]
        half = np.where((model.geom_contype[geom] == WALL)[:, None], box[:, 3:], -np.inf)
        boxes = _Boxes(np.moveaxis(turned, 0, -1), middle.T, half.T)
        return cls(geom, model.geom_bodyid[geom].copy(), _Boxes(*(values.astype(np.float32) for values in boxes)))


class NearPairs:
    """Lists of pairs of n robots, each in a model of its own.

    Args:
        parts: parts of the robot.
        n: number of robots.
        walls: number of pieces of wall in each model.
    """

    def __init__(self, parts: Parts, n: int, walls: int) -> None:
        self._parts, self._n = parts, n
        # Geoms on the same line with the same reach, such as both balls of a wheel, are one part in the search.
        alike, self._row = np.unique(np.column_stack([parts.ends.T, parts.reach]), axis=0, return_inverse=True)
        self._ends = alike[:, :2].T.astype(int).tolist()
        self._reach = alike[:, 2]
        self._walls = _Boxes.none(n, walls)
        self._geom, self._body = np.zeros((2, n, walls), np.int64)
        self._lists: list[_List] = []
        self._anchor, self._roam = np.full((n, int(parts.ends.max()) + 1, 3), np.nan), np.zeros(n)
        self._near, self._near_walls = _Boxes.none(n, NEIGHBOURS), np.zeros((n, NEIGHBOURS), np.int64)
        self._width = np.zeros(n, int)  # number of pieces of wall in each neighbourhood
        self._listed = Way(np.zeros_like(self._anchor), np.zeros_like(self._anchor), np.full(n, -np.inf))

    def take(self, models: Sequence[Any], indices: Ints, walls: Sequence[Walls]) -> None:
        """Let some robots have models of their own.

        Args:
            models: models of all robots.
            indices: robots whose models are new.
            walls: walls of these models.
        """
        if not self._lists:
            self._lists = [_List(model) for model in models]
        for i, of_model in zip(indices, walls, strict=True):
            for values, value in zip(self._walls, of_model.boxes, strict=True):
                values[i] = value
            self._geom[i], self._body[i] = of_model.geom, of_model.body
            self._lists[i] = _List(models[i])
        self._anchor[indices], self._listed.slack[indices] = np.nan, -np.inf

    def find(self, indices: Ints, way: Way, steady: Flags | None = None) -> int:
        """List the pairs of some robots on their ways, but where the listed way holds the next one.

        Args:
            indices: which robots, (k,).
            way: their ways; a slack is lowered to `SLACK` where a model has no room for it.
            steady: whether each robot moves steadily, (k,), so that it is looked ahead; none by default.

        Returns:
            The largest number of pairs of a robot; one whose model has no room for its pairs is not listed.
        """
        anew = np.flatnonzero(~self._listed.rows(indices).holds(way))
        if not len(anew):
            return 0
        plain, room = way.rows(anew), self._lists[0].room
        counts = self._list(indices[anew], plain if steady is None else plain.ahead(steady[anew]))
        if len(crowded := np.flatnonzero(counts > room)):
            tight = anew[crowded]
            way.slack[tight] = np.minimum(way.slack[tight], SLACK)
            counts[crowded] = self._list(indices[tight], way.rows(tight))
        return int(counts.max())

    def _list(self, indices: Ints, way: Way) -> Ints:
        """List the pairs of those robots on their ways that have room, and count the pairs of all, (k,)."""
        self._look_around(indices, way)
        near = self._touched(self._near.some(indices, int(self._width[indices].max())), way)
        part, robot, place = np.nonzero(near[self._row])
        counts = np.bincount(robot, minlength=len(indices))
        fits = counts <= self._lists[0].room
        if not fits.all():
            part, robot, place = part[fits[robot]], robot[fits[robot]], place[fits[robot]]
        self._write(indices, np.where(fits, counts, 0), robot, part, self._near_walls[indices[robot], place])
        for listed, values in zip(self._listed, way, strict=True):
            listed[indices[fits]] = values[fits]
        return counts

    def _write(self, indices: Ints, counts: Ints, robot: Ints, part: Ints, wall: Ints) -> None:
        """Write pairs into models, sorted as MuJoCo sorts those that it finds itself: by bodies, then by geoms."""
        parts, rows = self._parts, indices[robot]
        body, geom = self._body[rows, wall], self._geom[rows, wall]
        bodies, geoms = int(self._body.max()) + 1, int(self._geom.max()) + 1
        key = ((robot * bodies + parts.body[part]) * bodies + body) * len(parts.geom) + part
        key = np.sort(key * geoms + geom)
        second, part = key % geoms, key // geoms % len(parts.geom)
        first, friction = parts.geom[part], parts.friction[part, None]
        ends = np.cumsum(counts).tolist()
        for i, begin, end in zip(indices.tolist(), [0, *ends], ends, strict=False):
            self._lists[i].write(first[begin:end], second[begin:end], friction[begin:end])

    def _look_around(self, indices: Ints, way: Way) -> None:
        """Look up the neighbourhoods of robots that leave theirs."""
        moved = [((points - self._anchor[indices]) ** 2).sum(axis=2).max(axis=1) for points in way[:2]]
        left = ~(np.sqrt(np.maximum(*moved)) + way.slack <= self._roam[indices])
        if not left.any():
            return
        rows, points = indices[left], way.start[left]
        length = np.sqrt(((way.end[left] - points) ** 2).sum(axis=2).max(axis=1))
        self._roam[rows] = np.maximum(ROAM, length + way.slack[left])
        reached = self._touched(self._walls.some(rows), Way(points, points, self._roam[rows])).any(axis=0)
        counts = reached.sum(axis=1)
        if counts.max() > self._near_walls.shape[1]:
            self._near = self._near.widened(int(counts.max()))
            self._near_walls = np.pad(self._near_walls, [(0, 0), (0, int(counts.max()) - self._near_walls.shape[1])])
        width = self._near_walls.shape[1]
        some = np.argsort(~reached, axis=1, kind="stable")[:, :width]  # those reached first, ascending
        some = np.pad(some, [(0, 0), (0, width - some.shape[1])])
        self._near_walls[rows], self._width[rows] = some, counts
        self._near.axes[rows] = np.take_along_axis(self._walls.axes[rows], some[:, None, None], axis=3)
        self._near.middle[rows] = np.take_along_axis(self._walls.middle[rows], some[:, None], axis=2)
        half = np.take_along_axis(self._walls.half[rows], some[:, None], axis=2)
        self._near.half[rows] = np.where(np.arange(width) < counts[:, None, None], half, np.float32(-np.inf))
        self._anchor[rows] = points

    def _touched(self, boxes: _Boxes, way: Way) -> Flags:
        """Whether each box is within the slack of each part on its way, (parts, k, w): never false where it is."""
        k, w = boxes.half.shape[0], boxes.half.shape[2]
        points, p = np.concatenate(way[:2], axis=1).astype(np.float32), way.start.shape[1]
        along = points @ boxes.axes.reshape(k, 3, 3 * w)  # (k, 2 p, 3 w)
        along -= boxes.middle.reshape(k, 1, 3 * w)
        along = along.swapaxes(0, 1).copy()
        low, high = np.minimum(along[:p], along[p:]), np.maximum(along[:p], along[p:])
        low -= (half := boxes.half.reshape(k, 3 * w))  # distance from the box towards either side
        high = np.negative(np.add(high, half, out=high), out=high)
        gap, other = np.empty((len(self._reach), k, 3 * w), np.float32), np.empty_like(half)
        for of_part, first, last in zip(gap, *self._ends, strict=True):
            np.minimum(low[first], low[last], out=of_part)
            np.maximum(of_part, np.minimum(high[first], high[last], out=other), out=of_part)
        gap = np.maximum(gap, np.float32(0.0), out=gap)
        gap *= gap
        distance = gap[..., :w] + gap[..., w : 2 * w] + gap[..., 2 * w :]
        limit = ((self._reach[:, None] + way.slack + ROUNDING) ** 2).astype(np.float32)
        return np.asarray(distance <= limit[:, :, None])


class _List:
    """Pairs of a model, as views of it.

    Attributes:
        room: number of pairs that it has room for.
    """

    def __init__(self, model: Any) -> None:
        self._geom1, self._geom2, self._friction = model.pair_geom1, model.pair_geom2, model.pair_friction[:, :2]
        self._nothing = int(np.flatnonzero(model.body_weldid[model.geom_bodyid] == 0)[0])
        self.room = self._count = len(self._geom1)
        self.write(np.zeros(0, int), np.zeros(0, int), np.zeros((0, 1)))

    def write(self, first: Ints, second: Ints, friction: Floats) -> None:
        """Write geoms and frictions (pairs, 1); a wall with itself fills the rest, which MuJoCo skips at once."""
        count = len(first)
        self._geom1[:count], self._geom2[:count], self._friction[:count] = first, second, friction
        if count < self._count:
            self._geom1[count : self._count] = self._geom2[count : self._count] = self._nothing
        self._count = count
