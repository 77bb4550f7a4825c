"""A robot as URDF, the description that Bullet loads."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from pipenav.robot import Link, RobotSpec

Array = NDArray[np.float64]
ROTOR_SHARE = 0.75
"""Share of a hinge's rotor that its link carries [1].

A rotor behind a gear resists the motion of its joint alone, which no rigid body of a chain does: a link carries it for
the joints before it as well. All of it would make the first hinge too slow; with less than this the losses of the
motors, which Bullet is given as explicit efforts, become unstable at a physics step of 2.5 ms. Free motion then stays
within 0.03 rad of an exact model's.
"""


def robot_urdf(robot: RobotSpec) -> str:
    """The robot on a fixed mount; links and joints in order, each link's frame at its joint.

    Bullet knows neither a rotor's inertia nor a motor's torque-speed line: the one is added to the links
    (`link_masses`, `link_inertias`), the other is applied by the world as efforts.
    """
    root = ElementTree.Element("robot", name=robot.name)
    _add_inertia(ElementTree.SubElement(root, "link", name="mount"), "0 0 0", 1.0, 1.0)  # fixed: any will do
    masses, inertias = link_masses(robot), link_inertias(robot)
    parent, offset = "mount", 0.0
    for i, (link, actuator) in enumerate(zip(robot.links, robot.joint_actuators, strict=True)):
        _add_link(root, link, masses[i], inertias[i])
        hinge = link.joint.type == "hinge"
        kind = "revolute" if hinge else "prismatic"
        joint = ElementTree.SubElement(root, "joint", name=link.joint.name, type=kind)
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=link.name)
        ElementTree.SubElement(joint, "origin", xyz=f"{offset!r} 0 0")
        ElementTree.SubElement(joint, "axis", xyz="0 0 1" if hinge else "1 0 0")
        ElementTree.SubElement(joint, "dynamics", damping="0", friction="0")  # the world applies the motor's
        limits = {"lower": link.joint.lower, "upper": link.joint.upper}
        bounds = limits | {"effort": actuator.effort_limit, "velocity": actuator.speed_limit}
        ElementTree.SubElement(joint, "limit", {key: repr(value) for key, value in bounds.items()})
        parent, offset = link.name, link.length
    return ElementTree.tostring(root, encoding="unicode")


def _add_link(root: ElementTree.Element, link: Link, mass: float, inertia: float) -> None:
    element = ElementTree.SubElement(root, "link", name=link.name)
    centre = f"{link.length / 2!r} 0 0"
    _add_inertia(element, centre, mass, inertia)
    collision = ElementTree.SubElement(element, "collision")
    ElementTree.SubElement(collision, "origin", xyz=centre)
    geometry = ElementTree.SubElement(collision, "geometry")
    ElementTree.SubElement(geometry, "box", size=f"{link.length!r} {link.width!r} {link.height!r}")


def _add_inertia(element: ElementTree.Element, centre: str, mass: float, inertia: float) -> None:
    inertial = ElementTree.SubElement(element, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=centre)
    ElementTree.SubElement(inertial, "mass", value=repr(float(mass)))
    moment = repr(float(inertia))  # the robot moves in a plane, so that only the one about z is ever felt
    zero = dict.fromkeys(("ixy", "ixz", "iyz"), "0")
    ElementTree.SubElement(inertial, "inertia", {"ixx": moment, "iyy": moment, "izz": moment} | zero)


def link_masses(robot: RobotSpec) -> Array:
    """Mass of each link with the rotor of its slide, (links,) [kg]."""
    actuators = zip(robot.links, robot.joint_actuators, strict=True)
    return np.array([link.mass + (a.armature if link.joint.type == "slide" else 0.0) for link, a in actuators])


def link_inertias(robot: RobotSpec) -> Array:
    """Moment of inertia of each link about its centre and z, with its share of the rotor, (links,) [kg m^2]."""
    hinged = np.array([link.joint.type == "hinge" for link in robot.links])
    own = np.array([link.mass * (link.length**2 + link.width**2) / 12 for link in robot.links])
    rotors = np.array([actuator.armature for actuator in robot.joint_actuators])
    return np.asarray(own + ROTOR_SHARE * np.where(hinged, rotors, 0.0))
