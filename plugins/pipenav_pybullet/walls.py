"""Walls of pipes in a Bullet world, placed around its robots."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.backends import WALL_HALF_HEIGHT, Edge, wall_boxes
from pipenav.pipes import Pipe
from pipenav_pybullet.quiet import silenced_stderr

with silenced_stderr():  # it reports when it was built
    import pybullet

BOXES, WALLS, DISCS, FACES = 1, 2, 4, 8
"""Collision groups: boxes meet walls of boxes, discs meet walls of triangles, and links never meet each other.

Bullet is exact only for these pairs: two boxes by their separating axes, a ball and a triangle in closed form. For
other pairs it iterates, and errs by some tenths of a millimetre.
"""

STOREY = 0.5
"""Height between two robots [m]: walls end WALL_HALF_HEIGHT above and below.

It is a power of two, so that every storey computes with the same digits; in the plane of motion all robots have the
same coordinates anyway.
"""

MEZZANINE = STOREY / 2
"""Height above its robot at which the faces of a pipe's walls stand, and beams are cast [m].

Bullet's rays stop up to a centimetre before a box, but exactly on a triangle; here they meet nothing else.
"""

INNER_EDGE = Edge(thickness=1e-5, gap=5e-5)
"""Ends of the boxes at the inner wall's edges [m]: the boxes are thinner there and end before the edge.

A link that slides along a box sinks in by a hundredth of a millimetre. If the next box stood out by that much, its end
would stop the link like a doorstep: a tenth of all passages of narrow, sharp corners got stuck there.
"""


class PipeShapes(NamedTuple):
    """Bullet's numbers of the shapes of a pipe: its walls as boxes, and the faces of its walls as triangles."""

    boxes: int
    faces: int


class Walls:
    """Pipes around the k robots of one Bullet client.

    Args:
        client: Bullet's number of the client.
        k: number of robots.
        discs: whether the robots have discs or wheels, which meet walls of triangles.
    """

    def __init__(self, client: int, k: int, discs: bool) -> None:
        self._client, self._discs = client, discs
        self._around: list[list[int]] = [[] for _ in range(k)]
        self._shapes: dict[Pipe, PipeShapes] = {}

    def surround(self, i: int, pipe: Pipe, base: float) -> None:
        """Put a pipe around robot i. With the old walls Bullet forgets their contacts.

        Args:
            i: number of the robot.
            pipe: the pipe.
            base: origin of the robot's frame on the first leg's axis, x in the pipe's frame [m].
        """
        for wall in self._around[i]:
            pybullet.removeBody(wall, physicsClientId=self._client)
        if pipe not in self._shapes:  # never removed: Bullet keeps shapes for ever
            self._shapes[pipe] = PipeShapes(self._box_shape(pipe), self._face_shape(pipe))
        boxes, faces = self._shapes[pipe]
        height = i * STOREY
        self._around[i] = [
            self._place(boxes, base, height, (WALLS, BOXES)),
            self._place(faces, base, height + MEZZANINE),
        ]
        if self._discs:
            self._around[i].append(self._place(faces, base, height, (FACES, DISCS)))

    def _place(self, shape: int, base: float, height: float, groups: tuple[int, int] | None = None) -> int:
        """Place a fixed body. As a multibody, which is Bullet's default, it would leave two kilobytes when removed."""
        body: int = pybullet.createMultiBody(
            0.0, shape, -1, [-base, 0.0, height], useMaximalCoordinates=True, physicsClientId=self._client
        )
        pybullet.changeDynamics(body, -1, lateralFriction=1.0, restitution=0.0, physicsClientId=self._client)
        if groups:
            pybullet.setCollisionFilterGroupMask(body, -1, *groups, physicsClientId=self._client)
        return body

    def _box_shape(self, pipe: Pipe) -> int:
        """Shape of a pipe's walls as boxes. Bullet writes the scalar part of a quaternion last."""
        position, quaternion, half_size, _ = (
            part[0] for part in wall_boxes([pipe], len(pipe.segments), np.zeros(1), INNER_EDGE)
        )
        shape: int = pybullet.createCollisionShapeArray(
            shapeTypes=[pybullet.GEOM_BOX] * len(position),
            halfExtents=half_size.tolist(),
            collisionFramePositions=position.tolist(),
            collisionFrameOrientations=np.roll(quaternion, -1, axis=1).tolist(),
            physicsClientId=self._client,
        )
        return shape

    def _face_shape(self, pipe: Pipe) -> int:
        """Shape of a pipe's wall faces, two triangles each."""
        low, high = (np.insert(pipe.segments, 2, z, axis=2) for z in (-WALL_HALF_HEIGHT, 2 * WALL_HALF_HEIGHT))
        corners = np.concatenate([low, high], axis=1)  # (s, 4, 3)
        triangles = 4 * np.arange(len(pipe.segments))[:, None] + [0, 1, 3, 0, 3, 2]
        shape: int = pybullet.createCollisionShape(
            pybullet.GEOM_MESH,
            vertices=corners.reshape(-1, 3).tolist(),
            indices=triangles.ravel().tolist(),
            flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
            physicsClientId=self._client,
        )
        return shape
