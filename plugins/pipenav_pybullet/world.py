"""A Bullet world with a few robots, one above the other, each between walls of its own."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends import Control, Variation, physics_steps, temporary_folder
from pipenav.pipes import Pipe
from pipenav.robots import RobotSpec, kinematics
from pipenav_pybullet.quiet import silenced_stderr
from pipenav_pybullet.urdf import DISCS as DISC_LINK
from pipenav_pybullet.urdf import SLIDES, body, discs, robot_urdf
from pipenav_pybullet.walls import BOXES, DISCS, FACES, MEZZANINE, STOREY, WALLS, Walls

with silenced_stderr():  # it reports when it was built
    import pybullet


CONTACT_THRESHOLD = 0.004
"""Gap below which Bullet foresees a contact [m]: twice the tip's travel in a physics step at full speed."""

WORLD_SIZE = 16
"""Number of robots in a Bullet world: the fastest of those measured (benchmarks/pybullet_worlds.py)."""


class Setting(NamedTuple):
    """Settings of a world.

    Attributes:
        timestep: physics step [s].
        solver_iterations: iterations of the constraint solver in a physics step.
        contact_erp: share of an overlap that a physics step undoes.
    """

    timestep: float
    solver_iterations: int
    contact_erp: float


class Motion(NamedTuple):
    """State of k robots after a control period, and the contacts in it.

    Attributes:
        configuration: configurations of the robots, (k, coordinates) [rad or m].
        speeds: speeds of joints and wheels, (k, actuators) [rad/s or m/s].
        loads: duties that the on-board controllers asked for last, (k, actuators).
        distances: distances along the beams to the nearest wall, inf where there is none, (k, beams) [m].
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
    """Positions of the entries of `indices` (k,) between each two of the ascending bounds, the upper one excluded."""
    return [np.flatnonzero((indices >= first) & (indices < last)) for first, last in pairwise(bounds)]


class World:
    """World of k robots: one Bullet client."""

    def __init__(self, robot: RobotSpec, k: int, setting: Setting) -> None:
        self._robot, self._k = robot, k
        self._substeps = physics_steps(setting.timestep)
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
        rolls = bool(self._wheels) or any(discs(link) for link in robot.links)
        self._walls = Walls(self._client, k, discs=rolls)
        efforts = [(a.effort_limit, a.controller_gain) for a in robot.driven_actuators]
        self._motors = np.array(efforts).T[:, None]  # (2, 1, actuators)
        self._effort, self._stiffness = np.repeat(self._motors, k, axis=1)
        self._pulled = np.zeros((k, 2))
        self._damping = np.array([a.damping for a in robot.driven_actuators])
        self._configuration, self._speeds = np.zeros((k, robot.coordinates)), np.zeros((k, len(robot.driven_actuators)))

    def _load_arms(self) -> list[int]:
        arms = []
        with temporary_folder("pybullet") as folder:
            path = folder / "robot.urdf"
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
        """Find Bullet's indices of the joints with a coordinate and of those with a motor, and the owners of its links.

        Bullet numbers joints as the links that they move, and knows links by name.
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
        """Remove the motors and losses that Bullet gives every joint and link by default, and set collision groups."""
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
        """Friction coefficient of one of Bullet's links."""
        wheel = self._robot.links[self._wheels[link]].wheel if link in self._wheels else None
        return self._robot.friction if wheel is None else wheel.friction

    def vary(self, arms: Sequence[int], variation: Variation) -> None:
        """Vary some robots, see `pipenav.backends.Simulator.vary`."""
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
        """Reset some robots, see `pipenav.backends.Backend.reset`.

        Returns:
            Distances along the beams of these robots, (len(arms), beams) [m].
        """
        for row, i in enumerate(arms):
            self._walls.surround(i, pipes[row], base[row])
            wheels = [(wheel, 0.0) for wheel in self._wheels]
            for joint, position in [*zip(self._coordinates, q[row], strict=True), *wheels]:
                pybullet.resetJointState(self._arms[i], joint, position, 0.0, physicsClientId=self._client)
            self._configuration[i], self._speeds[i] = q[row], 0.0
        return self._distances(list(arms))

    def pull(self, forces: Floats) -> None:
        """Let forces (k, 2) [N] act on the robots' rear ends until other ones are given."""
        self._pulled = forces

    def _apply_pull(self) -> None:
        """Let the forces act in the next physics step: Bullet forgets them after each."""
        for i in np.flatnonzero(self._pulled.any(axis=1)):
            rear = [*self._configuration[i, :2], i * STOREY]
            pybullet.applyExternalForce(
                self._arms[i],
                self._bodies[0],
                [*self._pulled[i], 0.0],
                rear,
                pybullet.WORLD_FRAME,
                physicsClientId=self._client,
            )

    def step(self, control: Control, values: Floats) -> Motion:
        """Advance all robots by one control period under duties or set-points, see `pipenav.backends.Command`."""
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
            self._apply_pull()
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
        """Quantities that the on-board controllers control: positions of joints, speeds of wheels, (k, actuators)."""
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
            _, body_a, body_b, link_a, link_b, _, _, normal, distance, push, drag1, along1, drag2, along2 = contact
            arm, link, sign = (body_a, link_a, 1.0) if body_a in self._storey else (body_b, link_b, -1.0)
            if push <= 0.0 and distance >= 0.0:
                continue  # foreseen, but it did not happen
            i, link = self._storey[arm], self._link_of[link]
            for axis in (0, 1):  # Bullet gives what acts on its body A
                force = push * normal[axis] + drag1 * along1[axis] + drag2 * along2[axis]
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
        directions = np.stack([np.cos(headings), np.sin(headings)], axis=-1).reshape(-1, 2)
        reach = laser.range_max + laser.resolution
        rays = [np.column_stack([xy, height]).tolist() for xy in (start, start + reach * directions)]
        hits = pybullet.rayTestBatch(*rays, numThreads=1, physicsClientId=self._client)
        fractions = np.array([hit[2] if hit[0] >= 0 else np.inf for hit in hits])
        return np.asarray(reach * fractions.reshape(headings.shape))

    def close(self) -> None:
        pybullet.disconnect(physicsClientId=self._client)
