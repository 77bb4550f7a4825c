"""Physics engines that load an exported pipe and count the contacts of a ball at given points."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import pytest

from pipenav.arrays import Floats


def mujoco_contacts(file: Path, points: Floats, radius: float) -> list[int]:
    """Contacts in MuJoCo, which loads MJCF and imports URDF."""
    spec = mujoco.MjSpec.from_file(str(file))
    ball = spec.worldbody.add_body(name="ball")
    ball.add_freejoint()
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0])
    return contacts_of_free_body(spec.compile(), points)


def contacts_of_free_body(model: Any, points: Floats) -> list[int]:
    """Contacts in a MuJoCo model whose first joint is the ball's."""
    data, counts = mujoco.MjData(model), []
    for point in points:
        data.qpos[:3] = point
        mujoco.mj_forward(model, data)
        counts.append(data.ncon)
    return counts


def bullet_contacts(file: Path, points: Floats, radius: float) -> list[int]:
    """Contacts in Bullet, which loads URDF."""
    bullet = pytest.importorskip("pybullet")
    client, counts = bullet.connect(bullet.DIRECT), []
    try:
        pipe = bullet.loadURDF(str(file), physicsClientId=client)
        sphere = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=radius, physicsClientId=client)
        ball = bullet.createMultiBody(1.0, sphere, physicsClientId=client)
        for point in points:
            bullet.resetBasePositionAndOrientation(ball, point, [0, 0, 0, 1], physicsClientId=client)
            counts.append(len(bullet.getClosestPoints(ball, pipe, 0.0, physicsClientId=client)))
    finally:
        bullet.disconnect(client)
    return counts


def drake_contacts(file: Path, points: Floats, radius: float) -> list[int]:
    """Contacts in Drake, which loads URDF and SDF and takes every mesh for its convex hull."""
    pytest.importorskip("pydrake")
    from pydrake.geometry import Sphere
    from pydrake.math import RigidTransform
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
    from pydrake.multibody.tree import SpatialInertia, UnitInertia
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(builder, 0.001)
    (pipe,) = Parser(plant).AddModels(str(file))
    own = plant.AddModelInstance("ball")
    ball = plant.AddRigidBody("ball", own, SpatialInertia(1, [0, 0, 0], UnitInertia.SolidSphere(radius)))
    plant.RegisterCollisionGeometry(ball, RigidTransform(), Sphere(radius), "ball", CoulombFriction(1, 1))
    if file.suffix == ".urdf":  # of a static model, which URDF has no word for
        plant.WeldFrames(plant.world_frame(), plant.GetBodyByName("pipe", pipe).body_frame())
    plant.Finalize()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    moved, seen = plant.GetMyMutableContextFromRoot(context), scene.GetMyContextFromRoot(context)
    counts = []
    for point in points:
        plant.SetFreeBodyPose(moved, ball, RigidTransform(point))
        counts.append(len(scene.get_query_output_port().Eval(seen).ComputePointPairPenetration()))
    return counts


CONTACTS = {
    "MuJoCo, MJCF": ("pipe.xml", mujoco_contacts),
    "MuJoCo, URDF": ("pipe.urdf", mujoco_contacts),
    "Bullet, URDF": ("pipe.urdf", bullet_contacts),
    "Drake, URDF": ("pipe.urdf", drake_contacts),
    "Drake, SDF": ("pipe.sdf", drake_contacts),
}
"""File that each engine loads, and the function that counts contacts in it."""
