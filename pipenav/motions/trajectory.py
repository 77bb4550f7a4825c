"""One recorded motion of one robot in one pipe, as a CSV file. docs/trajectory-file.md describes the format."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, NoReturn

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    JsonValue,
    ValidationError,
)

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.errors import FileProblem, PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.json_keys import PipeInFile
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.storage.atomic_files import atomic_write
from pipenav.tasks.outcome import Outcome, PassageStage

PREFIX = "# pipenav-trajectory "
TIME, FORCE = "t_s", "contact_force_n"

MAX_BYTES = 32 << 20
"""An hour of any robot fits: 36,000 rows of some forty numbers."""

TIME_TOLERANCE = 0.01
"""How far a row's time may be off [s]: a tenth of a control period, for clocks of real arms."""

LIMIT_TOLERANCE = 0.02
"""How far beyond a limit a joint may be, as a share of its travel: stops give, and so do simulated ones."""


class TrajectoryFileError(PipenavError):
    """A trajectory file that cannot be used."""

    def __init__(self, path: Path, problem: str, remedy: str = "record it again") -> None:
        super().__init__(f"trajectory {path} {problem}: {remedy}.")


class Motion(NamedTuple):
    """How one robot moved in one pipe.

    Attributes:
        pipe: where.
        base: x of the robot's frame in the pipe's frame [m].
        q: joint positions in the robot's own frame, one row per control step, the start pose first, (rows, joints).
    """

    pipe: PipeCorner
    base: float
    q: Floats


def _known_verdict(outcome: str | None) -> str | None:
    known = [outcome.label for outcome in Outcome]
    if outcome is not None and outcome not in known:
        raise ValueError(f"is none of {', '.join(known)}, null")
    return outcome


def _todays_stage(given: Any) -> Any:
    """A stage, which schema 1 called `front` where it is `reach` today, as its enum."""
    try:
        return PassageStage("reach" if given == "front" else given)
    except ValueError:
        raise ValueError(f"is none of {', '.join(PassageStage)}") from None


class TrajectoryHeader(BaseModel):
    """What the first line of a trajectory file says.

    Attributes:
        schema_version: version of the format; the key is `schema`.
        robot: its name.
        pipe: under the keys of pipe.json, or of run.json.
        base_m: x of the robot's frame in the pipe's frame [m].
        goal_m: the target in the pipe's frame [m]; None where there is none.
        stage: the part of a passage that this is.
        outcome: a `Outcome` as its label; None for a motion that was planned and not run.
        backend: on what it ran; None for a plan.
        controller: policy, baseline or behaviour that acted.
        options: the backend's settings.
        seed: of the episode; None where there was none.
    """

    model_config = ConfigDict(frozen=True, extra="ignore", strict=True, allow_inf_nan=False, populate_by_name=True)

    schema_version: Literal[1, 2] = Field(2, alias="schema")
    robot: str
    pipe: PipeInFile
    base_m: float
    goal_m: Annotated[tuple[float, float] | None, Field(strict=False)] = None
    stage: Annotated[PassageStage, BeforeValidator(_todays_stage)]
    outcome: Annotated[str | None, AfterValidator(_known_verdict)] = None
    backend: str | None = None
    controller: str | None = None
    options: dict[str, JsonValue] = Field(default_factory=dict)
    seed: int | None = None


@dataclass(frozen=True)
class Trajectory:
    """A recorded motion and all that is known of it. Its arrays must not be written to.

    Attributes:
        header: what the file's first line says.
        robot: the robot that moved.
        q: configurations in the robot's own frame, (rows, coordinates) [rad or m]; the first row is the start pose.
        contact_force: largest net force of the pipe on any one link, peak of each control step, (rows,) [N]; None
            where nothing measured it.
        link_forces: that force on every link in the pipe's axes, (rows, links, 2) [N]; None where it is not known.
    """

    header: TrajectoryHeader
    robot: RobotSpec
    q: Floats
    contact_force: Floats | None = None
    link_forces: Floats | None = None

    @property
    def motion(self) -> Motion:
        """Raises PipenavError in a run of corners."""
        return Motion(self.header.pipe.require_corner(), self.header.base_m, self.q)

    @property
    def time(self) -> Floats:
        """Time of each row [s], (rows,)."""
        return np.round(np.arange(len(self.q)) * CONTROL_PERIOD, 6)

    @property
    def succeeded(self) -> bool:
        return self.header.outcome == Outcome.REACHED.label


