"""A robot as its `robot.toml` describes it, each physical number once."""

from __future__ import annotations

import tomllib
from functools import cached_property
from pathlib import Path
from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, Field, ValidationError, model_validator

from pipenav.arrays import Flags, Floats, Table
from pipenav.errors import ConfigError, FileProblem, UnknownName
from pipenav.robots.joint_types import resolve_types
from pipenav.robots.parts import Actuator, Joint, Laser, Link, Roll, Wheel, constant
from pipenav.storage import shipped

BASE = ("x", "y", "heading")
"""Coordinates of a robot without a mount before its joints': pose of its first link's rear end [m, m, rad]."""


class RobotSpec(Table):
    """A planar chain of links, from the rear to the one that carries the laser.

    The first link hangs by its joint on a mount in the first leg, or has none: then the robot stands on its wheels and
    is free to move in its plane. A robot's configuration is where all of it is: the joint positions, and of a free
    robot the pose of its first link before them.
    """

    schema_version: Literal[1]
    name: str
    description: str
    source: str
    friction: float = Field(ge=0, le=2, description="Coulomb friction coefficient between robot and pipe")
    friction_source: str
    links: tuple[Link, ...] = Field(min_length=1, strict=False)
    roll: Roll | None = None
    actuators: dict[str, Actuator]
    laser: Laser

    @model_validator(mode="after")
    def _named(self) -> Self:
        driven: list[Joint | Wheel] = [*self.joints, *self.wheels, *([self.roll.joint] if self.roll else [])]
        for one in driven:
            if one.actuator not in self.actuators:
                kind = "wheel" if isinstance(one, Wheel) else "joint"
                raise ValueError(f"{kind} {one.name!r} names actuator {one.actuator!r}, which is not described")
        if len({one.name for one in driven}) < len(driven):
            raise ValueError("joint names must differ")
        if self.roll and self.roll.link not in [link.name for link in self.links]:
            raise ValueError(f"the roll joint divides link {self.roll.link!r}, which is not described")
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
        """Of the links, in order."""
        return tuple(link.joint for link in self.links if link.joint is not None)

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """Of the links, in order."""
        return tuple(link.wheel for link in self.links if link.wheel is not None)

    @property
    def coordinates(self) -> int:
        """Numbers of a configuration."""
        return len(BASE) * self.free + len(self.joints)

    @property
    def joint_actuators(self) -> tuple[Actuator, ...]:
        """The actuator of each joint, in joint order."""
        return tuple(self.actuators[joint.actuator] for joint in self.joints)

    @property
    def driven(self) -> tuple[Joint | Wheel, ...]:
        """All that is commanded: the joints, then the wheels."""
        return self.joints + self.wheels

    @property
    def driven_actuators(self) -> tuple[Actuator, ...]:
        """The actuator of all that is commanded, in order."""
        return tuple(self.actuators[one.actuator] for one in self.driven)

    @property
    def length(self) -> float:
        """From the first link's rear end to the tip, straight [m]."""
        return sum(link.length for link in self.links)

    @property
    def width(self) -> float:
        """Of the widest link or wheel [m]."""
        return max([link.width for link in self.links] + [wheel.diameter for wheel in self.wheels])

    @cached_property
    def hinges(self) -> Flags:
        """Which joints are hinges, (joints,)."""
        return np.array([joint.type == "hinge" for joint in self.joints])

    @cached_property
    def link_turns(self) -> Flags:
        """Which links are turned by their joint or, the first one of a free robot, by themselves, (links,)."""
        return np.array([link.joint is None or link.joint.type == "hinge" for link in self.links])

    @cached_property
    def lengths(self) -> Floats:
        """Of the links, (links,) [m]."""
        return constant([link.length for link in self.links])

    @cached_property
    def lower(self) -> Floats:
        """Joint limits, (joints,)."""
        return constant([joint.lower for joint in self.joints])

    @cached_property
    def upper(self) -> Floats:
        """Joint limits, (joints,)."""
        return constant([joint.upper for joint in self.joints])

    @cached_property
    def speed_limits(self) -> Floats:
        """No-load speed of each joint, (joints,) [rad/s or m/s]."""
        return constant([actuator.speed_limit for actuator in self.joint_actuators])

    @cached_property
    def effort_limits(self) -> Floats:
        """Stall effort of all that is driven, (actuators,) [N m or N]."""
        return constant([actuator.effort_limit for actuator in self.driven_actuators])

    @cached_property
    def mirror_signs(self) -> Floats:
        """What a reflection about the first leg's axis does to joint positions: +1 slide, -1 hinge, (joints,)."""
        return constant(np.where(self.hinges, -1.0, 1.0))

    @cached_property
    def mirror_coordinates(self) -> Floats:
        """What it does to configurations, (coordinates,)."""
        return constant([*([1.0, -1.0, -1.0] if self.free else []), *self.mirror_signs])

    @cached_property
    def mirror_drives(self) -> Floats:
        """What it does to commands: as to the joints; a wheel's rolling side is the other one, -1, (actuators,)."""
        return constant([*self.mirror_signs, *[-1.0] * len(self.wheels)])


def robot_names() -> list[str]:
    """The shipped robots."""
    return sorted(path.parent.name for path in shipped.robots_dir().glob("*/robot.toml"))


def load_robot(name: str) -> RobotSpec:
    """A shipped robot by name, or any robot by the path of its `robot.toml`.

    Raises:
        UnknownName: no such robot.
        ConfigError: the file does not fit the schema.
        FileProblem: the file cannot be read.
    """
    path = Path(name) if name.endswith(".toml") else shipped.robots_dir() / name / "robot.toml"
    if not name.endswith(".toml") and name not in robot_names():
        raise UnknownName("robot", name, robot_names())
    try:
        text = path.read_text(encoding="utf-8")
        return RobotSpec.model_validate(resolve_types(tomllib.loads(text), str(path)))
    except OSError as error:
        raise FileProblem(path, "read", error) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path} is not valid TOML: {error}.") from error
    except ValidationError as error:
        raise ConfigError.from_validation(str(path), error, _known_beside(error)) from error


def _known_beside(error: ValidationError) -> list[str]:
    """The keys that exist where pydantic found its first problem."""
    first, *rest = place = error.errors()[0]["loc"][:-1] or ("",)
    tables: dict[str, type[BaseModel]] = {"links": Link, "actuators": Actuator, "laser": Laser, "roll": Roll}
    known = Joint if "joint" in rest else Wheel if "wheel" in rest else tables.get(str(first), RobotSpec)
    return [".".join(map(str, [*filter(None, map(str, place)), key])) for key in known.model_fields]
