"""A few robots in one Bullet world, one above the other, each between walls of its own."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends import CONTROL_PERIOD, WALL_HALF_HEIGHT, Control, Edge, Variation, wall_boxes
from pipenav.pipes import Pipe
from pipenav.robots import RobotSpec, kinematics
from pipenav_pybullet.quiet import silenced_stderr
from pipenav_pybullet.urdf import DISCS as DISC_LINK
from pipenav_pybullet.urdf import SLIDES, body, discs, robot_urdf

with silenced_stderr():  # it tells when it was built
    import pybullet


BOXES, WALLS, DISCS, FACES = 1, 2, 4, 8
"""Collision groups: boxes meet walls of boxes, discs meet walls of triangles, and links never meet each other.

Each in its own way Bullet is exact only there: two boxes by their separating axes, a ball and a triangle in closed
form. For other pairs it iterates, and errs by some tenths of a millimetre.
"""

STOREY = 0.5
"""Height between two robots [m]: walls end WALL_HALF_HEIGHT above and below. A power of two, so that every storey
computes with the same digits; in the plane of motion all robots have the same coordinates anyway."""

MEZZANINE = STOREY / 2
"""Height above its robot at which the faces of a pipe's walls stand, and beams are cast [m].

Bullet's rays stop up to a centimetre before a box, but exactly on a triangle; here they meet nothing else.
"""

INNER_EDGE = Edge(thickness=1e-5, gap=5e-5)
"""Boxes at the inner wall's edges are thinner and end before them [m].

