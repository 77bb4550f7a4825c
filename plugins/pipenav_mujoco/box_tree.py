"""Trees of bounding boxes for the long walls of a leg.

MuJoCo's compiler halves the geoms of a body along the longest side of their bounding box. That side is the leg's length
for every part of a leg, so halves would mix walls from all around the bore. Here each node is split where its parts are
least likely to be met, which leaves a third of the tests. A node hardly smaller than the one above it is not worth a
test of its own and gets a box without end, which MuJoCo passes untested. The tree alters no contact: MuJoCo sorts those
of two bodies.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.robots import space_kinematics

SOUGHT = 0.03
"""Size of what is looked for in the tree [m]: a wheel or a link."""

WORTH_A_TEST = 0.7
"""Share of the volume of the last tested node above it, enlarged by `SOUGHT`, from which a node is not tested."""

ENDLESS = 1e11
"""Half a side of a box without end [m]; MuJoCo takes those from 1e10 on as such (mjMAXVAL)."""


class _Bounds(NamedTuple):
    """Least and largest coordinates of geoms in their body's frame, (geoms, 3) [m]."""

    low: Floats
    high: Floats


def split_well(model: Any, body: int) -> None:
    """Write a better tree of a body's geoms into a model.

    Args:
        model: compiled model, with all of the body's geoms in the tree and its inertial frame in the body's own.
        body: number of the body.
    """
    first, count = model.body_geomadr[body], model.body_geomnum[body]
    nodes = slice(model.body_bvhadr[body], model.body_bvhadr[body] + model.body_bvhnum[body])
    bounds = _bounds(model, np.arange(first, first + count))
    tree = _Tree(bounds)
    tree.add(np.arange(count), 0)
    assert len(tree.geom) == model.body_bvhnum[body]
    boxes = np.array([[bounds.low[part].min(axis=0), bounds.high[part].max(axis=0)] for part in tree.parts])
    half = np.where(
        tree.untested(_volumes(boxes[:, 0], boxes[:, 1]))[:, None], ENDLESS, (boxes[:, 1] - boxes[:, 0]) / 2
    )
    model.bvh_aabb[nodes, :3], model.bvh_aabb[nodes, 3:] = boxes.mean(axis=1), half
    model.bvh_child[nodes], model.bvh_depth[nodes] = tree.children, tree.depth
    model.bvh_nodeid[nodes] = [first + geom if geom >= 0 else -1 for geom in tree.geom]


class _Tree:
    """Tree in the order in which MuJoCo stores it.

    Attributes:
        parts: geoms below each node, counted from the body's first.
        geom: geom of each leaf, -1 for other nodes.
        children: the two nodes below each node, -1 for leaves.
        depth: depth of each node.
    """

    def __init__(self, bounds: _Bounds) -> None:
        self._bounds = bounds
        self.parts: list[Ints] = []
        self.geom: list[int] = []
        self.children: list[list[int]] = []
        self.depth: list[int] = []

    def add(self, part: Ints, depth: int) -> int:
        """Add the node above some geoms with all nodes below it; return its number."""
        node = len(self.parts)
        self.parts.append(part)
        self.depth.append(depth)
        self.geom.append(int(part[0]) if len(part) == 1 else -1)
        self.children.append([-1, -1])
        if len(part) > 1:
            self.children[node] = [self.add(half, depth + 1) for half in self._halves(part)]
        return node

    def untested(self, volumes: Floats) -> Flags:
        """Whether each node of these volumes (nodes,) is not worth a test, (nodes,); root and leaves always are."""
        untested, above = np.zeros(len(volumes), bool), volumes.copy()  # of the last tested node, itself included
        for node, children in enumerate(self.children):  # those above come first
            for child in children:
                if child < 0:
                    continue
                untested[child] = self.geom[child] < 0 and volumes[child] > WORTH_A_TEST * above[node]
                above[child] = above[node] if untested[child] else volumes[child]
        return untested

    def _halves(self, part: Ints) -> tuple[Ints, Ints]:
        """The two parts of a node, in order along the axis where their volumes, each times its geoms, add up to least.

        A volume is that of the bounding box, enlarged by what is looked for: how likely the latter meets the box.
        """
        low, high = self._bounds.low[part], self._bounds.high[part]
        order = np.argsort(low + high, axis=0, kind="stable")  # (k, axes)
        low, high = low[order], high[order]  # (k, axes, 3)
        before = _volumes(np.minimum.accumulate(low), np.maximum.accumulate(high))
        behind = _volumes(np.minimum.accumulate(low[::-1]), np.maximum.accumulate(high[::-1]))[::-1]
        size = np.arange(1, len(part))[:, None]
        cost = before[:-1] * size + behind[1:] * size[::-1]
        split, axis = np.unravel_index(cost.argmin(), cost.shape)
        return part[order[: split + 1, axis]], part[order[split + 1 :, axis]]


def _volumes(low: Floats, high: Floats) -> Floats:
    return np.asarray(np.prod(high - low + SOUGHT, axis=-1))


def _bounds(model: Any, geoms: Ints) -> _Bounds:
    turned = space_kinematics.rotation(model.geom_quat[geoms])
    middle = model.geom_pos[geoms] + (turned @ model.geom_aabb[geoms, :3, None])[..., 0]
    half = (np.abs(turned) @ model.geom_aabb[geoms, 3:, None])[..., 0]
    return _Bounds(middle - half, middle + half)
