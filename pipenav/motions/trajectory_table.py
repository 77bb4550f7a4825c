"""Table of a trajectory file: its columns, and the checks of its numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.errors import PipenavError, shown
from pipenav.robots.robot import RobotSpec
from pipenav.storage.text_files import shown_path

TIME, FORCE = "t_s", "contact_force_n"
"""Columns that every robot's table has, or may have."""

FIRST_ROW = 3
"""Line of the table's first row in the file, after the header and the names of the columns."""

MAX_ROWS = 40_000
"""Most rows of a table: more than an hour."""

TIME_TOLERANCE = 0.01
"""Largest error of a row's time [s]: a tenth of a control period, for clocks of real arms."""

LIMIT_TOLERANCE = 0.02
"""Distance by which a joint may be beyond a limit, as a share of its travel: stops give, and so do simulated ones."""


class TrajectoryFileError(PipenavError):
    """A trajectory file that cannot be used."""

    def __init__(self, path: Path, problem: str, remedy: str = "record it again") -> None:
        super().__init__(f"trajectory {shown_path(path)} {problem}: {remedy}.")


def coordinate_columns(robot: RobotSpec) -> list[str]:
    """Columns of a configuration: a free base's, then `l_m` of a slide l, `theta1_rad` of a hinge theta1."""
    base = ["x_m", "y_m", "heading_rad"] if robot.free else []
    return base + [f"{joint.name}_{'m' if joint.type == 'slide' else 'rad'}" for joint in robot.joints]


def link_force_columns(robot: RobotSpec) -> list[str]:
    """Columns of the forces on the links, x and y of each."""
    return [f"{link.name}_f{axis}_n" for link in robot.links for axis in "xy"]


def parse_table(path: Path, lines: list[str], robot: RobotSpec) -> dict[str, Floats]:
    """Columns of a table by name, each (rows,), with numbers that are possible for the robot.

    Args:
        path: the file, for messages.
        lines: lines of the file after the header.
        robot: the robot.

    Raises:
        TrajectoryFileError: a column is missing, unknown or doubled, or a number is impossible.
    """
    names = lines[0].split(",") if lines else []
    _check_columns(path, names, robot)
    if len(lines) < 3:
        raise TrajectoryFileError(path, "has fewer than two rows, so it holds no motion")
    if len(lines) - 1 > MAX_ROWS:
        raise TrajectoryFileError(path, f"holds more than {MAX_ROWS:,} rows", "trajectories are shorter; give another")
    values = np.array(list(_rows(path, names, lines[1:])))
    table: dict[str, Floats] = dict(zip(names, values.T, strict=True))
    _check_time(path, table[TIME])
    _check_limits(path, robot, table)
    _check_force(path, table)
    return table


def _check_columns(path: Path, names: list[str], robot: RobotSpec) -> None:
    required, forces = [TIME, *coordinate_columns(robot)], link_force_columns(robot)
    if any(name in forces for name in names):
        required += forces
    for name in required:
        if name not in names:
            raise TrajectoryFileError(path, f"has no column {name!r}")
    for i, name in enumerate(names):
        if name not in [*required, FORCE] or name in names[:i]:
            known = ", ".join([*required, FORCE])
            raise TrajectoryFileError(
                path, f"has an unknown or doubled column {shown(name)}", f"its columns are {known}"
            )


def _rows(path: Path, names: list[str], lines: list[str]) -> Iterator[list[float]]:
    for number, line in enumerate(lines, start=FIRST_ROW):
        cells = line.split(",")
        if len(cells) != len(names):
            raise TrajectoryFileError(path, f"line {number} has {len(cells)} values for {len(names)} columns")
        row = [_number(cell) for cell in cells]
        for name, cell, value in zip(names, cells, row, strict=True):
            if not math.isfinite(value):
                raise TrajectoryFileError(path, f"line {number}, {name}: {shown(cell)} is not a finite number")
        yield row


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan


def _check_time(path: Path, time: Floats) -> None:
    due = np.arange(len(time)) * CONTROL_PERIOD
    late = np.flatnonzero(np.abs(time - due) > TIME_TOLERANCE)
    if late.size:
        row = int(late[0])
        problem = f"{time[row]:g} instead of {due[row]:g}: rows are {CONTROL_PERIOD:g} s apart and start at 0"
        raise TrajectoryFileError(path, f"line {row + FIRST_ROW}, {TIME}: {problem}")


def _check_limits(path: Path, robot: RobotSpec, table: dict[str, Floats]) -> None:
    names = coordinate_columns(robot)[-len(robot.joints) :]
    joints = np.stack([table[name] for name in names], axis=1)
    spare = LIMIT_TOLERANCE * (robot.upper - robot.lower)
    beyond = np.argwhere((joints < robot.lower - spare) | (joints > robot.upper + spare))
    if beyond.size:
        row, joint = (int(index) for index in beyond[0])
        limits = f"{robot.lower[joint]:g} to {robot.upper[joint]:g}"
        problem = f"{names[joint]}: {joints[row, joint]:g} lies outside the joint's limits, {limits}"
        raise TrajectoryFileError(path, f"line {row + FIRST_ROW}, {problem}")


def _check_force(path: Path, table: dict[str, Floats]) -> None:
    negative = np.flatnonzero(table.get(FORCE, np.zeros(1)) < 0)
    if negative.size:
        row = int(negative[0])
        raise TrajectoryFileError(path, f"line {row + FIRST_ROW}, {FORCE}: {table[FORCE][row]:g} is negative")
