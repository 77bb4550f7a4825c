"""MuJoCo model of a robot in the plane and of the walls around it."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np

from pipenav.backends import OUTER_THICKNESS, PARKED, WALL_HALF_HEIGHT, wall_boxes
from pipenav.errors import ConfigError, shown
from pipenav.pipes import PipeCorner
from pipenav.robots import BASE, Actuator, BoxPart, DiscPart, Joint, Link, RobotSpec, Wheel

ROBOT, WALL = 1, 2
"""Collision groups: links meet walls only, never each other."""

ROBOT_TOUCHES, WALL_TOUCHES = {"contype": ROBOT, "conaffinity": WALL}, {"contype": WALL, "conaffinity": ROBOT}
"""Collision masks of the robot's parts, and of walls."""

HIDDEN_GROUP = 3
"""Geom group that MuJoCo's viewers do not draw unless asked."""

MAX_HALF_LENGTH = 10.5
"""Half length of a wall for which bounding volumes are computed [m]; the longest leg is 20 m."""


class Contact(NamedTuple):
    """Contact parameters, see the backend's `Options`."""

    time_constant: float
    impedance: tuple[float, float, float]


def new_spec(robot: RobotSpec, timestep: float) -> Any:
    """Empty MjSpec with the settings that every model here has."""
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.option.timestep = timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # Pyramidal cones turned some sideways pushes against a wall into spikes of a thousand newtons.
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    # Bodies have few geoms, so a bounding-volume tree within bodies is only overhead (a fifth of a step).
    # One robot is one island of constraints: to look for more is only overhead (a twentieth of a step).
    # A state that is not finite must be seen, not silently replaced by a fresh one.
    off = mujoco.mjtDisableBit
    spec.option.disableflags |= off.mjDSBL_MIDPHASE | off.mjDSBL_ISLAND | off.mjDSBL_AUTORESET
    spec.option.gravity = [0.0, 0.0, 0.0]  # the arm lies in a plane, carried by its rails (thesis 4.2.1)
    spec.compiler.degree = False
    spec.add_material(name="wall", rgba=[0.7, 0.72, 0.75, 1.0])
    return spec


def compiled(spec: Any, robot: RobotSpec) -> Any:
    """The model of a specification.

    Raises:
        ConfigError: MuJoCo refuses the robot.
    """
    try:
        return spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        problem = shown(error, quoted=False, longest=300).rstrip(".")
        raise ConfigError(f"robot {robot.name!r} cannot be simulated by MuJoCo: {problem}.") from error


def build_spec(robot: RobotSpec, slots: int, timestep: float, contact: Contact) -> Any:
    """MjSpec of the robot among `slots` wall boxes on mocap bodies, parked until a reset places them."""
    spec = new_spec(robot, timestep)
    _add_robot(spec, robot, contact)
    for i in range(slots):
        body = spec.worldbody.add_body(name=f"wall{i}", mocap=True, pos=[0, 0, PARKED])
        _add_wall_geom(body, f"wall{i}", [MAX_HALF_LENGTH, OUTER_THICKNESS, WALL_HALF_HEIGHT], robot, contact)
    add_sensors(spec, [*(link.name for link in robot.links), *(wheel.name for wheel in robot.wheels)])
    return spec


def static_spec(robot: RobotSpec, pipe: PipeCorner, timestep: float, contact: Contact, base: float = 0.0) -> Any:
    """MjSpec of the robot with a pipe's walls as static geoms: the reference by which the mocap walls are tested."""
    spec = build_spec(robot, 0, timestep, contact)
    boxes = wall_boxes([pipe], len(pipe.segments), np.array([base]))
    for i, (position, quaternion, half_size, _) in enumerate(zip(*(part[0] for part in boxes), strict=True)):
        geom = _add_wall_geom(spec.worldbody, f"wall{i}", half_size, robot, contact)
        geom.pos, geom.quat = position, quaternion
    return spec


def _add_robot(spec: Any, robot: RobotSpec, contact: Contact) -> None:
    parent = spec.worldbody
    offset = 0.0
    for link in robot.links:
        body = parent.add_body(name=link.name, pos=[offset, 0, 0])
        if link.joint is None:
            _add_base(body)
        else:
            add_driven_joint(body, link.joint, robot.actuators[link.joint.actuator])
        _add_link_geoms(body, link, robot, contact)
        if link.wheel is not None:
            _add_wheel(body, link.wheel, robot.actuators[link.wheel.actuator], contact)
        parent, offset = body, link.length
    for part, actuator in zip(robot.commanded_parts, robot.driven_actuators, strict=True):
        _add_actuator(spec, part.name, actuator)
    parent.add_site(name="tip", pos=[robot.links[-1].length, 0, 0])


