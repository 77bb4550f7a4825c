"""A static pipe as a scene: the parts that MJCF, URDF and SDF files of corners and of routes have in common."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO, Literal, NamedTuple

COLOUR = "0.55 0.6 0.65 1"

AT_ORIGIN = (0.0, 0.0, 0.0, 0.0)


class Shape(NamedTuple):
    """A part of the wall.

    Attributes:
        name: name of the part, unlike those of the others.
        kind: `box`, with its three sizes as text [m], or `mesh`, with its file's name.
        content: sizes or name of the file.
        pose: x, y, z [m] and the turn about z [rad].
    """

    name: str
    kind: Literal["box", "mesh"]
    content: str
    pose: tuple[float, float, float, float] = AT_ORIGIN


class MujocoScene(NamedTuple):
    """A MuJoCo model, and in it the body for the walls."""

    root: ET.Element
    body: ET.Element


def mjcf(name: str, camera: tuple[float, float, float]) -> MujocoScene:
    """A MuJoCo model without walls, with a camera `above` that looks down from a point [m].

    It has no `compiler` element and no angle, so that another model can include it and keep its own units.
    """
    root = ET.Element("mujoco", model=name)
    body = add(add(root, "worldbody"), "body", name="pipe")
    add(body, "camera", name="above", pos=text(*camera))
    return MujocoScene(root, body)


def about_z(yaw: float) -> str:
    """Turn about z by an angle [rad] as the text of a quaternion, which no `compiler` element can reinterpret."""
    return text(math.cos(yaw / 2), 0, 0, math.sin(yaw / 2))


def urdf(name: str, pieces: Sequence[Shape], seen: Sequence[Shape] | None = None) -> ET.Element:
    """A URDF model of one link without mass, which loaders take for a fixed one.

    Args:
        name: name of the model.
        pieces: parts of the wall to collide with, each convex: engines fill a mesh up to its convex hull.
        seen: parts of the wall to look at; by default the same.
    """
    root = ET.Element("robot", name=name)
    # Without it, MuJoCo looks for `walls/piece.obj` beside the model; other loaders pass over the element.
    add(add(root, "mujoco"), "compiler", strippath="false")
    add(add(root, "material", name="wall"), "color", rgba=COLOUR)
    link = add(root, "link", name="pipe")
    inertial = add(link, "inertial")
    add(inertial, "mass", value="0")
    add(inertial, "inertia", **dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0"))
    for use, shapes in (("visual", pieces if seen is None else seen), ("collision", pieces)):
        for shape in shapes:
            part = add(link, use, name=f"wall_{shape.name}")
            *xyz, yaw = shape.pose
            add(part, "origin", xyz=text(*xyz), rpy=text(0, 0, yaw))
            key = {"box": "size", "mesh": "filename"}[shape.kind]
            add(add(part, "geometry"), shape.kind, **{key: shape.content})
            if use == "visual":
                add(part, "material", name="wall")
    return root


def sdf(name: str, pieces: Sequence[Shape], seen: Sequence[Shape] | None = None) -> ET.Element:
    """A static SDF model with one link, children in the order of SDFormat's own description files.

    Args:
        name: name of the model.
        pieces: parts of the wall to collide with, each convex.
        seen: parts of the wall to look at; by default the same.
    """
    root = ET.Element("sdf", version="1.7")
    model = add(root, "model", name=name)
    add(model, "static").text = "true"
    link = add(model, "link", name="pipe")
    for use, shapes in (("collision", pieces), ("visual", pieces if seen is None else seen)):
        for shape in shapes:
            part = add(link, use, name=f"wall_{shape.name}_{use}")
            *xyz, yaw = shape.pose
            add(part, "pose").text = text(*xyz, 0, 0, yaw)
            if use == "visual":
                material = add(part, "material")
                add(material, "ambient").text = COLOUR
                add(material, "diffuse").text = COLOUR
            geometry = add(add(part, "geometry"), shape.kind)
            add(geometry, {"box": "size", "mesh": "uri"}[shape.kind]).text = shape.content
    return root


def add(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    """Append an element to its parent and return it."""
    return ET.SubElement(parent, tag, attributes)


def text(*numbers: float) -> str:
    """Numbers as an attribute's text, to nine digits."""
    return " ".join(f"{number:.9g}" for number in numbers)


def write_xml(path: Path | BinaryIO, root: ET.Element) -> None:
    """Write an element as an indented XML file, or into an open one."""
    ET.indent(root)
    ET.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
