"""The arm's own description, `arm.toml`: where it is plugged in, which servo is which joint, how each is mounted."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from pipenav.arrays import Floats, Table
from pipenav.backends import read_toml
from pipenav.errors import ConfigError, FileProblem, shown
from pipenav.robots import Actuator, Joint, RobotSpec
from pipenav.units import m_to_mm, rad_to_deg
from pipenav_hardware.servo_config import Servo, reachable
from pipenav_hardware.table import BAUD_VALUES, CENTRE, COUNT

DEFAULT_ARM = Path("arm.toml")
"""Default path of an arm's description."""

Port = Annotated[str, Field(max_length=1000, pattern=r"^[^\x00-\x1f]*$")]
"""Name of a device, which no control character is part of."""


class ScannerConfig(Table):
    """The range scanner at the tip."""

    driver: Literal["scip2", "realsense"]
    port: Port = Field("", description="device of a serial scanner; empty for one that the driver finds itself")
    baud: int = Field(115_200, ge=300, le=12_000_000, description="speed of a serial scanner; without meaning on USB")
    mounting_deg: float = Field(
        0.0, ge=-180, le=180, description="direction of its middle beam, left of the tip link's axis"
    )
    upside_down: bool = Field(False, description="whether its beams run from left to right")


class FrontSensorConfig(Table):
    """The front distance sensor on its Arduino."""

    port: Port
    offset_mm: float = Field(0.0, ge=-200, le=200, description="how far the sensor stands behind the tip")


class ArmConfig(Table):
    """Content of arm.toml; `docs/guides/the-arm.md` explains each key."""

    schema_version: Literal[1]
    robot: str = Field(description="name of the robot whose joints these are")
    port: Port = Field(description="device of the servo bus")
    baud: int = Field(1_000_000, description="speed of the servo bus")
    servos: tuple[Servo, ...] = Field(min_length=1, strict=False)
    scanner: ScannerConfig
    front_sensor: FrontSensorConfig | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.baud not in BAUD_VALUES:
            raise ValueError(f"baud {self.baud} is not one of {', '.join(map(str, sorted(BAUD_VALUES)))}")
        if len({servo.id for servo in self.servos}) < len(self.servos):
            raise ValueError(f"two servos have the same id, of {list(self.ids)}: give each servo its own")
        return self

    @property
    def ids(self) -> tuple[int, ...]:
        """Ids of the servos, in joint order."""
        return tuple(servo.id for servo in self.servos)

    @property
    def joints(self) -> dict[int, str]:
        """Joint of each servo, by the servo's id, in joint order."""
        return {servo.id: servo.joint for servo in self.servos}

    @property
    def count_limits(self) -> Floats:
        """Smallest and largest goal of every servo, (servos, 2) [counts]."""
        return np.array([servo.count_limits for servo in self.servos], float)

    def require(self, robot: RobotSpec) -> None:
        """Check that this is an arm of that robot.

        Raises:
            ConfigError: another robot, other joints, or limits beyond the robot's own.
        """
        if robot.name != self.robot:
            raise ConfigError(
                f"this arm is a {shown(self.robot)}, not a {robot.name!r}: use a policy for {self.robot!r}."
            )
        named, known = [servo.joint for servo in self.servos], [joint.name for joint in robot.joints]
        if named != known:
            given = shown(", ".join(named), quoted=False, longest=300)
            raise ConfigError(f"the arm's servos move {given}, robot {robot.name!r} has {', '.join(known)}.")
        for servo, joint in zip(self.servos, robot.joints, strict=True):
            if (servo.drive == "pinion") != (joint.type == "slide"):
                raise ConfigError(f"joint {joint.name!r} is a {joint.type}, its servo is described as {servo.drive}.")
            if servo.limits.lower < joint.lower - 1e-6 or servo.limits.upper > joint.upper + 1e-6:
                raise ConfigError(f"joint {joint.name!r}: the arm's limits go beyond those in robot.toml.")


def load_arm(path: Path) -> ArmConfig:
    """Read an `arm.toml`.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: the file does not fit the schema, or there is none: the arm is not calibrated.
    """
    try:
        return ArmConfig.model_validate(read_toml(path))
    except FileProblem as problem:
        if not isinstance(problem.__cause__, FileNotFoundError):
            raise
        raise ConfigError(
            f"there is no arm description {path}: write one with pipenav calibrate --port /dev/ttyUSB0 "
            f"--arm {shlex.quote(str(path))}, or try without hardware: pipenav run-real --emulate."
        ) from None
    except ValidationError as error:
        raise ConfigError.from_validation(str(path), error, ArmConfig.model_fields) from error


def default_arm(robot: RobotSpec, port: str, scanner: ScannerConfig, front: FrontSensorConfig | None) -> ArmConfig:
    """A robot's arm with every servo mounted ideally: ids from 1 in joint order, no mirrored horn.

    A pinion's radius is how far the rack moves at the position error of full duty, over the angle that this error is
    at a hinge's servo.
    """
    full_duty = next(driven.actuator.full_drive_error for driven in _driven(robot) if driven.joint.type == "hinge")
    servos: list[dict[str, Any]] = []
    for number, (actuator, joint) in enumerate(_driven(robot), start=1):
        servo = {"joint": joint.name, "id": number, "sign": 1, "torque_limit_percent": 100 * actuator.output_limit}
        if joint.type == "hinge":
            lower, upper = reachable(joint.lower, joint.upper, 1, CENTRE, 1.0)
            limits = {"lower_deg": rad_to_deg(lower), "upper_deg": rad_to_deg(upper)}
            servos.append({**servo, "drive": "hinge", "zero_count": CENTRE, **limits})
            continue
        radius = actuator.full_drive_error / full_duty
        middle = (joint.lower + joint.upper) / 2
        zero = CENTRE - middle / (radius * COUNT)
        lower, upper = reachable(joint.lower, joint.upper, 1, zero, radius)
        pinion = {"pinion_radius_mm": m_to_mm(radius), "zero_count": zero}
        servos.append({**servo, "drive": "pinion", **pinion, "lower_mm": m_to_mm(lower), "upper_mm": m_to_mm(upper)})
    front_table = None if front is None else front.model_dump()
    return ArmConfig.model_validate(
        {
            "schema_version": 1,
            "robot": robot.name,
            "port": port,
            "servos": servos,
            "scanner": scanner.model_dump(),
            "front_sensor": front_table,
        }
    )


class _DrivenJoint(NamedTuple):
    """A joint that a servo moves, and the actuator that stands for the servo."""

    actuator: Actuator
    joint: Joint


def _driven(robot: RobotSpec) -> list[_DrivenJoint]:
    """Every joint with its actuator, in joint order."""
    return [_DrivenJoint(*pair) for pair in zip(robot.joint_actuators, robot.joints, strict=True)]


def arm_toml(config: ArmConfig) -> str:
    """The description as a TOML file's text."""
    lines = ["# This arm, as pipenav calibrate measured it: lengths in mm, angles in degrees, positions in counts."]
    tables = config.model_dump(exclude_none=True)
    servos, scanner, front = tables.pop("servos"), tables.pop("scanner"), tables.pop("front_sensor", None)
    lines += [f"{key} = {_toml(value)}" for key, value in tables.items()]
    for head, table in [
        *(("[[servos]]", servo) for servo in servos),
        ("[scanner]", scanner),
        ("[front_sensor]", front),
    ]:
        if table is not None:
            lines += ["", head, *(f"{key} = {_toml(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    return repr(value)
