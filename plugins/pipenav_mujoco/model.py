"""The MuJoCo model of a robot and the walls around it, built from RobotSpec and Pipe."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from pipenav.pipe import Pipe
from pipenav.robot import BoxPart, Link, RobotSpec
from pipenav.wall_boxes import OUTER_THICKNESS, PARKED, WALL_HALF_HEIGHT, wall_boxes

Array = NDArray[np.float64]

ROBOT, WALL = 1, 2
"""Collision groups: links meet walls only, never each other."""

HIDDEN_GROUP = 3
"""Geom group that MuJoCo's viewers do not draw unless asked."""

MAX_HALF_LENGTH = 10.5
"""Half length that bounding volumes are computed for [m]; the longest leg is 20 m."""


class Contact(NamedTuple):
    """Contact parameters, see the backend's Options."""

    time_constant: float
    impedance: tuple[float, float, float]


def build_spec(robot: RobotSpec, slots: int, timestep: float, contact: Contact) -> Any:
    """An MjSpec of the robot among `slots` wall boxes on mocap bodies, parked until a reset places them."""
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.option.timestep = timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # Pyramidal cones turned some sideways pushes against a wall into spikes of a thousand newtons.
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    # Bodies have few geoms, so a bounding-volume tree within bodies is only overhead (a fifth of a step).
    # A state that is not finite must be seen, not silently replaced by a fresh one.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_MIDPHASE | mujoco.mjtDisableBit.mjDSBL_AUTORESET
    spec.option.gravity = [0.0, 0.0, 0.0]  # the arm lies in a plane, carried by its rails (thesis 4.2.1)
    spec.compiler.degree = False
    spec.add_material(name="wall", rgba=[0.7, 0.72, 0.75, 1.0])
    _add_robot(spec, robot, contact)
    for i in range(slots):
        body = spec.worldbody.add_body(name=f"wall{i}", mocap=True, pos=[0, 0, PARKED])
        _add_wall_geom(body, f"wall{i}", [MAX_HALF_LENGTH, OUTER_THICKNESS, WALL_HALF_HEIGHT], robot, contact)
    _add_sensors(spec, robot)
    return spec


def static_spec(robot: RobotSpec, pipe: Pipe, timestep: float, contact: Contact, base: float = 0.0) -> Any:
    """The same model with this pipe's walls as static geoms: the reference that the mocap walls are tested against."""
    spec = build_spec(robot, 0, timestep, contact)
    boxes = wall_boxes([pipe], len(pipe.segments), np.array([base]))
    for i, (position, quaternion, half_size, _) in enumerate(zip(*(part[0] for part in boxes), strict=True)):
        geom = _add_wall_geom(spec.worldbody, f"wall{i}", half_size, robot, contact)
        geom.pos, geom.quat = position, quaternion
    return spec


def _add_robot(spec: Any, robot: RobotSpec, contact: Contact) -> None:
    parent = spec.worldbody
    offset = 0.0
    for link, actuator in zip(robot.links, robot.joint_actuators, strict=True):
        body = parent.add_body(name=link.name, pos=[offset, 0, 0])
        hinge = link.joint.type == "hinge"
        body.add_joint(
            name=link.joint.name,
            type=mujoco.mjtJoint.mjJNT_HINGE if hinge else mujoco.mjtJoint.mjJNT_SLIDE,
            axis=[0, 0, 1] if hinge else [1, 0, 0],
            range=[link.joint.lower, link.joint.upper],
            limited=True,
            damping=actuator.damping,
            armature=actuator.armature,
        )
        _add_link_geoms(body, link, robot, contact)
        spec.add_actuator(
            name=link.joint.name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            target=link.joint.name,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
            forcelimited=True,
            forcerange=[-actuator.effort_limit, actuator.effort_limit],
        )
        parent, offset = body, link.length
    parent.add_site(name="tip", pos=[robot.links[-1].length, 0, 0])


def _add_link_geoms(body: Any, link: Link, robot: RobotSpec, contact: Contact) -> None:
    """The link's parts. A disc meets upright walls as the ball of its diameter does, which is exact and fast."""
    density = link.mass / sum(part.volume for part in link.parts)
    touching = {"contype": ROBOT, "conaffinity": WALL, **_surface(robot, contact)}
    for i, part in enumerate(link.parts):
        name, place, mass = f"{link.name}_{i}", [part.x, part.y, 0], density * part.volume
        if isinstance(part, BoxPart):
            size = [part.length / 2, part.width / 2, part.height / 2]
            body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_BOX, pos=place, size=size, mass=mass, **touching)
            continue
        radius = part.diameter / 2
        kind, seen = mujoco.mjtGeom.mjGEOM_CYLINDER, {"contype": 0, "conaffinity": 0}
        body.add_geom(name=f"{name}_seen", type=kind, pos=place, size=[radius, part.height / 2, 0], mass=mass, **seen)
        ball, hidden = mujoco.mjtGeom.mjGEOM_SPHERE, {"group": HIDDEN_GROUP}
        body.add_geom(name=name, type=ball, pos=place, size=[radius, 0, 0], mass=0, **hidden, **touching)


def _add_wall_geom(body: Any, name: str, half_size: Any, robot: RobotSpec, contact: Contact) -> Any:
    return body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=half_size,
        material="wall",
        contype=WALL,
        conaffinity=ROBOT,
        **_surface(robot, contact),
    )


def _surface(robot: RobotSpec, contact: Contact) -> dict[str, Any]:
    return {
        "friction": [robot.friction, 0.0, 0.0],
        "condim": 3,
        "solref": [contact.time_constant, 1.0],
        "solimp": [*contact.impedance, 0.5, 2.0],
    }


def _add_sensors(spec: Any, robot: RobotSpec) -> None:
    """Per link the net force of the walls, then the depth of the deepest contact."""
    kind, reduce = mujoco.mjtSensor.mjSENS_CONTACT, {"mindist": 1, "netforce": 3}
    force, dist = 1 << 1, 1 << 3
    for link in robot.links:
        spec.add_sensor(
            name=f"force_{link.name}",
            type=kind,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            objname=link.name,
            reftype=mujoco.mjtObj.mjOBJ_UNKNOWN,
            intprm=[force, reduce["netforce"], 1],
        )
    spec.add_sensor(
        name="depth",
        type=kind,
        objtype=mujoco.mjtObj.mjOBJ_UNKNOWN,
        reftype=mujoco.mjtObj.mjOBJ_UNKNOWN,
        intprm=[dist, reduce["mindist"], 1],
    )