A link that slides along one of them sinks in by a hundredth of a millimetre. The end of the next one, where it stood
out by that much, would stop it like a doorstep: one passage in ten of the narrow, sharp corners got stuck there.
"""

CONTACT_THRESHOLD = 0.004
"""Gap from which on Bullet foresees a contact [m]: twice what the tip travels in a physics step at full speed."""


WORLD_SIZE = 16
"""Robots in one Bullet world: the fastest of those measured (benchmarks/pybullet_worlds.py)."""


class Setting(NamedTuple):
    """What a world is made with: physics step [s], constraint solver iterations, share of an overlap undone a step."""

    timestep: float
    solver_iterations: int
    contact_erp: float


class Motion(NamedTuple):
    """State of k robots after a control period, and what happened in it.

    Attributes:
        configuration: (k, coordinates) [rad or m].
        speeds: of joints and wheels, (k, actuators) [rad/s or m/s].
        loads: drives that the on-board controllers asked for last, as shares of the effort limit, (k, actuators).
        distances: along the beams to the nearest wall, inf where there is none, (k, beams) [m].
        forces: net force of the walls on each link in each physics step, in the plane, (k, substeps, links, 2) [N].
        depth: deepest overlap of the period, (k,) [m].
        contact_share: share of the physics steps with contact, (k,).
    """

    configuration: Floats
    speeds: Floats
    loads: Floats
    distances: Floats
    forces: Floats
    depth: Floats
    contact_share: Floats


def shares(indices: Ints, bounds: Sequence[int]) -> list[Ints]:
    """Which entries of `indices` (k,) lie between each two of the ascending bounds, the upper one excluded."""
    return [np.flatnonzero((indices >= first) & (indices < last)) for first, last in pairwise(bounds)]


class World:
    """k robots in one Bullet client."""

    def __init__(self, robot: RobotSpec, k: int, setting: Setting) -> None:
        self._robot, self._k = robot, k
        self._substeps = round(CONTROL_PERIOD / setting.timestep)
        self._client = pybullet.connect(pybullet.DIRECT)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=setting.timestep,
            numSolverIterations=setting.solver_iterations,
            contactERP=setting.contact_erp,
            contactBreakingThreshold=CONTACT_THRESHOLD,
            deterministicOverlappingPairs=1,  # the order of contacts must not depend on what was there before
            minimumSolverIslandSize=1,  # robots solved together would share the solver's number of iterations
            physicsClientId=self._client,
        )
        self._arms = self._load_arms()
        self._find_joints()
        for arm in self._arms:
            self._prepare(arm)
        self._storey = {arm: i for i, arm in enumerate(self._arms)}
        self._around: list[list[int]] = [[] for _ in range(k)]
        self._shapes: dict[Pipe, tuple[int, int]] = {}
        efforts = [(a.effort_limit, a.controller_gain) for a in robot.driven_actuators]
        self._motors = np.array(efforts).T[:, None]  # (2, 1, drives)
        self._effort, self._stiffness = np.repeat(self._motors, k, axis=1)
        self._damping = np.array([a.damping for a in robot.driven_actuators])
        self._configuration, self._speeds = np.zeros((k, robot.coordinates)), np.zeros((k, len(robot.driven_actuators)))

    def _load_arms(self) -> list[int]:
        arms = []
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "robot.urdf")
            path.write_text(robot_urdf(self._robot), encoding="utf-8")
            for i in range(self._k):
                arm = pybullet.loadURDF(
                    str(path),
                    basePosition=[0.0, 0.0, i * STOREY],
                    useFixedBase=True,
                    flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
                    physicsClientId=self._client,
                )
                arms.append(arm)
        return arms

    def _find_joints(self) -> None:
        """Bullet's index of what has a coordinate and of what is driven, and whose each of Bullet's links is.

        Bullet numbers joints as the links that they move, and knows these by name.
        """
        robot, arm = self._robot, self._arms[0]
        count = pybullet.getNumJoints(arm, physicsClientId=self._client)
        names = [pybullet.getJointInfo(arm, i, physicsClientId=self._client)[12].decode() for i in range(count)]
        links = [link.name for link in robot.links]
        moved = [link.name for link in robot.links if link.joint is not None]
        base = [*SLIDES, links[0]] if robot.free else []
        wheels = {link.wheel.name: i for i, link in enumerate(robot.links) if link.wheel is not None}
        self._coordinates = [names.index(name) for name in [*base, *moved]]
        self._driven = [names.index(name) for name in [*moved, *wheels]]
        self._bodies = [names.index(name) for name in links]
        self._wheels = {names.index(name): i for name, i in wheels.items()}
        owners = {name: i for i, name in enumerate(links)} | wheels
        self._link_of = [owners.get(name.removesuffix(DISC_LINK), 0) for name in names]

    def _prepare(self, arm: int) -> None:
        """Without the motors and the losses that Bullet gives every joint and link unasked."""
        moving = sorted({*self._coordinates, *self._driven})
        free = [0.0] * len(moving)
        pybullet.setJointMotorControlArray(
            arm, moving, pybullet.VELOCITY_CONTROL, forces=free, physicsClientId=self._client
        )
        for link in range(len(self._link_of)):
            groups = (BOXES, WALLS) if link in self._bodies else (DISCS, FACES)
            pybullet.setCollisionFilterGroupMask(arm, link, *groups, physicsClientId=self._client)
            pybullet.changeDynamics(
                arm,
                link,
                lateralFriction=self._friction(link),  # Bullet multiplies it by the wall's
                restitution=0.0,
                linearDamping=0.0,
                angularDamping=0.0,
                physicsClientId=self._client,
            )

    def _friction(self, link: int) -> float:
        """Of one of Bullet's links."""
        wheel = self._robot.links[self._wheels[link]].wheel if link in self._wheels else None
        return self._robot.friction if wheel is None else wheel.friction

    def vary(self, arms: Sequence[int], variation: Variation) -> None:
        """As `pipenav.backends.Variable`."""
        effort, stiffness = self._motors
        for row, i in enumerate(arms):
            self._effort[i] = effort * variation.strength[row]
            self._stiffness[i] = stiffness * variation.strength[row] * variation.gain[row]
            for link in range(len(self._link_of)):
                changes = {"lateralFriction": self._friction(link) * variation.friction[row]}
                if link in self._bodies:
                    j = self._bodies.index(link)
                    description = self._robot.links[j]
                    heavier = description.model_copy(update={"mass": description.mass * variation.mass[row, j]})
                    itself = body(self._robot, heavier)
                    changes |= {"mass": itself.mass, "localInertiaDiagonal": [itself.inertia] * 3}
                pybullet.changeDynamics(self._arms[i], link, physicsClientId=self._client, **changes)

    def reset(self, arms: Sequence[int], pipes: Sequence[Pipe], q: Floats, base: Floats) -> Floats:
        """As `Backend.reset`; distances along the beams of those robots, (len(arms), beams)."""
        for row, i in enumerate(arms):
            self._surround(i, pipes[row], base[row])
            wheels = [(wheel, 0.0) for wheel in self._wheels]
            for joint, position in [*zip(self._coordinates, q[row], strict=True), *wheels]:
                pybullet.resetJointState(self._arms[i], joint, position, 0.0, physicsClientId=self._client)
            self._configuration[i], self._speeds[i] = q[row], 0.0
        return self._distances(list(arms))

    def _surround(self, i: int, pipe: Pipe, base: float) -> None:
        """Put a pipe around robot i. With the bodies that stood there go the contacts that Bullet remembers."""
        for wall in self._around[i]:
            pybullet.removeBody(wall, physicsClientId=self._client)
        if pipe not in self._shapes:  # never removed: Bullet keeps shapes for ever
            self._shapes[pipe] = (self._box_shape(pipe), self._face_shape(pipe))
        boxes, faces = self._shapes[pipe]
        height = i * STOREY
        self._around[i] = [
            self._place(boxes, base, height, (WALLS, BOXES)),
            self._place(faces, base, height + MEZZANINE),
        ]
        if self._wheels or any(discs(link) for link in self._robot.links):
            self._around[i].append(self._place(faces, base, height, (FACES, DISCS)))

    def _place(self, shape: int, base: float, height: float, groups: tuple[int, int] | None = None) -> int:
        """A fixed body. As a multibody, which is Bullet's default, it would leave two kilobytes behind when removed."""
        body: int = pybullet.createMultiBody(
            0.0, shape, -1, [-base, 0.0, height], useMaximalCoordinates=True, physicsClientId=self._client
        )
        pybullet.changeDynamics(body, -1, lateralFriction=1.0, restitution=0.0, physicsClientId=self._client)
        if groups:
            pybullet.setCollisionFilterGroupMask(body, -1, *groups, physicsClientId=self._client)
        return body

    def _box_shape(self, pipe: Pipe) -> int:
        """The walls of a pipe as boxes. Bullet writes the scalar part of a quaternion last."""
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
        """The faces of a pipe's walls, two triangles each."""
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

    def step(self, control: Control, values: Floats) -> Motion:
        """One control period under commands as `Command` has them."""
        forces = np.zeros((self._k, self._substeps, len(self._robot.links), 2))
        depth, touching = np.zeros(self._k), np.zeros((self._k, self._substeps))
        actuators = self._effort * np.clip(values, -1.0, 1.0)
        for substep in range(self._substeps):
            if control == "position":
                actuators = np.clip(self._stiffness * (values - self._controlled()), -self._effort, self._effort)
            efforts = actuators - self._damping * self._speeds
            for arm, effort in zip(self._arms, efforts.tolist(), strict=True):
                pybullet.setJointMotorControlArray(
                    arm, self._driven, pybullet.TORQUE_CONTROL, forces=effort, physicsClientId=self._client
                )
            pybullet.stepSimulation(physicsClientId=self._client)
            self._read_joints()
            self._collect_contacts(forces[:, substep], depth, touching[:, substep])
        return Motion(
            self._configuration.copy(),
            self._speeds.copy(),
            actuators / self._effort,
            self._distances(range(self._k)),
            forces,
            depth,
            touching.mean(axis=1),
        )

    def _controlled(self) -> Floats:
        """What the on-board controllers keep: positions of joints, speeds of wheels, (k, actuators)."""
        joints = len(self._robot.joints)
        return np.concatenate([self._configuration[:, -joints:], self._speeds[:, joints:]], axis=1)

    def _read_joints(self) -> None:
        asked = self._coordinates + self._driven
        for i, arm in enumerate(self._arms):
            states = pybullet.getJointStates(arm, asked, physicsClientId=self._client)
            self._configuration[i] = [state[0] for state in states[: len(self._coordinates)]]
            self._speeds[i] = [state[1] for state in states[len(self._coordinates) :]]

    def _collect_contacts(self, forces: Floats, depth: Floats, touching: Floats) -> None:
        """Add the last physics step's contacts: forces (k, links, 2), depth (k,), touching (k,)."""
        for contact in pybullet.getContactPoints(physicsClientId=self._client):
            _, body_a, body_b, link_a, link_b, _, _, normal, distance, push, drag1, way1, drag2, way2 = contact
            arm, link, sign = (body_a, link_a, 1.0) if body_a in self._storey else (body_b, link_b, -1.0)
            if push <= 0.0 and distance >= 0.0:
                continue  # foreseen, and not come to pass
            i, link = self._storey[arm], self._link_of[link]
            for axis in (0, 1):  # Bullet gives what acts on its body A
                force = push * normal[axis] + drag1 * way1[axis] + drag2 * way2[axis]
                forces[i, link, axis] += sign * force
            depth[i] = max(depth[i], -distance)
            touching[i] = 1.0

    def _distances(self, arms: Sequence[int]) -> Floats:
        """Distances along the beams of some robots by Bullet's batch ray test; inf beyond the laser's range."""
        laser = self._robot.laser
        pose = kinematics.forward(self._robot, self._configuration[list(arms)])
        headings = pose.headings[:, -1:] + laser.angles  # (len(arms), beams)
        height = np.repeat(np.array(arms) * STOREY + MEZZANINE, laser.beams)
        start = np.repeat(pose.tip, laser.beams, axis=0)
        ways = np.stack([np.cos(headings), np.sin(headings)], axis=-1).reshape(-1, 2)
        reach = laser.range_max + laser.resolution
        rays = [np.column_stack([xy, height]).tolist() for xy in (start, start + reach * ways)]
        hits = pybullet.rayTestBatch(*rays, numThreads=1, physicsClientId=self._client)
        fractions = np.array([hit[2] if hit[0] >= 0 else np.inf for hit in hits])
        return np.asarray(reach * fractions.reshape(headings.shape))

    def close(self) -> None:
        pybullet.disconnect(physicsClientId=self._client)