def coordinate_columns(robot: RobotSpec) -> list[str]:
    """The columns of a configuration: `l_m` of a slide l, `theta1_rad` of a hinge theta1; before them a free base's."""
    base = ["x_m", "y_m", "heading_rad"] if robot.free else []
    return base + [f"{joint.name}_{'m' if joint.type == 'slide' else 'rad'}" for joint in robot.joints]


def link_force_columns(robot: RobotSpec) -> list[str]:
    """The columns of the forces on the links, x and y of each."""
    return [f"{link.name}_f{axis}_n" for link in robot.links for axis in "xy"]


def write_trajectory(path: Path, trajectory: Trajectory) -> None:
    """Write one trajectory file, whole or not at all; reading it gives the same numbers, bit for bit.

    Raises:
        FileProblem: it cannot be written.
    """
    columns, parts = [TIME, *coordinate_columns(trajectory.robot)], [trajectory.time[:, None], trajectory.q]
    if trajectory.contact_force is not None:
        columns, parts = [*columns, FORCE], [*parts, trajectory.contact_force[:, None]]
    if trajectory.link_forces is not None:
        columns += link_force_columns(trajectory.robot)
        parts.append(trajectory.link_forces.reshape(len(trajectory.q), -1))
    text = io.StringIO()
    text.write(PREFIX + json.dumps(trajectory.header.model_dump(mode="json", by_alias=True)) + "\n")
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(columns)
    rows.writerows(np.concatenate(parts, axis=1).tolist())
    atomic_write(path, text.getvalue())


def read_trajectory(path: Path, robot: RobotSpec | None = None) -> Trajectory:
    """The trajectory in a file.

    Args:
        path: the file.
        robot: the robot that it must be of; by default the shipped one that the file names.

    Raises:
        FileProblem: it cannot be read.
        UnknownName: it names a robot that is not shipped, and none was given.
        TrajectoryFileError: it is no trajectory, is of another robot or version, misses a column, has a gap in time,
            or a number in it cannot be.
    """
    lines = _lines(path)
    if not lines or not lines[0].startswith(PREFIX):
        raise TrajectoryFileError(path, f"does not begin with {PREFIX.strip()!r}", "give a file that pipenav recorded")
    header = _header(path, lines[0].removeprefix(PREFIX))
    if robot is None:
        robot = load_robot(header.robot)
    if header.robot != robot.name:
        raise TrajectoryFileError(
            path, f"is of robot {header.robot!r}, not of {robot.name!r}", "give one that this robot recorded"
        )
    table = _table(path, lines[1:], robot)
    q = np.stack([table[name] for name in coordinate_columns(robot)], axis=1)
    _check_rows(path, robot, table, q)
    forces = link_force_columns(robot)
    has_links = forces[0] in table
    link_forces = np.stack([table[name] for name in forces], axis=1).reshape(len(q), -1, 2) if has_links else None
    return Trajectory(header, robot, q, table.get(FORCE), link_forces)


def _lines(path: Path) -> list[str]:
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            raise TrajectoryFileError(path, f"is larger than {MAX_BYTES >> 20} MiB", "no trajectory is, give another")
        return content.decode("utf-8").splitlines()
    except OSError as error:
        raise FileProblem(path, "read", error) from error
    except UnicodeDecodeError as error:
        raise TrajectoryFileError(path, "is not text", "give a file that pipenav recorded") from error


