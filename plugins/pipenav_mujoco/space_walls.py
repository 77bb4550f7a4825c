"""Walls of a route as static geoms, padded with parked ones, so that models of different routes have equal sizes.

The solids of each leg belong to a body of their own that stands along the leg, so that equal legs have equal numbers
wherever they lie.
"""

from __future__ import annotations

import math
from collections import Counter
from typing import Any, NamedTuple, Self

import mujoco
import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends import OUTER_THICKNESS
from pipenav.pipes import PipeRoute, WallSolids, wall_solids
from pipenav.robots import RobotSpec
from pipenav_mujoco.model import HIDDEN_GROUP, WALL_TOUCHES, Contact, surface

WALL_GROUP = 2
"""Geom group of the walls, which beams see."""

PARKED_TOUCHES = {"contype": 4, "conaffinity": 4}
"""Collision masks of parked geoms: they meet nothing, and only make models of different routes equally large."""

ROUND_UP = 16
"""Boxes in a layout are a multiple of this, so that a route with a few more does not need a new one."""

SLOTS = 64
"""Pairs in a layout are a multiple of this."""


class Layout(NamedTuple):
    """Numbers of solids that a model has room for.

    Attributes:
        legs: bodies of legs.
        boxes: boxes.
        hulls: hulls by their number of vertices, each (vertices, count), sorted.
        pairs: pairs of a robot's part and a wall that are listed at once; 0 where MuJoCo finds them itself.
    """

    legs: int
    boxes: int
    hulls: tuple[tuple[int, int], ...]
    pairs: int = 0

    @classmethod
    def of(cls, route: PipeRoute) -> Self:
        """The least layout with room for a route."""
        solids, legs = wall_solids(route, OUTER_THICKNESS), len(route.straights)
        boxes = -(-len(solids.position) // ROUND_UP) * ROUND_UP
        return cls(legs, boxes, tuple(sorted(Counter(len(hull) for hull in solids.hulls).items())))

    @property
    def pieces(self) -> int:
        """Number of solids."""
        return self.boxes + sum(count for _, count in self.hulls)

    def with_pairs(self, count: float) -> Self:
        """The same layout with room for as many pairs at least."""
        return self._replace(pairs=max(self.pairs, math.ceil(count / SLOTS) * SLOTS))

    def union(self, other: Self) -> Self:
        """The least layout with room for what fits into either."""
        hulls = Counter(dict(self.hulls)) | Counter(dict(other.hulls))
        boxes = max(self.boxes, other.boxes)
        pairs = max(self.pairs, other.pairs)
        return type(self)(max(self.legs, other.legs), boxes, tuple(sorted(hulls.items())), pairs)


def leg_name(i: int) -> str:
    """Name of the body that has the walls of a leg, counted from 0."""
    return f"leg{i}"


def add_walls(spec: Any, robot: RobotSpec, route: PipeRoute, contact: Contact, layout: Layout) -> None:
    """Add the walls of a route to a model's specification, and parked geoms up to the layout."""
    solids = wall_solids(route, OUTER_THICKNESS)
    wall = {"material": "wall", "group": WALL_GROUP, **WALL_TOUCHES, **surface(robot.friction, contact)}
    bodies = [_add_body(spec, leg_name(i)) for i in range(layout.legs + 1)]  # the last one only ever has parked geoms
    start, axes = route.legs.start, route.legs.axes
    for i, body in enumerate(bodies[: len(start)]):
        body.pos, body.quat = start[i], _quaternion(axes[i])
    leg_of_box = _nearest_leg(route, solids.position)
    for i, leg in enumerate(leg_of_box):
        position, rotation = axes[leg].T @ (solids.position[i] - start[leg]), axes[leg].T @ solids.rotation[i]
        _add_box(bodies[leg], solids.half_size[i], wall, pos=position, quat=_quaternion(rotation))
    middles = np.array([hull.mean(axis=0) for hull in solids.hulls]).reshape(-1, 3)
    for i, leg in enumerate(_nearest_leg(route, middles)):
        _add_hull(spec, bodies[leg], f"hull{i}", (solids.hulls[i] - start[leg]) @ axes[leg], wall)
    _park(spec, bodies, solids, len(start), layout)


def hand_to_world(model: Any) -> None:
    """Make the world the owner of all walls in a compiled model, without moving them by a bit.

    In every step MuJoCo looks at all geoms but those of the world, to find the axes along which it sorts bodies.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    walls = np.flatnonzero(model.body_weldid[model.geom_bodyid] == 0)
    model.geom_pos[walls], model.geom_quat[walls] = data.geom_xpos[walls], data.geom_xquat[walls]
    model.geom_sameframe[walls] = mujoco.mjtSameFrame.mjSAMEFRAME_NONE
    model.geom_bodyid[walls] = 0


def _park(spec: Any, bodies: list[Any], solids: WallSolids, legs: int, layout: Layout) -> None:
    """Add parked geoms up to the layout, at least one to each body that is no leg's."""
    parked = {"group": HIDDEN_GROUP, **PARKED_TOUCHES}
    spare = bodies[legs:]
    for i in range(layout.boxes + len(bodies) - len(solids.position)):
        _add_box(spare[min(i, len(spare) - 1)], [0.01] * 3, parked)
    used = Counter(len(hull) for hull in solids.hulls)
    for vertices, room in layout.hulls:
        for i in range(room - used[vertices]):
            around = np.linspace(0, 2 * np.pi, vertices, endpoint=False)
            hull = 0.01 * np.stack([np.cos(around), np.sin(around), np.cos(2 * around)], axis=1)
            _add_hull(spec, bodies[-1], f"parked{vertices}_{i}", hull, parked)


def _add_body(spec: Any, name: str) -> Any:
    """Add a static body whose inertia has the body's own axes."""
    inertial = {"explicitinertial": True, "mass": 1.0, "inertia": [1.0, 1.0, 1.0]}
    return spec.worldbody.add_body(name=name, ipos=[0.0, 0.0, 0.0], iquat=[1.0, 0.0, 0.0, 0.0], **inertial)


def _add_box(body: Any, half_size: Any, look: dict[str, Any], **pose: Any) -> None:
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half_size, **pose, **look)


def _add_hull(spec: Any, body: Any, name: str, vertices: Floats, look: dict[str, Any]) -> None:
    spec.add_mesh(name=name, uservert=vertices.ravel())
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, **look)


def _nearest_leg(route: PipeRoute, points: Floats) -> Ints:
    """Leg to whose centre line each point (m, 3) is nearest, (m,)."""
    along, start = route.legs.axes[:, :, 0], route.legs.start
    offset = points[:, None] - start  # (m, legs, 3)
    reach = np.clip(np.sum(offset * along, axis=-1), 0.0, route.legs.length)
    return np.asarray(np.linalg.norm(offset - reach[..., None] * along, axis=-1).argmin(axis=1))


def _quaternion(rotation: Floats) -> Floats:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion
