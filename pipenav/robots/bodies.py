"""Rigid bodies of a robot: what each link and wheel weighs, where, and how hard it is to turn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from pipenav.robots.parts import Actuator, BoxPart, DiscPart, Joint, Link, Wheel
from pipenav.robots.robot import RobotSpec

FRONT = "_front"
"""Suffix of the divided link's name for the half in front of the roll joint."""

Axis = tuple[int, int, int]
ALONG, ACROSS = (1, 0, 0), (0, 0, 1)
"""Axes of joints in a link's frame: slides and the roll joint along x, bending joints and wheels along z."""


class Piece(NamedTuple):
    """A part of a body with its mass [kg]."""

    part: BoxPart | DiscPart
    mass: float


class Inertia(NamedTuple):
    """Mass properties of a body in its frame; its centre of mass lies in the plane z = 0.

    Attributes:
        mass: mass [kg].
        x, y: centre of mass [m].
        xx, yy, zz, xy: moments and product of inertia about the centre of mass, along the frame's axes [kg m^2].
    """

    mass: float
    x: float
    y: float
    xx: float
    yy: float
    zz: float
    xy: float


class BodyNode(NamedTuple):
    """A body in the tree of a robot's bodies.

    Attributes:
        name: name of the link or wheel.
        parent: name of the body that it hangs on; None for the first link.
        offset: where its frame lies on the parent's x axis at rest [m].
        joint: joint by which it moves against its parent; a wheel is its own; None for the first link of a free robot.
        axis: axis of that joint.
        pieces: its parts.
        actuator: the joint's motor; None without a joint.
        friction: Coulomb friction coefficient against a pipe.
    """

    name: str
    parent: str | None
    offset: float
    joint: Joint | Wheel | None
    axis: Axis
    pieces: list[Piece]
    actuator: Actuator | None
    friction: float


def link_pieces(link: Link) -> list[Piece]:
    """Parts of a link, all of one density."""
    parts = link.parts
    volume = sum(part.volume for part in parts)
    return [Piece(part, link.mass * part.volume / volume) for part in parts]


def wheel_pieces(wheel: Wheel) -> list[Piece]:
    """The wheel as a disc about its axle."""
    return [Piece(wheel.disc.model_copy(update={"x": 0.0}), wheel.mass)]


def inertia(pieces: Sequence[Piece], mass: float | None = None) -> Inertia:
    """Mass properties of pieces that move as one: solid cuboids and cylinders, and Steiner's theorem.

    Args:
        pieces: the pieces.
        mass: mass of all of them [kg], by default the sum.
    """
    mass = sum(piece.mass for piece in pieces) if mass is None else mass
    x = sum(piece.mass * piece.part.x for piece in pieces) / mass
    y = sum(piece.mass * piece.part.y for piece in pieces) / mass
    xx = yy = zz = xy = 0.0
    for part, own in pieces:
        dx, dy = part.x - x, part.y - y
        if isinstance(part, BoxPart):
            about_x, about_y = (part.width**2 + part.height**2) / 12, (part.length**2 + part.height**2) / 12
            about_z = (part.length**2 + part.width**2) / 12
        else:
            about_x = about_y = part.diameter**2 / 16 + part.height**2 / 12
            about_z = part.diameter**2 / 8
        xx += own * (about_x + dy**2)
        yy += own * (about_y + dx**2)
        zz += own * (about_z + dx**2 + dy**2)
        xy -= own * dx * dy
    return Inertia(mass, x, y, xx, yy, zz, xy)


def robot_bodies(robot: RobotSpec) -> list[BodyNode]:
    """All bodies, parents first: links, wheels after their links, and the front half of a link that a roll divides."""
    nodes: list[BodyNode] = []
    parent: str | None = None
    offset = 0.0
    for link in robot.links:
        rear = link_pieces(link)
        front: list[Piece] = []
        roll = robot.roll if robot.roll and robot.roll.link == link.name else None
        if roll:
            rear, front = divided(rear, roll.x)
        slides = link.joint is not None and link.joint.type == "slide"
        motor = robot.actuators[link.joint.actuator] if link.joint else None
        axis = ALONG if slides else ACROSS
        nodes.append(BodyNode(link.name, parent, offset, link.joint, axis, rear, motor, robot.friction))
        if link.wheel is not None:
            wheel, motor = link.wheel, robot.actuators[link.wheel.actuator]
            pieces = wheel_pieces(wheel)
            nodes.append(BodyNode(wheel.name, link.name, wheel.x, wheel, ACROSS, pieces, motor, wheel.friction))
        parent, offset = link.name, link.length
        if roll:
            motor, half = robot.actuators[roll.joint.actuator], link.name + FRONT
            nodes.append(BodyNode(half, link.name, roll.x, roll.joint, ALONG, front, motor, robot.friction))
            parent, offset = half, link.length - roll.x
    return nodes


def divided(pieces: Sequence[Piece], at: float) -> tuple[list[Piece], list[Piece]]:
    """Pieces behind and in front of a cut across a link [m], those in front seen from it; a cut disc is a box."""
    rear, front = list[Piece](), list[Piece]()
    for piece in pieces:
        part = piece.part
        long = part.length if isinstance(part, BoxPart) else part.diameter
        low, high = part.x - long / 2, part.x + long / 2
        if high <= at:
            rear.append(piece)
        elif low >= at:
            front.append(Piece(part.model_copy(update={"x": part.x - at}), piece.mass))
        else:
            rear.append(_cut(piece, low, at, 0.0))
            front.append(_cut(piece, at, high, at))
    return rear, front


def _cut(piece: Piece, low: float, high: float, origin: float) -> Piece:
    """A stretch of a piece as a box, with its share of the mass."""
    part = piece.part
    long = part.length if isinstance(part, BoxPart) else part.diameter
    middle, width, height = (low + high) / 2 - origin, part.width, part.height
    box = BoxPart.model_construct(x=middle, y=part.y, length=high - low, width=width, height=height)  # thinner than any
    return Piece(box, piece.mass * (high - low) / long)
