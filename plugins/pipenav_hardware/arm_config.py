"""The arm's own description, `arm.toml`: where it is plugged in, which servo is which joint, how each is mounted."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from pipenav.arrays import Floats, Table
from pipenav.errors import ConfigError, FileProblem
from pipenav.robots import RobotSpec
from pipenav.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg
from pipenav_hardware.table import BAUD_VALUES, CENTRE, COUNT, COUNTS, SHARE_UNIT, TRAVEL

STOP_MARGIN = 4
"""Counts that stay free at either end of the servo's 300 deg: beyond them its reading is undefined."""

PINION_TRAVEL = TRAVEL - 2 * STOP_MARGIN * COUNT
"""Longest travel of a rack, in pinion radii: 5.236 less the margin. More needs more than one turn, and an AX-12A
cannot count turns: it has no reading in 60 of 360 deg."""


class _Servo(Table):
    joint: str = Field(description="the joint's name in robot.toml")
    id: int = Field(ge=0, le=252, description="the servo's ID")
    sign: Literal[1, -1] = Field(description="1: the joint's positive direction is the servo's counter-clockwise")
    zero_count: float = Field(ge=0, le=COUNTS, description="position count where the joint is at 0")
    torque_limit_percent: float = Field(gt=0, lt=100, description="share of the servo's torque that is allowed")

    @property
    def unit(self) -> float:
        """Joint travel per servo angle [rad/rad, or m/rad]."""
        raise NotImplementedError

    @property
    def limits(self) -> tuple[float, float]:
        """Allowed joint positions [rad, or m]."""
        raise NotImplementedError

    @property
    def torque_counts(self) -> int:
        return int(self.torque_limit_percent / 100 / SHARE_UNIT)

    def to_counts(self, position: float) -> float:
        """Servo position of a joint position; not rounded."""
        return self.zero_count + self.sign * position / (self.unit * COUNT)

    def to_position(self, counts: float) -> float:
        """Joint position of a servo position [rad, or m]."""
        return self.sign * (counts - self.zero_count) * self.unit * COUNT

    @property
    def count_limits(self) -> tuple[int, int]:
        """Smallest and largest goal inside the joint's limits."""
        low, high = sorted(map(self.to_counts, self.limits))
        return math.ceil(low - 1e-9), math.floor(high + 1e-9)

    @model_validator(mode="after")
    def _reachable(self) -> Self:
        lower, upper = self.limits
        if not lower < 0 < upper:
            raise ValueError("the straight pose, 0, must lie strictly between the limits")
        self._require_a_turn()
        low, high = self.count_limits
        if low < STOP_MARGIN or high > COUNTS - STOP_MARGIN:
            raise ValueError(
                f"{self.joint!r}: its limits are servo counts {low} to {high}, allowed are {STOP_MARGIN} to "
                f"{COUNTS - STOP_MARGIN}: narrow the limits, or mount the servo so that 0 lies elsewhere"
            )
        return self

    def _require_a_turn(self) -> None:
        """Raise a ValueError where the travel needs more than the servo's single turn, however it is mounted."""


class HingeServo(_Servo):
    """A servo whose horn is the joint."""

    drive: Literal["hinge"]
    lower_deg: float
    upper_deg: float

    @property
    def unit(self) -> float:
        return 1.0

    @property
    def limits(self) -> tuple[float, float]:
        return deg_to_rad(self.lower_deg), deg_to_rad(self.upper_deg)


class PinionServo(_Servo):
    """A servo that moves the arm along a rack by a pinion, within a single turn."""

    drive: Literal["pinion"]
    pinion_radius_mm: float = Field(gt=0, le=1000)
    lower_mm: float
    upper_mm: float

    @property
    def unit(self) -> float:
        return mm_to_m(self.pinion_radius_mm)

    @property
    def limits(self) -> tuple[float, float]:
        return mm_to_m(self.lower_mm), mm_to_m(self.upper_mm)

    def _require_a_turn(self) -> None:
        longest = PINION_TRAVEL * self.pinion_radius_mm
        if self.upper_mm - self.lower_mm > longest:
            raise ValueError(
                f"{self.joint!r} would travel {self.upper_mm - self.lower_mm:g} mm, a pinion of "
                f"{self.pinion_radius_mm:g} mm radius moves the rack {longest:.0f} mm at most (300 deg, single turn): "
                "narrow the limits or use a larger pinion"
            )


Servo = Annotated[HingeServo | PinionServo, Field(discriminator="drive")]


class ScannerConfig(Table):
    """The range scanner at the tip."""

    driver: Literal["scip2", "realsense"]
    port: str = Field("", description="device of a serial scanner; empty for one that the driver finds itself")
    baud: int = Field(115_200, gt=0, description="of a serial scanner; without meaning on USB")
    mounting_deg: float = Field(0.0, ge=-180, le=180, description="its middle beam, left of the tip link's axis")
    upside_down: bool = Field(False, description="whether its beams run from left to right")


