"""A robot as URDF, the description that Bullet loads."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree import ElementTree

from pipenav.robot import RobotSpec
from pipenav.robot_parts import Actuator, BoxPart, DiscPart, Link

ROTOR_SHARE = 0.75
"""Share of a hinge's rotor that its link carries [1].

A rotor behind a gear resists the motion of its joint alone, which no rigid body of a chain does: a link carries it for
the joints before it as well. All of it would make the first hinge too slow; with less than this the losses of the
motors, which Bullet is given as explicit efforts, become unstable at a physics step of 2.5 ms. Free motion then stays
within 0.03 rad of an exact model's.
"""

DISCS = "_discs"
"""What the name of a link has behind it where it carries another link's discs."""


class Body(NamedTuple):
    """A rigid body in its link's frame: mass [kg], centre of mass [m], moment of inertia about it and z [kg m^2]."""

    mass: float
    x: float
    y: float
    inertia: float


def robot_urdf(robot: RobotSpec) -> str:
    """The robot on a fixed mount, each link's frame at its joint; the discs of a link on a further link, fixed to it.

    Bullet knows neither a rotor's inertia nor a motor's torque-speed line: the one is added to the links (`body`), the
    other is applied by the world as efforts.
    """
    root = ElementTree.Element("robot", name=robot.name)
    _add_inertial(ElementTree.SubElement(root, "link", name="mount"), Body(1.0, 0.0, 0.0, 1.0))  # fixed: any will do
    parent, offset = "mount", 0.0
    for link, driven, actuator in zip(robot.links, robot.joints, robot.joint_actuators, strict=True):
        hinge = driven.type == "hinge"
        _add_link(root, link, body(link, actuator, hinge))
        kind = "revolute" if hinge else "prismatic"
        joint = ElementTree.SubElement(root, "joint", name=driven.name, type=kind)
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=link.name)
        ElementTree.SubElement(joint, "origin", xyz=f"{offset!r} 0 0")
        ElementTree.SubElement(joint, "axis", xyz="0 0 1" if hinge else "1 0 0")
        ElementTree.SubElement(joint, "dynamics", damping="0", friction="0")
        limits = {"lower": driven.lower, "upper": driven.upper}
        bounds = limits | {"effort": actuator.effort_limit, "velocity": actuator.speed_limit}
        ElementTree.SubElement(joint, "limit", {key: repr(value) for key, value in bounds.items()})
        parent, offset = link.name, link.length
    return ElementTree.tostring(root, encoding="unicode")


def body(link: Link, actuator: Actuator, hinge: bool) -> Body:
    """A link, its parts of one density, with the rotor of its joint: of a slide as mass, of a hinge as inertia."""
    parts = link.parts
    volume = sum(part.volume for part in parts)
    masses = [link.mass * part.volume / volume for part in parts]
    x = sum(mass * part.x for mass, part in zip(masses, parts, strict=True)) / link.mass
    y = sum(mass * part.y for mass, part in zip(masses, parts, strict=True)) / link.mass
    inertia = 0.0
    for mass, part in zip(masses, parts, strict=True):
        own = (part.length**2 + part.width**2) / 12 if isinstance(part, BoxPart) else part.diameter**2 / 8
        inertia += mass * (own + (part.x - x) ** 2 + (part.y - y) ** 2)
    if not hinge:
        return Body(link.mass + actuator.armature, x, y, inertia)
    return Body(link.mass, x, y, inertia + ROTOR_SHARE * actuator.armature)


def discs(link: Link) -> list[DiscPart]:
    """The round parts of a link."""
    return [part for part in link.parts if isinstance(part, DiscPart)]


def _add_link(root: ElementTree.Element, link: Link, itself: Body) -> None:
    """The link with its boxes, and its discs on a massless link of their own, for walls of another kind."""
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
