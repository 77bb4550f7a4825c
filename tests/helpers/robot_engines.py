"""Physics engines that load an exported robot and say what they understood of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pytest

from pipenav.arrays import Floats

Positions = Mapping[str, float]
"""Positions of joints by name [rad or m]."""


class LoadedRobot(NamedTuple):
    """A robot as an engine understood it.

    Attributes:
        masses: masses of the bodies by name [kg].
        limits: lowest and highest position of every joint that has them, by name [rad or m].
        inertias: inertia matrices about the centres of mass, in the frames of the bodies, by name, (3, 3) [kg m^2].
        origins: function that gives where the frames of the bodies are, by name, (3,) [m], for positions of joints; a
            free robot's first link lies at the origin.
        contacts: function that gives the number of contacts for positions of joints; None where a URDF cannot tell the
            engine that parts of the robot pass through each other.
    """

    masses: dict[str, float]
    limits: dict[str, tuple[float, float]]
    inertias: dict[str, Floats]
    origins: Callable[[Positions], dict[str, Floats]]
    contacts: Callable[[Positions], int] | None


def in_mujoco(file: Path) -> LoadedRobot:
    """The robot in MuJoCo, which loads MJCF and imports URDF."""
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    bodies = [model.body(i) for i in range(1, model.nbody)]
    joints = [model.joint(i) for i in range(model.njnt)]

    def move(positions: Positions) -> None:
        for name, value in positions.items():
            data.joint(name).qpos[:] = value
        mujoco.mj_forward(model, data)

    def origins(positions: Positions) -> dict[str, Floats]:
        move(positions)
        return {body.name: data.body(body.name).xpos.copy() for body in bodies}

    def contacts(positions: Positions) -> int:
        move(positions)
        return int(data.ncon)

    def inertia(body: Any) -> Floats:
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, body.iquat)
        return turn.reshape(3, 3) @ np.diag(body.inertia) @ turn.reshape(3, 3).T

    limited = [joint for joint in joints if model.jnt_limited[joint.id]]
    return LoadedRobot(
        {body.name: float(body.mass[0]) for body in bodies},
        {joint.name: (float(joint.range[0]), float(joint.range[1])) for joint in limited},
        {body.name: inertia(body) for body in bodies},
        origins,
        None if file.suffix == ".urdf" else contacts,
    )


def in_bullet(file: Path) -> LoadedRobot:
    """The robot in Bullet, which loads URDF."""
    bullet = pytest.importorskip("pybullet")
    client = bullet.connect(bullet.DIRECT)
    mounted = 'link name="world"' in file.read_text()  # of a fixed base Bullet forgets the mass
    robot = bullet.loadURDF(str(file), useFixedBase=mounted, physicsClientId=client)
    base = bullet.getBodyInfo(robot, physicsClientId=client)[0].decode()
    infos = [bullet.getJointInfo(robot, i, client) for i in range(bullet.getNumJoints(robot, client))]
    links = {base: -1} | {info[12].decode(): info[0] for info in infos}
    joints = {info[1].decode(): info for info in infos}
    facts = {name: bullet.getDynamicsInfo(robot, i, client) for name, i in links.items()}

    def origins(positions: Positions) -> dict[str, Floats]:
        for name, value in positions.items():
            bullet.resetJointState(robot, joints[name][0], value, physicsClientId=client)
        states = {n: bullet.getLinkState(robot, i, 0, 1, client) for n, i in links.items() if i >= 0}
        return {name: np.array(state[4]) for name, state in states.items()}

    def contacts(positions: Positions) -> int:
        origins(positions)
        bullet.performCollisionDetection(client)
        return len(bullet.getContactPoints(robot, robot, physicsClientId=client))

    masses = {name: fact[0] for name, fact in facts.items() if name != "world"}
    limits = {name: (info[8], info[9]) for name, info in joints.items() if info[8] < info[9]}
    return LoadedRobot(masses, limits, {}, origins, contacts)


def in_drake(file: Path) -> LoadedRobot:
    """The robot in Drake, which loads URDF and, in part, MJCF."""
    pytest.importorskip("pydrake")
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(builder, 0.001)
    (own,) = Parser(plant).AddModels(str(file))
    plant.Finalize()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    moved, seen = plant.GetMyMutableContextFromRoot(context), scene.GetMyContextFromRoot(context)
    bodies = {plant.get_body(i).name(): plant.get_body(i) for i in plant.GetBodyIndices(own)}
    joints = {plant.get_joint(i).name(): plant.get_joint(i) for i in plant.GetJointIndices(own)}

    def origins(asked: Positions) -> dict[str, Floats]:
        for name, value in asked.items():
            positions = plant.GetPositions(moved)
            positions[joints[name].position_start()] = value
            plant.SetPositions(moved, positions)
        return {name: plant.EvalBodyPoseInWorld(moved, body).translation() for name, body in bodies.items()}

    def contacts(positions: Positions) -> int:
        origins(positions)
        return len(scene.get_query_output_port().Eval(seen).ComputePointPairPenetration())

    single = {name: joint for name, joint in joints.items() if joint.num_positions() == 1}
    limits = {n: (float(j.position_lower_limits()[0]), float(j.position_upper_limits()[0])) for n, j in single.items()}
    inertias = {n: b.default_spatial_inertia().Shift(b.default_com()) for n, b in bodies.items()}
    return LoadedRobot(
        {name: body.default_mass() for name, body in bodies.items()},
        {name: ends for name, ends in limits.items() if np.isfinite(ends).all()},
        {name: inertia.CalcRotationalInertia().CopyToFullMatrix3() for name, inertia in inertias.items()},
        origins,
        contacts,
    )


ENGINES: dict[str, tuple[str, Callable[[Path], LoadedRobot]]] = {
    "MuJoCo, MJCF": (".mjcf", in_mujoco),
    "MuJoCo, URDF": (".urdf", in_mujoco),
    "Bullet, URDF": (".urdf", in_bullet),
    "Drake, URDF": (".urdf", in_drake),
}
"""Suffix of the file that each engine loads, and the function that loads it."""
