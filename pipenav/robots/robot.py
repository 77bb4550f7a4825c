"""A robot as its `robot.toml` describes it, each physical number once."""

from __future__ import annotations

import re
from functools import cached_property
from pathlib import Path
from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, Field, ValidationError, model_validator

from pipenav.arrays import Flags, Floats, Table
from pipenav.errors import ConfigError, UnknownName, first_problem
from pipenav.robots.joint_types import resolve_types
from pipenav.robots.parts import Actuator, Joint, Laser, Link, Name, Roll, Wheel, constant
from pipenav.robots.variants import completed, robot_names
from pipenav.storage import shipped
from pipenav.storage.text_files import read_toml

BASE = ("x", "y", "heading")
"""Coordinates that a free robot has before its joints: pose of the rear end of its first link [m, m, rad]."""


MOST_LINKS = 40
"""Most links of a robot: several times the longest that goes through pipes."""

TAKEN_NAMES = re.compile(r"world|tip|wall\d*|base_\w*|\w*_(seen|\d+)")
"""Names that models give to parts of their own."""


class RobotSpec(Table):
    """A planar chain of links, from the rear to the one that carries the laser.

    The first link hangs by its joint on a mount in the first leg, or has none: then the robot stands on its wheels and
    is free to move in its plane. A robot's configuration says where all of it is: the joint positions, and before
    them the pose of the first link if the robot is free.
    """

    schema_version: Literal[1]
    name: Name
    description: str
    source: str
    friction: float = Field(ge=0, le=2, description="Coulomb friction coefficient between robot and pipe")
    friction_source: str
    links: tuple[Link, ...] = Field(min_length=1, max_length=MOST_LINKS, strict=False)
    roll: Roll | None = None
    actuators: dict[str, Actuator]
    laser: Laser

    @model_validator(mode="after")
    def _named(self) -> Self:
        parts: list[Joint | Wheel] = [*self.joints, *self.wheels, *([self.roll.joint] if self.roll else [])]
        for part in parts:
            if part.actuator not in self.actuators:
                kind = "wheel" if isinstance(part, Wheel) else "joint"
                raise ValueError(f"{kind} {part.name!r} names actuator {part.actuator!r}, which is not described")
        if len({part.name for part in parts}) < len(parts):
            raise ValueError("joint names must differ")
        bodies = [link.name for link in self.links] + [wheel.name for wheel in self.wheels]
        if len(set(bodies)) < len(bodies):
            raise ValueError("names of links and wheels must differ")
        for name in [*bodies, *(part.name for part in parts)]:
            if TAKEN_NAMES.fullmatch(name):
                raise ValueError(f"the name {name!r} is taken by a part of the models: choose another")
        if self.roll and self.roll.link not in [link.name for link in self.links]:
            raise ValueError(f"the roll joint divides link {self.roll.link!r}, which is not described")
        if self.roll and any(link.name == self.roll.link and self.roll.x > link.length for link in self.links):
            raise ValueError(f"the roll joint lies {self.roll.x:g} m along link {self.roll.link!r}, which is shorter")
        return self

    @model_validator(mode="after")
    def _chained(self) -> Self:
        for link in self.links[1:]:
            if link.joint is None:
                raise ValueError(f"link {link.name!r} has no joint: only the first link may stand free")
        return self

    @property
    def free(self) -> bool:
        """Whether no mount holds the first link."""
        return self.links[0].joint is None

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Joints of the links, in order."""
        return tuple(link.joint for link in self.links if link.joint is not None)

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """Wheels of the links, in order."""
        return tuple(link.wheel for link in self.links if link.wheel is not None)

    @property
    def coordinates(self) -> int:
        """Number of coordinates of a configuration."""
        return len(BASE) * self.free + len(self.joints)

    @property
    def joint_actuators(self) -> tuple[Actuator, ...]:
        """Actuators of the joints, in order."""
        return tuple(self.actuators[joint.actuator] for joint in self.joints)

    @property
    def commanded_parts(self) -> tuple[Joint | Wheel, ...]:
        """Commanded parts: the joints, then the wheels."""
        return self.joints + self.wheels

    @property
    def driven_actuators(self) -> tuple[Actuator, ...]:
        """Actuators of the commanded parts, in order."""
        return tuple(self.actuators[part.actuator] for part in self.commanded_parts)

    @property
    def length(self) -> float:
        """Length of the straight robot, from the first link's rear end to the tip [m]."""
        return sum(link.length for link in self.links)

    @property
    def width(self) -> float:
        """Width of the widest link or wheel [m]."""
        return max([link.width for link in self.links] + [wheel.diameter for wheel in self.wheels])

    @cached_property
    def wheel_joints(self) -> list[int]:
        """Index of the joint that each wheel sits on, (wheels,)."""
        jointed = [link for link in self.links if link.joint is not None]
        return [i for i, link in enumerate(jointed) if link.wheel is not None]

    @cached_property
    def hinges(self) -> Flags:
        """Flags of the joints that are hinges, (joints,)."""
        return np.array([joint.type == "hinge" for joint in self.joints])

    @cached_property
    def link_turns(self) -> Flags:
        """Flags of the links that turn: on a hinge, or freely as the first link of a free robot, (links,)."""
        return np.array([link.joint is None or link.joint.type == "hinge" for link in self.links])

    @cached_property
    def lengths(self) -> Floats:
        """Lengths of the links, (links,) [m]."""
        return constant([link.length for link in self.links])

    @cached_property
    def lower(self) -> Floats:
        """Smallest positions of the joints, (joints,) [rad or m]."""
        return constant([joint.lower for joint in self.joints])

    @cached_property
    def upper(self) -> Floats:
        """Largest positions of the joints, (joints,) [rad or m]."""
        return constant([joint.upper for joint in self.joints])

    @cached_property
    def speed_limits(self) -> Floats:
        """No-load speeds of the joints, (joints,) [rad/s or m/s]."""
        return constant([actuator.speed_limit for actuator in self.joint_actuators])

    @cached_property
    def effort_limits(self) -> Floats:
        """Stall efforts of the commanded parts, (actuators,) [N m or N]."""
        return constant([actuator.effort_limit for actuator in self.driven_actuators])

    @cached_property
    def mirror_signs(self) -> Floats:
        """Factors on joint positions in a reflection about the first leg's axis: +1 slide, -1 hinge, (joints,)."""
        return constant(np.where(self.hinges, -1.0, 1.0))

    @cached_property
    def mirror_coordinates(self) -> Floats:
        """Factors on configurations in a reflection about the first leg's axis, (coordinates,)."""
        return constant([*([1.0, -1.0, -1.0] if self.free else []), *self.mirror_signs])

    @cached_property
    def mirror_actuators(self) -> Floats:
        """Factors on commands in a reflection about the first leg's axis, (actuators,).

        Joints have the factors of `mirror_signs`. Wheels have -1: reflected, they roll on their other side.
        """
        return constant([*self.mirror_signs, *[-1.0] * len(self.wheels)])


