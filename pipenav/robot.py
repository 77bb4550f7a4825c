"""A robot as its `robot.toml` describes it: links, joints, actuators and laser, each physical number once."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from pipenav import assets
from pipenav.errors import ConfigError, FileProblem, UnknownName

Array = NDArray[np.float64]


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy that computes its own cached properties."""
        copied = super().model_copy(update=update, deep=deep)
        for name in copied.__dict__.keys() - type(self).model_fields.keys():
            del copied.__dict__[name]
        return copied


class Actuator(_Table):
    """A geared DC motor under a voltage limit: effort = limit * (drive - speed / speed limit), drive in [-1, 1].

    That is the straight torque-speed line of a brushed motor: full effort only at standstill, none at the no-load
    speed. The on-board position controller drives in proportion to the position error, saturated.
    """

    source: str
    stall_effort: float = Field(gt=0, description="effort at standstill under full voltage [N m, or N for a slide]")
    noload_speed: float = Field(gt=0, description="speed without load under full voltage [rad/s, or m/s]")
    output_limit: float = Field(gt=0, le=1, description="share of full voltage that the driver allows")
    full_drive_error: float = Field(gt=0, description="position error at which the controller asks for full voltage")
    armature: float = Field(ge=0, description="inertia of rotor and gear seen at the joint [kg m^2, or kg]")

    @property
    def effort_limit(self) -> float:
        """Largest effort, at standstill [N m, or N]."""
        return self.output_limit * self.stall_effort

    @property
    def speed_limit(self) -> float:
        """Largest speed, without load [rad/s, or m/s]."""
        return self.output_limit * self.noload_speed

    @property
    def damping(self) -> float:
        """Slope of the torque-speed line [N m s/rad, or N s/m]."""
        return self.stall_effort / self.noload_speed

    @property
    def position_gain(self) -> float:
        """Stiffness of the position controller [N m/rad, or N/m]."""
        return self.stall_effort / self.full_drive_error


class Joint(_Table):
    """A joint and its actuator; a slide moves along its parent's x axis, a hinge turns about z."""

    name: str
    type: Literal["slide", "hinge"]
    lower: float = Field(description="smallest position [rad, or m]")
    upper: float = Field(description="largest position [rad, or m]")
    limit_source: str
    actuator: str = Field(description="key of the actuator in the file's [actuators]")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.lower < 0 < self.upper:
            raise ValueError("the straight start pose, 0, must lie strictly between lower and upper")
        return self


class BoxPart(_Table):
    """A box, its sides along the link's axes."""

    shape: Literal["box"] = "box"
    x: float = Field(description="of its middle, along the link from its joint [m]")
    y: float = Field(0.0, description="of its middle, to the left [m]")
    length: float = Field(gt=0, description="along x [m]")
    width: float = Field(gt=0, description="along y, in the robot's plane [m]")
    height: float = Field(gt=0, description="across the robot's plane, half of it on either side [m]")

    @property
    def volume(self) -> float:
        """[m^3]."""
        return self.length * self.width * self.height


class DiscPart(_Table):
    """A round part, its axis across the robot's plane: a wheel, or the end of a link around a joint."""

    shape: Literal["disc"]
    x: float = Field(description="of its middle, along the link from its joint [m]")
    y: float = Field(0.0, description="of its middle, to the left [m]")
    diameter: float = Field(gt=0, description="in the robot's plane [m]")
    height: float = Field(gt=0, description="across the robot's plane, half of it on either side [m]")

    @property
    def volume(self) -> float:
        """[m^3]."""
        return math.pi / 4 * self.diameter**2 * self.height

    @property
    def width(self) -> float:
        """Across the link [m]."""
        return self.diameter


Part = Annotated[BoxPart | DiscPart, Field(discriminator="shape")]


class Link(_Table):
    """One link from its joint (x = 0) to the next joint (x = length): its parts, or one box where none are given."""

    name: str
    length: float = Field(gt=0, description="along x, to the next joint or the tip [m]")
    width: float = Field(gt=0, description="across, in the robot's plane; no part is wider [m]")
    height: float = Field(gt=0, description="across the robot's plane; no part is higher [m]")
    mass: float = Field(gt=0, description="[kg]")
    joint: Joint
    shape: tuple[Part, ...] = Field((), strict=False, description="the parts that it is made of")

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        for i, part in enumerate(self.shape):
            if abs(part.y) + part.width / 2 > self.width / 2 + 1e-9 or part.height > self.height + 1e-9:
                raise ValueError(f"part {i} of link {self.name!r} sticks out of the link's width or height")
        return self

    @property
    def parts(self) -> tuple[BoxPart | DiscPart, ...]:
        """What it is made of, at least one part."""
        whole = BoxPart(x=self.length / 2, length=self.length, width=self.width, height=self.height)
        return self.shape or (whole,)