class FrontSensorConfig(Table):
    """The front distance sensor on its Arduino."""

    port: str
    offset_mm: float = Field(0.0, ge=-200, le=200, description="how far the sensor stands behind the tip")


class ArmConfig(Table):
    """See the module; `docs/hardware.md` explains each key."""

    schema_version: Literal[1]
    robot: str = Field(description="name of the robot whose joints these are")
    port: str = Field(description="device of the servo bus")
    baud: int = Field(1_000_000, description="of the servo bus")
    servos: tuple[Servo, ...] = Field(min_length=1, strict=False)
    scanner: ScannerConfig
    front_sensor: FrontSensorConfig | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.baud not in BAUD_VALUES:
            raise ValueError(f"baud {self.baud} is not one of {', '.join(map(str, sorted(BAUD_VALUES)))}")
        if len({servo.id for servo in self.servos}) < len(self.servos):
            raise ValueError("two servos have the same id")
        return self

    @property
    def ids(self) -> tuple[int, ...]:
        return tuple(servo.id for servo in self.servos)

    @property
    def count_limits(self) -> Floats:
        """Smallest and largest goal of every servo, (servos, 2)."""
        return np.array([servo.count_limits for servo in self.servos], float)

    def require(self, robot: RobotSpec) -> None:
        """Check that this is an arm of that robot.

        Raises:
            ConfigError: another robot, other joints, or limits beyond the robot's own.
        """
        if robot.name != self.robot:
            raise ConfigError(f"this arm is a {self.robot!r}, not a {robot.name!r}: use a policy for {self.robot!r}.")
        named, known = [servo.joint for servo in self.servos], [joint.name for joint in robot.joints]
        if named != known:
            raise ConfigError(f"the arm's servos move {', '.join(named)}, robot {robot.name!r} has {', '.join(known)}.")
        for servo, joint in zip(self.servos, robot.joints, strict=True):
            if (servo.drive == "pinion") != (joint.type == "slide"):
                raise ConfigError(f"joint {joint.name!r} is a {joint.type}, its servo is described as {servo.drive}.")
            if servo.limits[0] < joint.lower - 1e-6 or servo.limits[1] > joint.upper + 1e-6:
                raise ConfigError(f"joint {joint.name!r}: the arm's limits go beyond those in robot.toml.")


def load_arm(path: Path) -> ArmConfig:
    """Read an `arm.toml`.

    Raises:
        FileProblem: it cannot be read.
        ConfigError: it does not fit the schema, or the arm is not calibrated.
    """
    try:
        return ArmConfig.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        raise ConfigError(
            f"there is no arm description {path}: write one with pipenav calibrate --arm {path}, "
            "or try without hardware by --emulate."
        ) from None
    except OSError as error:
        raise FileProblem(path, "read", error) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path} is not valid TOML: {error}.") from error
    except ValidationError as error:
        raise ConfigError.from_validation(str(path), error, ArmConfig.model_fields) from error


def default_arm(robot: RobotSpec, port: str, scanner: ScannerConfig, front: FrontSensorConfig | None) -> ArmConfig:
    """A robot's arm as it would be if every servo were mounted ideally: ids from 1 in joint order, no mirrored horn.

    A pinion's radius is how far the rack moves at the position error of full drive, over the angle that this error is
    at a hinge's servo.
    """
    full_drive = next(actuator.full_drive_error for actuator, joint in _driven(robot) if joint.type == "hinge")
    servos: list[dict[str, Any]] = []
    for number, (actuator, joint) in enumerate(_driven(robot), start=1):
        servo = {"joint": joint.name, "id": number, "sign": 1, "torque_limit_percent": 100 * actuator.output_limit}
        if joint.type == "hinge":
            lower, upper = reachable(joint.lower, joint.upper, 1, CENTRE, 1.0)
            limits = {"lower_deg": rad_to_deg(lower), "upper_deg": rad_to_deg(upper)}
            servos.append({**servo, "drive": "hinge", "zero_count": CENTRE, **limits})
            continue
        radius = actuator.full_drive_error / full_drive
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


def reachable(lower: float, upper: float, sign: int, zero_count: float, unit: float) -> tuple[float, float]:
    """The part of a joint's travel that its servo reaches without coming near its ends.

    Args:
        lower, upper: the joint's own limits [rad or m].
        sign, zero_count: how the servo is mounted.
        unit: joint travel per servo angle [1, or m/rad].
    """
    ends = [sign * (counts - zero_count) * unit * COUNT for counts in (STOP_MARGIN, COUNTS - STOP_MARGIN)]
    return max(lower, min(ends) + 1e-9), min(upper, max(ends) - 1e-9)


def _driven(robot: RobotSpec) -> Any:
    return zip(robot.joint_actuators, robot.joints, strict=True)


def arm_toml(config: ArmConfig) -> str:
    """The description as a TOML file's text."""
    lines = ["# This arm, as pipenav calibrate measured it; docs/hardware.md explains each key."]
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
