"""Description of a robot as URDF, which Bullet loads."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree import ElementTree

from pipenav.robots import Actuator, BoxPart, DiscPart, Link, RobotSpec, Wheel, bodies

ROTOR_SHARE = 0.75
"""Share of a hinge's rotor that its link carries [1].

A rotor behind a gear resists the motion of its joint alone, which no rigid body of a chain does: a link that carries
the rotor resists the motion of the joints before it as well. The whole rotor would make the first hinge too slow; with
a smaller share the losses of the motors, which Bullet receives as explicit efforts, become unstable at a physics step
of 2.5 ms. With this share, free motion stays within 0.03 rad of an exact model's.
"""

DISCS = "_discs"
"""Suffix of the name of a link that carries another link's discs."""

SLIDES = ("base_x", "base_y")
"""Massless links between the mount and the first link of a free robot, which turns on the second of them."""

UNLIMITED = {"lower": "1", "upper": "-1", "effort": "0", "velocity": "0"}
"""Limits that Bullet takes for none, as the lower one is above the upper; without limits it reads no slide."""

NOTHING = 1e-9
"""Mass and inertia of links that only move other bodies [kg, kg m^2]; Bullet takes a massless link for a fixed one."""


class Body(NamedTuple):
    """Rigid body in its link's frame.

    Attributes:
        mass: mass [kg].
        x, y: centre of mass [m].
        inertia: moment of inertia about the axis through the centre of mass along z [kg m^2].
    """

    mass: float
    x: float
    y: float
    inertia: float


def robot_urdf(robot: RobotSpec) -> str:
    """URDF of the robot on a fixed mount, each link's frame at its joint, a link's discs on a further link fixed to it.

    A free robot slides along two axes of the mount and turns there, without resistance.

    Bullet knows neither a rotor's inertia nor a motor's torque-speed line: the inertia is added to the links (`body`),
    the torque-speed line is applied by the world as efforts.
    """
    root = ElementTree.Element("robot", name=robot.name)
    mount = ElementTree.SubElement(root, "link", name="mount")
    _add_inertial(mount, Body(1.0, 0.0, 0.0, 1.0))  # fixed, so that any values will do
    parent, offset = "mount", 0.0
    if robot.free:
        for name, axis in zip(SLIDES, ("1 0 0", "0 1 0"), strict=True):
            _add_inertial(ElementTree.SubElement(root, "link", name=name), Body(NOTHING, 0.0, 0.0, NOTHING))
            joint = _add_joint(root, name, "prismatic", (parent, name), 0.0, axis)
            ElementTree.SubElement(joint, "limit", UNLIMITED)
            parent = name
    for link in robot.links:
        _add_link(root, link, body(robot, link))
        if link.joint is None:
            _add_joint(root, link.name, "continuous", (parent, link.name), offset, "0 0 1")
        else:
            hinge = link.joint.type == "hinge"
            kind, axis = ("revolute", "0 0 1") if hinge else ("prismatic", "1 0 0")
            joint = _add_joint(root, link.joint.name, kind, (parent, link.name), offset, axis)
            actuator = robot.actuators[link.joint.actuator]
            limits = {"lower": link.joint.lower, "upper": link.joint.upper}
            bounds = limits | {"effort": actuator.effort_limit, "velocity": actuator.speed_limit}
            ElementTree.SubElement(joint, "limit", {key: repr(value) for key, value in bounds.items()})
        if link.wheel is not None:
            _add_wheel(root, link, link.wheel, robot.actuators[link.wheel.actuator])
        parent, offset = link.name, link.length
    return ElementTree.tostring(root, encoding="unicode")


