"""MuJoCo model of a robot in space, in one route of pipe: walls of boxes, a free base, the roll joint."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import mujoco

from pipenav.pipes import PipeRoute
from pipenav.robots import Actuator, BoxPart, Link, RobotSpec, Roll, Wheel
from pipenav_mujoco.model import (
    HIDDEN_GROUP,
    ROBOT_TOUCHES,
    Contact,
    add_driven_joint,
    add_sensors,
    add_servo,
    new_spec,
    surface,
)
from pipenav_mujoco.space_walls import Layout, add_walls

FRONT = "_front"
"""Suffix of the divided link's name for its front half."""


class Stretch(NamedTuple):
    """Stretch of a link from `start` to `end` along it, in a body whose frame stands at `origin` along it [m]."""

    start: float
    end: float
    origin: float = 0.0


def space_spec(robot: RobotSpec, route: PipeRoute, layout: Layout, timestep: float, contact: Contact) -> Any:
    """MjSpec of the robot in the route, with room for the walls of a layout; nothing weighs."""
    assert robot.roll is not None
    spec = new_spec(robot, timestep)
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE  # a contact moves part of the chain: a tenth faster
    # With sleep MuJoCo computes the places of walls once, instead of in every step; the robot itself never sleeps.
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    parent, offset = spec.worldbody, 0.0
    for link in robot.links:
        body = parent.add_body(name=link.name, pos=[offset, 0, 0])
        if link.joint is None:
            body.add_freejoint(name="base")
            body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_NEVER
        else:
            add_driven_joint(body, link.joint, robot.actuators[link.joint.actuator])
        if link.wheel is not None:
            _add_wheel(body, link.wheel, robot, route.radius, contact)
        if link.name == robot.roll.link:
            parent, offset = _add_halves(body, link, robot.roll, robot, contact), link.length - robot.roll.x
        else:
            _add_boxes(body, link, Stretch(0.0, link.length), surface(robot.friction, contact))
            parent, offset = body, link.length
    for part, actuator in zip(robot.commanded_parts, robot.driven_actuators, strict=True):
        add_servo(spec, part, actuator)
    add_servo(spec, robot.roll.joint, roll_actuator(robot))
    parent.add_site(name="tip", pos=[offset, 0, 0])
    _add_gyroscopes(spec, [robot.roll.link, robot.roll.link + FRONT])
    add_walls(spec, robot, route, contact, layout)
    _add_pairs(spec, layout.pairs, contact)
    add_sensors(spec, [*(link.name for link in robot.links), robot.roll.link + FRONT, *(w.name for w in robot.wheels)])
    return spec


def _add_pairs(spec: Any, count: int, contact: Contact) -> None:
    """Add room for pairs of geoms that meet; which ones is written into the compiled model."""
    two = spec.geoms[-2:]
    for geom, name in zip(two, ("wall0", "wall1"), strict=True):
        geom.name = geom.name or name
    ref, impedance = [contact.time_constant, 1.0], [*contact.impedance, 0.5, 2.0]
    for _ in range(count):
        spec.add_pair(
            geomname1=two[0].name,
            geomname2=two[1].name,
            condim=3,
            solref=ref,
            solimp=impedance,
            friction=[0.0] * 5,
        )


def _add_gyroscopes(spec: Any, bodies: list[str]) -> None:
    for name in bodies:
        spec.body(name).add_site(name=f"gyroscope_{name}")
        kind, site = mujoco.mjtSensor.mjSENS_GYRO, mujoco.mjtObj.mjOBJ_SITE
        spec.add_sensor(name=f"gyroscope_{name}", type=kind, objtype=site, objname=f"gyroscope_{name}")


def roll_actuator(robot: RobotSpec) -> Actuator:
    """Motor of the roll joint."""
    assert robot.roll is not None
    return robot.actuators[robot.roll.joint.actuator]


def _add_halves(body: Any, link: Link, roll: Roll, robot: RobotSpec, contact: Contact) -> Any:
    """Add both halves of the divided link: the rear one to its body, the front one as a body that turns on it."""
    front = body.add_body(name=link.name + FRONT, pos=[roll.x, 0, 0])
    add_driven_joint(front, roll.joint, robot.actuators[roll.joint.actuator], axis=(1, 0, 0))
    of_link = surface(robot.friction, contact)
    _add_boxes(body, link, Stretch(0.0, roll.x), of_link)
    _add_boxes(front, link, Stretch(roll.x, link.length, origin=roll.x), of_link)
    return front


def _add_boxes(body: Any, link: Link, stretch: Stretch, surface: dict[str, Any]) -> None:
    """Add the parts of a stretch of a link to its body; a disc counts as its box."""
    density = link.mass / sum(part.volume for part in link.parts)
    for i, part in enumerate(link.parts):
        long = part.length if isinstance(part, BoxPart) else part.diameter
        low, high = max(stretch.start, part.x - long / 2), min(stretch.end, part.x + long / 2)
        if low >= high:
            continue
        body.add_geom(
            name=f"{body.name}_{i}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=[(low + high) / 2 - stretch.origin, part.y, 0],
            size=[(high - low) / 2, part.width / 2, part.height / 2],
            mass=density * part.volume * (high - low) / long,
            **ROBOT_TOUCHES,
            **surface,
        )


def _add_wheel(link: Any, wheel: Wheel, robot: RobotSpec, radius: float, contact: Contact) -> None:
    """Add a wheel as a body that meets the wall with two balls on its axle: they keep it upright, as a tread does.

    The balls touch a round bore of this radius [m] where the edges of the tread do, which stand on a chord of it.
    """
    actuator = robot.actuators[wheel.actuator]
    body = link.add_body(name=wheel.name, pos=[wheel.x, 0, 0])
    add_driven_joint(body, wheel, actuator, axis=(0, 0, 1))
    size = [wheel.radius, wheel.height / 2, 0]
    seen = {"contype": 0, "conaffinity": 0}
    body.add_geom(name=f"{wheel.name}_seen", type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=size, mass=wheel.mass, **seen)
    half = wheel.height / 2
    chord = math.sqrt(radius**2 - half**2)  # from the axis to the chord
    away, ball = half * (1 - wheel.radius / chord), wheel.radius * radius / chord
    for sign in (-1, 1):
        body.add_geom(
            name=f"{wheel.name}_{sign}",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            pos=[0, 0, sign * away],
            size=[ball, 0, 0],
            mass=0,
            group=HIDDEN_GROUP,
            **ROBOT_TOUCHES,
            **surface(wheel.friction, contact),
        )
