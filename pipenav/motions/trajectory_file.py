"""The trajectory file, a CSV file with a header line. docs/formats/trajectory-file.md describes the format."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from pipenav.errors import ConfigError, PipenavError, UnknownName, described, first_problem, shown
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.motions.trajectory_table import (
    FORCE,
    TIME,
    TrajectoryFileError,
    coordinate_columns,
    link_force_columns,
    parse_table,
)
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.storage.atomic_files import atomic_write
from pipenav.storage.text_files import as_text, checked_json, read_bytes
from pipenav.tasks.outcome import Outcome

PREFIX = "# pipenav-trajectory "
"""Beginning of the header line."""

MAX_BYTES = 16 << 20
"""Largest size of a file. An hour of any robot fits: 36,000 rows of some forty numbers."""


def write_trajectory(path: Path, trajectory: Trajectory) -> None:
    """Write one trajectory file, whole or not at all; reading it gives the same numbers, bit for bit.

    Raises:
        FileProblem: the file cannot be written.
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
    """Read one trajectory file.

    Args:
        path: the file.
        robot: the robot that must have moved; by default the shipped robot that the file names.

    Raises:
        FileProblem: the file cannot be read.
        UnknownName: the file names a robot that is not shipped, and none was given.
        TrajectoryFileError: the file is no trajectory, is of another robot or version, misses a column, has a gap in
            time, or holds an impossible number.
    """
    lines = _lines(path)
    if not lines or not lines[0].startswith(PREFIX):
        raise TrajectoryFileError(path, f"does not begin with {PREFIX.strip()!r}", "give a file that pipenav recorded")
    header = _header(path, lines[0].removeprefix(PREFIX))
    if robot is None:
        try:
            robot = load_robot(header.robot)
        except UnknownName as error:
            raise TrajectoryFileError(
                path, f"is of the unknown robot {shown(header.robot)}", "give its robot.toml by --robot"
            ) from error
    if header.robot != robot.name:
        raise TrajectoryFileError(
            path, f"is of robot {header.robot!r}, not of {robot.name!r}", "give one that this robot recorded"
        )
    table = parse_table(path, lines[1:], robot)
    q = np.stack([table[name] for name in coordinate_columns(robot)], axis=1)
    forces = link_force_columns(robot)
    has_links = forces[0] in table
    link_forces = np.stack([table[name] for name in forces], axis=1).reshape(len(q), -1, 2) if has_links else None
    return Trajectory(header, robot, q, table.get(FORCE), link_forces)


def _lines(path: Path) -> list[str]:
    try:
        text = as_text(read_bytes(path, MAX_BYTES), str(path))
    except ConfigError as error:
        problem = str(error).removeprefix(str(path)).partition(": ")[0].strip(" .")
        raise TrajectoryFileError(path, problem, "give a file that pipenav recorded") from error
    return text.rstrip("\n").split("\n")


def _header(path: Path, text: str) -> TrajectoryHeader:
    try:
        header = TrajectoryHeader.model_validate_json(checked_json(text, "the header"))
    except ValidationError as error:
        raise TrajectoryFileError(path, f"line 1: {described(first_problem(error))}") from error
    except ConfigError as error:
        raise TrajectoryFileError(path, f"line 1: {str(error).rstrip('.')}") from error
    except PipenavError as error:  # from the pipe's own checks
        raise TrajectoryFileError(path, f"line 1: pipe: {str(error).rstrip('.')}") from error
    anywhere = header.outcome == Outcome.MISPLACED.label  # a target that was located in a wrong place
    if header.goal_m is not None and not anywhere and not header.pipe.contains(np.array(header.goal_m)):
        x, y = header.goal_m
        raise TrajectoryFileError(path, f"line 1: the target goal_m ({x:g}, {y:g}) lies outside the pipe")
    return header