def _add_base(body: Any) -> None:
    """Add the joints by which a free robot moves in its plane."""
    slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
    axes = [(slide, [1, 0, 0]), (slide, [0, 1, 0]), (hinge, [0, 0, 1])]
    for name, (kind, axis) in zip(BASE, axes, strict=True):
        body.add_joint(name=f"base_{name}", type=kind, axis=axis)


def add_driven_joint(
    body: Any, part: Joint | Wheel, actuator: Actuator, axis: tuple[int, int, int] | None = None
) -> None:
    """Add the joint of a link or a wheel with its motor's damping and inertia.

    Args:
        body: body that the joint moves.
        part: the joint or wheel.
        actuator: its motor.
        axis: axis of the joint; by default x for a slide and z for all others.
    """
    slide = isinstance(part, Joint) and part.type == "slide"
    joint = body.add_joint(
        name=part.name,
        type=mujoco.mjtJoint.mjJNT_SLIDE if slide else mujoco.mjtJoint.mjJNT_HINGE,
        axis=axis or ((1, 0, 0) if slide else (0, 0, 1)),
        damping=actuator.damping,
        armature=actuator.armature,
    )
    if isinstance(part, Joint):
        joint.range, joint.limited = [part.lower, part.upper], True


def _add_actuator(spec: Any, name: str, actuator: Actuator) -> Any:
    """Add a motor at a joint or a wheel; its gains are set later."""
    return spec.add_actuator(
        name=name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=name,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        forcelimited=True,
        forcerange=[-actuator.effort_limit, actuator.effort_limit],
    )


def add_servo(spec: Any, part: Joint | Wheel, actuator: Actuator) -> None:
    """Add a motor with its on-board controller, which keeps the position of a joint or the speed of a wheel."""
    servo, gain = _add_actuator(spec, part.name, actuator), actuator.controller_gain
    servo.gainprm[0], servo.biasprm[2 if isinstance(part, Wheel) else 1] = gain, -gain


def _add_wheel(link: Any, wheel: Wheel, actuator: Actuator, contact: Contact) -> None:
    """Add a wheel as a body of its own, which turns about the axle."""
    body = link.add_body(name=wheel.name, pos=[wheel.x, 0, 0])
    add_driven_joint(body, wheel, actuator)
    disc = wheel.disc.model_copy(update={"x": 0.0})
    _add_disc(body, wheel.name, disc, wheel.mass, surface(wheel.friction, contact))


def _add_link_geoms(body: Any, link: Link, robot: RobotSpec, contact: Contact) -> None:
    density = link.mass / sum(part.volume for part in link.parts)
    of_link = surface(robot.friction, contact)
    for i, part in enumerate(link.parts):
        name, mass = f"{link.name}_{i}", density * part.volume
        if isinstance(part, BoxPart):
            size = [part.length / 2, part.width / 2, part.height / 2]
            box = {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": size, "mass": mass}
            body.add_geom(name=name, pos=[part.x, part.y, 0], **box, **ROBOT_TOUCHES, **of_link)
        else:
            _add_disc(body, name, part, mass, of_link)


def _add_disc(body: Any, name: str, disc: DiscPart, mass: float, surface: dict[str, Any]) -> None:
    """Add a disc, which meets upright walls as the ball of its diameter does: that is exact and fast."""
    place, radius = [disc.x, disc.y, 0], disc.diameter / 2
    kind, seen = mujoco.mjtGeom.mjGEOM_CYLINDER, {"contype": 0, "conaffinity": 0}
    body.add_geom(name=f"{name}_seen", type=kind, pos=place, size=[radius, disc.height / 2, 0], mass=mass, **seen)
    ball = {"type": mujoco.mjtGeom.mjGEOM_SPHERE, "size": [radius, 0, 0], "mass": 0, "group": HIDDEN_GROUP}
    body.add_geom(name=name, pos=place, **ball, **ROBOT_TOUCHES, **surface)


def _add_wall_geom(body: Any, name: str, half_size: Any, robot: RobotSpec, contact: Contact) -> Any:
    return body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=half_size,
        material="wall",
        **WALL_TOUCHES,
        **surface(robot.friction, contact),
    )


def surface(friction: float, contact: Contact) -> dict[str, Any]:
    """Surface of a robot's part or a wall. Where two touch, the larger coefficient counts: that of a wheel's tread."""
    return {
        "friction": [friction, 0.0, 0.0],
        "condim": 3,
        "solref": [contact.time_constant, 1.0],
        "solimp": [*contact.impedance, 0.5, 2.0],
    }


def add_sensors(spec: Any, bodies: list[str]) -> None:
    """Add sensors of the net force of the walls on each body, then of the depth of the deepest contact."""
    kind, reduce = mujoco.mjtSensor.mjSENS_CONTACT, {"mindist": 1, "netforce": 3}
    force, dist = 1 << 1, 1 << 3
    for body in bodies:
        spec.add_sensor(
            name=f"force_{body}",
            type=kind,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            objname=body,
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
