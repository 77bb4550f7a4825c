"""Frontiers: the bore that a robot needs over the angle, as files that ship for the shipped robots."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

import pipenav
from pipenav.certify.certificate import shape_hash
from pipenav.certify.model import Model
from pipenav.certify.needed_bore import needed_bore
from pipenav.errors import ConfigError, PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import RobotSpec
from pipenav.storage.atomic_files import atomic_write
from pipenav.storage.text_files import read_json
from pipenav.units import m_to_mm, rad_to_deg

ANGLES_DEG = (40.0, 60.0, 80.0, 100.0, 120.0, 140.0)
"""Interior angles at which a frontier is computed [deg]."""

REFERENCE_MM = 100.0
"""Bore of the pipe whose bores are changed to find the frontier [mm]."""

SHIPPED = Path(__file__).with_name("frontiers")
"""Folder of the shipped robots' frontiers."""


class FrontierPoint(BaseModel):
    """Frontier at one angle.

    Attributes:
        angle_deg: interior angle [deg].
        impossible_mm: largest bore that is proven impossible [mm]; None where none was found to be.
        passable_mm: smallest bore with a motion [mm]; None where none was found.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    angle_deg: float
    impossible_mm: float | None
    passable_mm: float | None


class Frontier(BaseModel):
    """Bores that a robot needs over the angle, without overlap.

    Attributes:
        schema_version: version of the format; the key is `schema`.
        version: version of pipenav that computed it.
        robot: name of the robot.
        shape_sha256: hash of its shapes and joint limits, by which a stale frontier is noticed.
        bore: `plane` or `round`.
        bend_radius_d: radius of the bend in bores; 0 for a mitre.
        resolution_deg: width of the smallest cells that were allowed [deg].
        points: points at rising angles.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, populate_by_name=True)

    schema_version: Literal[1] = Field(1, alias="schema")
    version: str
    robot: str
    shape_sha256: str
    bore: Literal["plane", "round"]
    bend_radius_d: float
    resolution_deg: float
    points: Annotated[tuple[FrontierPoint, ...], Field(strict=False)]

    @property
    def name(self) -> str:
        """Name of its file, without the ending."""
        return frontier_name(self.robot, self.bore, self.bend_radius_d)

    def passable(self, angle_deg: float) -> float | None:
        """Smallest bore with a motion at an angle, straight between points [mm]; None outside of the known angles."""
        known = [(point.angle_deg, point.passable_mm) for point in self.points if point.passable_mm is not None]
        if not known or not known[0][0] <= angle_deg <= known[-1][0]:
            return None
        return float(np.interp(angle_deg, [angle for angle, _ in known], [bore for _, bore in known]))

    def of(self, robot: RobotSpec) -> bool:
        """Whether it is the frontier of this robot as it is now."""
        return robot.name == self.robot and shape_hash(robot) == self.shape_sha256


class Wanted(NamedTuple):
    """Frontier that is to be computed.

    Attributes:
        robot: the robot.
        bore: `plane` or `round`.
        bend_radius_d: radius of the bend in bores; 0 for a mitre.
        resolution: width of the smallest cells [rad].
    """

    robot: RobotSpec
    bore: Literal["plane", "round"]
    bend_radius_d: float
    resolution: float

    def points(self) -> Iterator[FrontierPoint]:
        """Points of the frontier, one after the other; each takes some seconds."""
        for angle in ANGLES_DEG:
            yield self.point(angle)

    def point(self, angle_deg: float) -> FrontierPoint:
        """Frontier at one angle [deg]."""
        pipe = PipeCorner.of(REFERENCE_MM, angle_deg, bend_radius_mm=self.bend_radius_d * REFERENCE_MM)
        found = needed_bore(Model(self.robot, pipe, self.bore), self.resolution)
        impossible, passable = (None if bore is None else round(m_to_mm(bore), 3) for bore in found)
        return FrontierPoint(angle_deg=angle_deg, impossible_mm=impossible, passable_mm=passable)

    def frontier(self, points: tuple[FrontierPoint, ...]) -> Frontier:
        """The frontier with its points."""
        return Frontier(
            version=pipenav.__version__,
            robot=self.robot.name,
            shape_sha256=shape_hash(self.robot),
            bore=self.bore,
            bend_radius_d=self.bend_radius_d,
            resolution_deg=round(rad_to_deg(self.resolution), 6),
            points=points,
        )


def bend_radius_of(text: str) -> float:
    """Radius of bends in bores, of `mitre` or a number like `1.5D`.

    Raises:
        PipenavError: neither.
    """
    if text == "mitre":
        return 0.0
    try:
        times = float(text.removesuffix("D"))
    except ValueError:
        times = -1.0
    if not (text.endswith("D") and 0.5 <= times <= 10.0):
        raise PipenavError(f"bends {text!r} are unknown: choose mitre, or a radius of 0.5D to 10D such as 1.5D.")
    return times


def frontier_name(robot: str, bore: str, bend_radius_d: float) -> str:
    """Name of a frontier's files, without the ending."""
    return f"frontier-{robot}-{bore}-{f'{bend_radius_d:g}D' if bend_radius_d else 'mitre'}"


def write_frontier(folder: Path, frontier: Frontier) -> Path:
    """Write `<name>.json`.

    Raises:
        FileProblem: the file cannot be written.
    """
    path = folder / f"{frontier.name}.json"
    atomic_write(path, json.dumps(frontier.model_dump(mode="json", by_alias=True), indent=2) + "\n")
    return path


def read_frontier(path: Path) -> Frontier:
    """A frontier from its file.

    Raises:
        FileProblem: the file cannot be read.
        ConfigError: it is no frontier.
    """
    try:
        return Frontier.model_validate(read_json(path))
    except ValidationError as error:
        raise ConfigError.from_validation(str(path), error) from error


def shipped_frontier(robot: RobotSpec, bore: str, bend_radius_d: float) -> Frontier | None:
    """The frontier that ships for a robot; None where none does, or where it is of another description of the robot."""
    path = SHIPPED / f"{frontier_name(robot.name, bore, bend_radius_d)}.json"
    if not path.is_file():
        return None
    found = read_frontier(path)
    return found if found.of(robot) else None
