"""Parts of a robot: links, joints, wheels, their actuators and the laser, as `robot.toml` describes them."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from pipenav.arrays import Floats, Table

LONGEST = 20.0
"""Largest joint position [rad, or m]: three turns, or the longest leg of a pipe."""

LEAST_TRAVEL = 0.001
"""Least travel of a joint [rad, or m]: less cannot be told from play."""

MOST_PARTS = 50
"""Most parts of a link."""

# Pipes are 40 to 300 mm wide and their legs 20 m long at most. What is thinner than a screw, lighter than a coin, or
# fits no pipe is a slip of the unit.
Name = Annotated[str, Field(pattern=r"^\w[\w.+ -]{0,63}$")]
Length = Annotated[float, Field(ge=1e-3, le=2)]
Thickness = Annotated[float, Field(ge=1e-3, le=0.3)]
Place = Annotated[float, Field(ge=-2, le=2)]
Mass = Annotated[float, Field(ge=1e-3, le=50)]


class Actuator(Table):
    """A geared DC motor under a voltage limit: effort = limit * (duty - speed / speed limit), duty in [-1, 1].

    The torque-speed line is the straight one of a brushed motor: full effort only at standstill, none at the no-load
    speed. The duty that the on-board controller asks for is proportional to the error, saturated: a joint's error is
    one of position, a wheel's one of speed.
    """

    source: str
    stall_effort: float = Field(
        ge=1e-4, le=1000, description="effort at standstill under full voltage [N m, or N for a slide]"
    )
    noload_speed: float = Field(ge=1e-3, le=1000, description="speed without load under full voltage [rad/s, or m/s]")
    output_limit: float = Field(ge=0.01, le=1, description="share of full voltage that the driver allows")
    full_drive_error: float = Field(
        ge=1e-4,
        le=100,
        description="error at which the controller asks for full voltage: of position [rad, or m], of a wheel's speed "
        "[rad/s]",
    )
    armature: float = Field(ge=0, le=1000, description="inertia of rotor and gear seen at the joint [kg m^2, or kg]")

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
    def controller_gain(self) -> float:
        """Effort per error of the on-board controller [N m/rad, or N/m; of a wheel N m s/rad]."""
        return self.stall_effort / self.full_drive_error


class Joint(Table):
    """A joint and its actuator; a slide moves along the x axis of the link before it, a hinge turns about z."""

    name: Name
    type: Literal["slide", "hinge"]
    lower: float = Field(ge=-LONGEST, description="smallest position [rad, or m]")
    upper: float = Field(le=LONGEST, description="largest position [rad, or m]")
    limit_source: str
    actuator: str = Field(description="key of the actuator in the file's [actuators]")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.lower < 0 < self.upper:
            raise ValueError("the straight start pose, 0, must lie strictly between lower and upper")
        if self.upper - self.lower < LEAST_TRAVEL:
            raise ValueError(f"a joint needs a travel of {LEAST_TRAVEL:g} at least between lower and upper")
        return self


class BoxPart(Table):
    """A box, its sides along the link's axes."""

    shape: Literal["box"] = "box"
    x: Place = Field(description="position of the middle along the link, from the link's joint [m]")
    y: Place = Field(0.0, description="position of the middle to the left [m]")
    length: Length = Field(description="size along x [m]")
    width: Thickness = Field(description="size along y, in the robot's plane [m]")
    height: Thickness = Field(description="size across the robot's plane, half of it on either side [m]")

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return self.length * self.width * self.height


class DiscPart(Table):
    """A round part, its axis across the robot's plane: a wheel, or the end of a link around a joint."""

    shape: Literal["disc"]
    x: Place = Field(description="position of the middle along the link, from the link's joint [m]")
    y: Place = Field(0.0, description="position of the middle to the left [m]")
    diameter: Thickness = Field(description="diameter in the robot's plane [m]")
    height: Thickness = Field(description="size across the robot's plane, half of it on either side [m]")

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return math.pi / 4 * self.diameter**2 * self.height

    @property
    def width(self) -> float:
        """Width across the link, the diameter [m]."""
        return self.diameter