def _add_joint(
    root: ElementTree.Element, name: str, kind: str, links: tuple[str, str], offset: float, axis: str
) -> ElementTree.Element:
    """Add a joint between a parent and a child, at an offset along the parent [m]."""
    joint = ElementTree.SubElement(root, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "parent", link=links[0])
    ElementTree.SubElement(joint, "child", link=links[1])
    ElementTree.SubElement(joint, "origin", xyz=f"{offset!r} 0 0")
    ElementTree.SubElement(joint, "axis", xyz=axis)
    ElementTree.SubElement(joint, "dynamics", damping="0", friction="0")
    return joint


def _add_wheel(root: ElementTree.Element, link: Link, wheel: Wheel, actuator: Actuator) -> None:
    """Add a wheel that carries its whole rotor: a fiftieth of a hinge's, it hardly resists any other motion."""
    element = ElementTree.SubElement(root, "link", name=wheel.name)
    own = wheel.mass * wheel.diameter**2 / 8
    _add_inertial(element, Body(wheel.mass, 0.0, 0.0, own + actuator.armature))
    _add_collision(element, wheel.disc.model_copy(update={"x": 0.0}), "sphere", radius=repr(wheel.radius))
    _add_joint(root, wheel.name, "continuous", (link.name, wheel.name), wheel.x, "0 0 1")


def body(robot: RobotSpec, link: Link) -> Body:
    """Rigid body of a link, its parts of one density, with the rotor of a slide as mass, of a hinge as inertia."""
    own = bodies.inertia(bodies.link_pieces(link), link.mass)
    if link.joint is None:  # it gets the rotor of the joint at its other end, which lies between two free bodies
        return Body(link.mass, own.x, own.y, own.zz + ROTOR_SHARE * robot.joint_actuators[0].armature)
    armature = robot.actuators[link.joint.actuator].armature
    if link.joint.type == "slide":
        return Body(link.mass + armature, own.x, own.y, own.zz)
    return Body(link.mass, own.x, own.y, own.zz + ROTOR_SHARE * armature)


def discs(link: Link) -> list[DiscPart]:
    """Round parts of a link."""
    return [part for part in link.parts if isinstance(part, DiscPart)]


def _add_link(root: ElementTree.Element, link: Link, itself: Body) -> None:
    """Add a link with its boxes, and its discs on a massless link of their own, for walls of another kind."""
    element = ElementTree.SubElement(root, "link", name=link.name)
    _add_inertial(element, itself)
    for part in link.parts:
        if isinstance(part, BoxPart):
            _add_collision(element, part, "box", size=f"{part.length!r} {part.width!r} {part.height!r}")
    if not discs(link):
        return
    name = link.name + DISCS
    element = ElementTree.SubElement(root, "link", name=name)
    _add_inertial(element, Body(0.0, 0.0, 0.0, 0.0))
    for disc in discs(link):  # it meets upright walls as the ball of its diameter does
        _add_collision(element, disc, "sphere", radius=repr(disc.diameter / 2))
    joint = ElementTree.SubElement(root, "joint", name=name, type="fixed")
    ElementTree.SubElement(joint, "parent", link=link.name)
    ElementTree.SubElement(joint, "child", link=name)


def _add_collision(element: ElementTree.Element, part: BoxPart | DiscPart, shape: str, **size: str) -> None:
    collision = ElementTree.SubElement(element, "collision")
    ElementTree.SubElement(collision, "origin", xyz=f"{part.x!r} {part.y!r} 0")
    ElementTree.SubElement(ElementTree.SubElement(collision, "geometry"), shape, size)


def _add_inertial(element: ElementTree.Element, itself: Body) -> None:
    inertial = ElementTree.SubElement(element, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=f"{itself.x!r} {itself.y!r} 0")
    ElementTree.SubElement(inertial, "mass", value=repr(itself.mass))
    moment = repr(itself.inertia)  # the robot moves in a plane, so that only the one about z is ever felt
    zero = dict.fromkeys(("ixy", "ixz", "iyz"), "0")
    ElementTree.SubElement(inertial, "inertia", {"ixx": moment, "iyy": moment, "izz": moment} | zero)