class Laser(_Table):
    """A fan of beams at the tip, symmetric about the tip link's axis."""

    source: str
    beams: int = Field(ge=2, le=1081)
    fan_deg: float = Field(gt=0, le=360)
    fan: Literal["centred", "printed"] = Field(
        "centred", description="beams at the centres of equal sectors, or as the thesis's eq 3.16 prints them"
    )
    range_min: float = Field(ge=0, description="smallest reading [m]")
    range_max: float = Field(gt=0, description="largest reading, also that of a beam that meets nothing [m]")
    resolution: float = Field(gt=0, description="readings are multiples of this [m]")

    @cached_property
    def angles(self) -> Array:
        """Angle of each beam from the tip link's axis, from right to left [rad], (beams,).

        Eq 3.16 puts beam 1 on the fan's right edge and the last one a sector short of the left edge; `centred` turns
        the same fan by half a sector, so that left and right see the same.
        """
        fan = math.radians(self.fan_deg)
        sector = fan / self.beams
        first = -fan / 2 + (sector / 2 if self.fan == "centred" else 0.0)
        return _constant(first + sector * np.arange(self.beams, dtype=float))


class RobotSpec(_Table):
    """A planar chain of links, from the one that slides along the first leg to the one that carries the laser."""

    schema_version: Literal[1]
    name: str
    description: str
    source: str
    friction: float = Field(ge=0, le=2, description="Coulomb friction coefficient between robot and pipe")
    friction_source: str
    links: tuple[Link, ...] = Field(min_length=1, strict=False)
    actuators: dict[str, Actuator]
    laser: Laser

    @model_validator(mode="after")
    def _named(self) -> Self:
        for joint in self.joints:
            if joint.actuator not in self.actuators:
                raise ValueError(f"joint {joint.name!r} names actuator {joint.actuator!r}, which is not described")
        if len({joint.name for joint in self.joints}) < len(self.joints):
            raise ValueError("joint names must differ")
        return self

    @property
    def joints(self) -> tuple[Joint, ...]:
        return tuple(link.joint for link in self.links)

    @property
    def joint_actuators(self) -> tuple[Actuator, ...]:
        """The actuator of each joint, in joint order."""
        return tuple(self.actuators[joint.actuator] for joint in self.joints)

    @property
    def length(self) -> float:
        """From the first link's rear end to the tip, straight [m]."""
        return sum(link.length for link in self.links)

    @property
    def width(self) -> float:
        """Of the widest link [m]."""
        return max(link.width for link in self.links)

    @cached_property
    def hinges(self) -> NDArray[np.bool_]:
        """Which joints are hinges, (joints,)."""
        return np.array([joint.type == "hinge" for joint in self.joints])

    @cached_property
    def lengths(self) -> Array:
        """Of the links, (links,) [m]."""
        return _constant([link.length for link in self.links])

    @cached_property
    def lower(self) -> Array:
        """Joint limits, (joints,)."""
        return _constant([joint.lower for joint in self.joints])

    @cached_property
    def upper(self) -> Array:
        """Joint limits, (joints,)."""
        return _constant([joint.upper for joint in self.joints])

    @cached_property
    def speed_limits(self) -> Array:
        """No-load speed of each joint, (joints,) [rad/s or m/s]."""
        return _constant([actuator.speed_limit for actuator in self.joint_actuators])

    @cached_property
    def effort_limits(self) -> Array:
        """Stall effort of each joint, (joints,) [N m or N]."""
        return _constant([actuator.effort_limit for actuator in self.joint_actuators])

    @cached_property
    def mirror_signs(self) -> Array:
        """What a reflection about the first leg's axis does to joint positions: +1 slide, -1 hinge, (joints,)."""
        return _constant(np.where(self.hinges, -1.0, 1.0))


def _constant(values: ArrayLike) -> Array:
    array = np.array(values, float)
    array.flags.writeable = False
    return array


def robot_names() -> list[str]:
    """The shipped robots."""
    return sorted(path.parent.name for path in assets.robots_dir().glob("*/robot.toml"))


def load_robot(name: str) -> RobotSpec:
    """A shipped robot by name, or any robot by the path of its `robot.toml`.

    Raises:
        UnknownName: no such robot.
        ConfigError: the file does not fit the schema.
        FileProblem: the file cannot be read.
    """
    path = Path(name) if name.endswith(".toml") else assets.robots_dir() / name / "robot.toml"
    if not name.endswith(".toml") and name not in robot_names():
        raise UnknownName("robot", name, robot_names())
    try:
        text = path.read_text(encoding="utf-8")
        return RobotSpec.model_validate(tomllib.loads(text))
    except OSError as error:
        raise FileProblem(path, "read", error) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path} is not valid TOML: {error}.") from error
    except ValidationError as error:
        raise ConfigError.from_validation(str(path), error, _known_beside(error)) from error


def _known_beside(error: ValidationError) -> list[str]:
    """The keys that exist where pydantic found its first problem."""
    first, *rest = place = error.errors()[0]["loc"][:-1] or ("",)
    tables: dict[str, type[BaseModel]] = {"links": Link, "actuators": Actuator, "laser": Laser}
    known = Joint if "joint" in rest else tables.get(str(first), RobotSpec)
    return [".".join(map(str, [*filter(None, map(str, place)), key])) for key in known.model_fields]