class Wheel(Table):
    """A driven wheel, its axle across the robot's plane; its on-board controller keeps a speed."""

    name: Name
    x: Place = Field(0.0, description="position of the axle along the link, from the link's joint [m]")
    diameter: Thickness = Field(description="diameter [m]")
    height: Thickness = Field(description="height of the tread, across the robot's plane [m]")
    mass: Mass = Field(description="mass [kg]")
    friction: float = Field(ge=0, le=2, description="Coulomb friction coefficient between tread and pipe")
    friction_source: str
    actuator: str = Field(description="key of the actuator in the file's [actuators]")

    @property
    def radius(self) -> float:
        """Radius [m]."""
        return self.diameter / 2

    @property
    def disc(self) -> DiscPart:
        """Shape of the wheel as a part of its link."""
        return DiscPart(shape="disc", x=self.x, diameter=self.diameter, height=self.height)


Part = Annotated[BoxPart | DiscPart, Field(discriminator="shape")]


class Link(Table):
    """A link from its joint (x = 0) to the next joint (x = length): its parts, or one box where none are given."""

    name: Name
    length: Length = Field(description="length along x, to the next joint or the tip [m]")
    width: Thickness = Field(description="width across the link, in the robot's plane; no part is wider [m]")
    height: Thickness = Field(description="height across the robot's plane; no part is higher [m]")
    mass: Mass = Field(description="mass [kg]")
    joint: Joint | None = Field(
        None, description="joint at the rear end; only the first link of a robot without a mount has none"
    )
    wheel: Wheel | None = None
    shape: tuple[Part, ...] = Field(
        (),
        strict=False,
        max_length=MOST_PARTS,
        description="parts of the link; one box of the link's size where none are given",
    )

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        for i, part in enumerate(self.shape):
            if abs(part.y) + part.width / 2 > self.width / 2 + 1e-9 or part.height > self.height + 1e-9:
                raise ValueError(f"part {i} of link {self.name!r} sticks out of the link's width or height")
        return self

    @property
    def parts(self) -> tuple[BoxPart | DiscPart, ...]:
        """Parts of the link, at least one."""
        box = BoxPart(x=self.length / 2, length=self.length, width=self.width, height=self.height)
        return self.shape or (box,)

    @property
    def outline(self) -> tuple[BoxPart | DiscPart, ...]:
        """Parts that are seen from above: the parts of the link, and its wheel."""
        return self.parts if self.wheel is None else (*self.parts, self.wheel.disc)


class Roll(Table):
    """A joint that turns everything after it about the axis of the link that it divides.

    It brings the robot's plane into the plane of a corner. In a plane it stands still, so planar models hold it at 0.
    """

    link: str = Field(description="name of the link that the joint divides")
    x: float = Field(ge=0, le=2, description="position along that link, from the link's joint [m]")
    joint: Joint


class Laser(Table):
    """A fan of beams at the tip, symmetric about the tip link's axis."""

    source: str
    beams: int = Field(ge=2, le=1081, description="number of beams")
    fan_deg: float = Field(ge=1, le=360, description="width of the fan [deg]")
    fan: Literal["centred", "printed"] = Field(
        "centred", description="beams at the centres of equal sectors, or as the thesis's eq 3.16 prints them"
    )
    range_min: float = Field(ge=0, description="smallest reading [m]")
    range_max: float = Field(le=100, description="largest reading, which a beam that meets nothing has too [m]")
    resolution: float = Field(ge=1e-6, description="step between two readings [m]")

    @model_validator(mode="after")
    def _spans(self) -> Self:
        if not self.range_min + self.resolution <= self.range_max:
            raise ValueError("range_max must be larger than range_min, by resolution at least")
        return self

    @cached_property
    def angles(self) -> Floats:
        """Angle of each beam from the tip link's axis, from right to left [rad], (beams,).

        Eq 3.16 puts beam 1 on the fan's right edge and the last beam a sector short of the left edge; `centred` turns
        the same fan by half a sector, so that left and right see the same.
        """
        fan = math.radians(self.fan_deg)
        sector = fan / self.beams
        first = -fan / 2 + (sector / 2 if self.fan == "centred" else 0.0)
        return constant(first + sector * np.arange(self.beams, dtype=float))


def constant(values: ArrayLike) -> Floats:
    """An array that cannot be written to."""
    array = np.array(values, float)
    array.flags.writeable = False
    return array
