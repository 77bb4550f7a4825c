"""A robot as one file for physics engines: URDF, which most of them read, or MuJoCo's MJCF."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from pathlib import Path

from pipenav.errors import PipenavError
from pipenav.export.scene_xml import COLOUR, add, text, write_xml
from pipenav.robots.bodies import BodyNode, Piece, inertia, robot_bodies
from pipenav.robots.parts import BoxPart, Joint, Wheel
from pipenav.robots.robot import RobotSpec
from pipenav.storage.atomic_files import atomic_write

URDF, MJCF = (".urdf",), (".mjcf", ".xml")
"""Suffixes of the two kinds of files."""

WORLD = "world"
"""Link that a mounted robot hangs on; engines take it for the world itself."""

DRAKE = "http://drake.mit.edu"
"""Namespace of Drake's own elements in a URDF, which other loaders pass over."""


def write_robot(robot: RobotSpec, path: Path) -> None:
    """Write a robot as `.urdf`, or as `.mjcf` or `.xml` for MuJoCo.

    Raises:
        PipenavError: the file's name has another ending.
        FileProblem: it cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix not in (*URDF, *MJCF):
        raise PipenavError(f"{path} must end in {', '.join((*URDF, *MJCF))}: the ending says which kind is written.")
    root = robot_urdf(robot) if suffix in URDF else robot_mjcf(robot)
    content = io.BytesIO()
    write_xml(content, root)
    atomic_write(path, content.getvalue())


def robot_urdf(robot: RobotSpec) -> ET.Element:
    """The robot as URDF; a mounted one hangs on the link `world`, a free one has no mount.

    URDF has no word for a motor's rotor: its inertia is left out. The torque-speed line of the motors is the joints'
    damping.
    """
    ET.register_namespace("drake", DRAKE)
    root = ET.Element("robot", name=robot.name)
    # Without it, MuJoCo makes one body of the world and the first link of a free robot, and mass is lost.
    add(add(root, "mujoco"), "compiler", fusestatic="false")
    add(add(root, "material", name="robot"), "color", rgba=COLOUR)
    bodies = robot_bodies(robot)
    if not robot.free:
        _add_mass(add(root, "link", name=WORLD), [])
    for body in bodies:
        link = add(root, "link", name=body.name)
        _add_mass(link, body.pieces)
        for use in ("visual", "collision"):
            for piece in body.pieces:
                shape = add(link, use)
                add(shape, "origin", xyz=text(piece.part.x, piece.part.y, 0))
                _add_shape(add(shape, "geometry"), piece)
                if use == "visual":
                    add(shape, "material", name="robot")
    for body in bodies:
        if body.joint is not None:
            _add_joint(root, body, body.joint)
    _add_filter(root, [body.name for body in bodies])
    return root


def _add_mass(link: ET.Element, pieces: list[Piece]) -> None:
    """Add mass properties; none for the world, which has no pieces."""
    inertial = add(link, "inertial")
    if not pieces:
        add(inertial, "mass", value="0")
        add(inertial, "inertia", **dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0"))
        return
    own = inertia(pieces)
    add(inertial, "origin", xyz=text(own.x, own.y, 0))
    add(inertial, "mass", value=text(own.mass))
    moments = {"ixx": own.xx, "iyy": own.yy, "izz": own.zz, "ixy": own.xy, "ixz": 0.0, "iyz": 0.0}
    add(inertial, "inertia", **{key: text(value) for key, value in moments.items()})


def _add_shape(geometry: ET.Element, piece: Piece) -> None:
    part = piece.part
    if isinstance(part, BoxPart):
        add(geometry, "box", size=text(part.length, part.width, part.height))
    else:
        add(geometry, "cylinder", radius=text(part.diameter / 2), length=text(part.height))


def _add_joint(root: ET.Element, body: BodyNode, part: Joint | Wheel) -> None:
    """Add the joint of a body and its motor."""
    assert body.actuator is not None
    slides = isinstance(part, Joint) and part.type == "slide"
    kind = "continuous" if isinstance(part, Wheel) else "prismatic" if slides else "revolute"
    joint = add(root, "joint", name=part.name, type=kind)
    add(joint, "parent", link=body.parent or WORLD)
    add(joint, "child", link=body.name)
    add(joint, "origin", xyz=text(body.offset, 0, 0))
    add(joint, "axis", xyz=text(*body.axis))
    limits = {"effort": body.actuator.effort_limit, "velocity": body.actuator.speed_limit}
    if isinstance(part, Joint):
        limits |= {"lower": part.lower, "upper": part.upper}
    add(joint, "limit", **{key: text(value) for key, value in limits.items()})
    add(joint, "dynamics", damping=text(body.actuator.damping), friction="0")
    motor = add(root, "transmission", name=f"{part.name} transmission")
    add(motor, "type").text = "transmission_interface/SimpleTransmission"
    add(motor, "joint", name=part.name)
    add(motor, "actuator", name=part.name)


def _add_filter(root: ET.Element, names: list[str]) -> None:
    """Tell Drake that links of the robot do not meet each other: wheels overlap the links that they sit between."""
    group = add(root, f"{{{DRAKE}}}collision_filter_group", name="robot")
    for name in names:
        add(group, f"{{{DRAKE}}}member", link=name)
    add(group, f"{{{DRAKE}}}ignored_collision_filter_group", name="robot")


def robot_mjcf(robot: RobotSpec) -> ET.Element:
    """The robot as MJCF, with its motors, their inertia and their on-board controllers; a free one floats.

    Nothing weighs: pipes lie level, and the robot in them. Parts of the robot do not meet each other.
    """
    root = ET.Element("mujoco", model=robot.name)
    add(root, "compiler", angle="radian", inertiafromgeom="true")
    add(root, "option", gravity="0 0 0", integrator="implicitfast", cone="elliptic")
    elements: dict[str | None, ET.Element] = {None: add(root, "worldbody")}
    motors = add(root, "actuator")
    for body in robot_bodies(robot):
        element = add(elements[body.parent], "body", name=body.name, pos=text(body.offset, 0, 0))
        elements[body.name] = element
        if body.joint is None:
            add(element, "freejoint", name="base")
        else:
            _add_motor(element, motors, body, body.joint)
        for number, piece in enumerate(body.pieces):
            _add_geom(element, f"{body.name}_{number}", piece, body.friction)
    last = [body for body in robot_bodies(robot) if not isinstance(body.joint, Wheel)][-1]
    length = robot.links[-1].length
    if robot.roll is not None and robot.roll.link == robot.links[-1].name:
        length -= robot.roll.x
    add(elements[last.name], "site", name="tip", pos=text(length, 0, 0))
    return root


def _add_motor(element: ET.Element, motors: ET.Element, body: BodyNode, part: Joint | Wheel) -> None:
    """Add the joint of a body, and its motor with the controller that keeps a position, or a wheel's speed."""
    assert body.actuator is not None
    slides = isinstance(part, Joint) and part.type == "slide"
    joint = add(element, "joint", name=part.name, type="slide" if slides else "hinge", axis=text(*body.axis))
    joint.attrib |= {"damping": text(body.actuator.damping), "armature": text(body.actuator.armature)}
    if isinstance(part, Joint):
        joint.attrib |= {"range": text(part.lower, part.upper), "limited": "true"}
    limit, gain = body.actuator.effort_limit, text(body.actuator.controller_gain)
    kind, key = ("velocity", "kv") if isinstance(part, Wheel) else ("position", "kp")
    motor = add(motors, kind, name=part.name, joint=part.name, forcelimited="true", forcerange=text(-limit, limit))
    motor.set(key, gain)


def _add_geom(element: ET.Element, name: str, piece: Piece, friction: float) -> None:
    part = piece.part
    if isinstance(part, BoxPart):
        kind, size = "box", text(part.length / 2, part.width / 2, part.height / 2)
    else:
        kind, size = "cylinder", text(part.diameter / 2, part.height / 2)
    geom = add(element, "geom", name=name, type=kind, size=size, rgba=COLOUR)
    geom.attrib |= {"pos": text(part.x, part.y, 0), "mass": text(piece.mass), "friction": text(friction, 0, 0)}
    geom.attrib |= {"contype": "1", "conaffinity": "0"}  # it meets pipes and floors, which have both by default