def _header(path: Path, text: str) -> TrajectoryHeader:
    try:
        header = TrajectoryHeader.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"] if part not in ("<corner>", "<run>")) or "the header"
        given = f", given {first['input']!r}" if isinstance(first["input"], str | int | float | bool) else ""
        message = str(first["msg"]).removeprefix("Value error, ")
        raise TrajectoryFileError(path, f"line 1: {key}: {message[0].lower()}{message[1:]}{given}") from error
    except PipenavError as error:  # of the pipe's own checks
        raise TrajectoryFileError(path, f"line 1: pipe: {str(error).rstrip('.')}") from error
    wrong = header.outcome == Outcome.MISPLACED.label  # a target that was located in a wrong place may be anywhere
    if header.goal_m is not None and not wrong and not header.pipe.contains(np.array(header.goal_m)):
        x, y = header.goal_m
        raise TrajectoryFileError(path, f"line 1: the target goal_m ({x:g}, {y:g}) lies outside the pipe")
    return header


def _table(path: Path, lines: list[str], robot: RobotSpec) -> dict[str, Floats]:
    """The columns by name. Line numbers in messages are those of the file, whose first line is the header's."""
    names = lines[0].split(",") if lines else []
    required, forces = [TIME, *coordinate_columns(robot)], link_force_columns(robot)
    if any(name in forces for name in names):
        required += forces
    for name in required:
        if name not in names:
            raise TrajectoryFileError(path, f"has no column {name!r}")
    for i, name in enumerate(names):
        if name not in [*required, FORCE] or name in names[:i]:
            known = ", ".join([*required, FORCE])
            raise TrajectoryFileError(path, f"has an unknown or doubled column {name!r}", f"its columns are {known}")
    if len(lines) < 3:
        raise TrajectoryFileError(path, "holds no motion, fewer than two rows")
    values = np.array(list(_numbers(path, names, lines[1:])))
    return dict(zip(names, values.T, strict=True))


def _numbers(path: Path, names: list[str], lines: list[str]) -> Iterator[list[float]]:
    for number, line in enumerate(lines, start=3):
        cells = line.split(",")
        if len(cells) != len(names):
            raise TrajectoryFileError(path, f"line {number} has {len(cells)} values for {len(names)} columns")
        row = [_number(cell) for cell in cells]
        for name, cell, value in zip(names, cells, row, strict=True):
            if not math.isfinite(value):
                raise TrajectoryFileError(path, f"line {number}, {name}: {cell!r} is not a finite number")
        yield row


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan


def _check_rows(path: Path, robot: RobotSpec, table: dict[str, Floats], q: Floats) -> None:
    def refuse(row: int, problem: str) -> NoReturn:
        raise TrajectoryFileError(path, f"line {row + 3}, {problem}")

    due = np.arange(len(q)) * CONTROL_PERIOD
    late = np.flatnonzero(np.abs(table[TIME] - due) > TIME_TOLERANCE)
    if late.size:
        row = int(late[0])
        what = f"{table[TIME][row]:g} where {due[row]:g} is due, rows being {CONTROL_PERIOD:g} s apart from 0"
        refuse(row, f"{TIME}: {what}")
    spare = LIMIT_TOLERANCE * (robot.upper - robot.lower)
    joints = q[:, -len(robot.joints) :]
    beyond = np.argwhere((joints < robot.lower - spare) | (joints > robot.upper + spare))
    if beyond.size:
        row, joint = (int(index) for index in beyond[0])
        limits = f"{robot.lower[joint]:g} to {robot.upper[joint]:g}"
        name = coordinate_columns(robot)[joint - len(robot.joints)]
        refuse(row, f"{name}: {joints[row, joint]:g} lies outside the joint's limits, {limits}")
    negative = np.flatnonzero(table.get(FORCE, np.zeros(1)) < 0)
    if negative.size:
        row = int(negative[0])
        refuse(row, f"{FORCE}: {table[FORCE][row]:g} is negative")