def load_robot(name: str) -> RobotSpec:
    """A shipped robot by name, or any robot by the path of its `robot.toml`; format: docs/formats/robot-file.md.

    Raises:
        UnknownName: no shipped robot has that name.
        ConfigError: the file does not fit the schema.
        FileProblem: the file cannot be read.
    """
    path = Path(name) if name.endswith(".toml") else shipped.robots_dir() / name / "robot.toml"
    if not name.endswith(".toml") and name not in robot_names():
        raise UnknownName("robot", name, robot_names())
    try:
        return RobotSpec.model_validate(resolve_types(completed(read_toml(path), str(path)), str(path)))
    except ValidationError as error:
        raise ConfigError.from_validation(str(path), error, _known_beside(error)) from error


def _known_beside(error: ValidationError) -> list[str]:
    """Keys that exist beside the one at which pydantic found its first problem."""
    first, *rest = location = first_problem(error)["loc"][:-1] or ("",)
    tables: dict[str, type[BaseModel]] = {"links": Link, "actuators": Actuator, "laser": Laser, "roll": Roll}
    known = Joint if "joint" in rest else Wheel if "wheel" in rest else tables.get(str(first), RobotSpec)
    return [".".join(map(str, [*filter(None, map(str, location)), key])) for key in known.model_fields]
