"""The trajectory file: it gives back what was written, and refuses by name what cannot be."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.errors import PipenavError, UnknownName
from pipenav.motions.trajectory import Trajectory, TrajectoryHeader
from pipenav.motions.trajectory_file import PREFIX, read_trajectory, write_trajectory
from pipenav.motions.trajectory_table import TrajectoryFileError
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import PassageStage

ROBOT = load_robot("basic")
PIPES = st.builds(
    PipeCorner.of,
    st.floats(40, 300),
    st.floats(30, 180),
    st.sampled_from(["left", "right"]),
    st.sampled_from([0.0, 37.5]),
)


@st.composite
def trajectories(draw: st.DrawFn) -> Trajectory:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    rows = draw(st.integers(2, 30))
    pipe = draw(PIPES)
    header = TrajectoryHeader(
        robot=ROBOT.name,
        pipe=pipe,
        base_m=draw(st.floats(-1, 0)),
        goal_m=draw(st.sampled_from([None, tuple(0.8 * pipe.leg * pipe.second_leg)])),
        stage=draw(st.sampled_from(["reach", "locate", "rear"])),
        outcome=draw(st.sampled_from(["reached", "timeout", None])),
        backend="mujoco",
        controller="arm",
        options=draw(st.sampled_from([{}, {"timestep": 0.001}])),
        seed=draw(st.one_of(st.none(), st.integers(0, 2**40))),
    )
    q = rng.uniform(ROBOT.lower, ROBOT.upper, (rows, 4))
    force = rng.uniform(0, 30, rows) if draw(st.booleans()) else None
    links = rng.normal(size=(rows, 4, 2)) if draw(st.booleans()) else None
    return Trajectory(header, ROBOT, q, force, links)


@settings(max_examples=30, deadline=None)
@given(trajectories())
def test_reading_gives_what_was_written(tmp_path_factory: pytest.TempPathFactory, written: Trajectory) -> None:
    path = tmp_path_factory.mktemp("round") / "front.csv"
    write_trajectory(path, written)
    read = read_trajectory(path)
    assert read.header == written.header
    for mine, theirs in zip(read_arrays(read), read_arrays(written), strict=True):
        assert (mine is None) == (theirs is None)
        assert mine is None or np.array_equal(mine, theirs)


def read_arrays(trajectory: Trajectory) -> list[Any]:
    return [trajectory.q, trajectory.contact_force, trajectory.link_forces]


def recorded() -> Trajectory:
    """Ten steps forwards in a right turn."""
    pipe = PipeCorner.of(100, 75, "right")
    header = TrajectoryHeader(
        robot="basic", pipe=pipe, base_m=-0.6, goal_m=(0.0, 0.0), stage="reach", outcome="reached", backend="mujoco"
    )
    q = np.linspace([0, 0, 0, 0], [0.2, -0.1, -0.2, -0.3], 11)
    return Trajectory(header, ROBOT, q, np.arange(11.0), np.ones((11, 4, 2)))


def test_the_header_speaks_of_units_and_of_the_pipe_as_its_own_file_does(tmp_path: Path) -> None:
    write_trajectory(tmp_path / "front.csv", recorded())
    first, columns, start, *_ = (tmp_path / "front.csv").read_text().splitlines()
    header = json.loads(first.removeprefix("# pipenav-trajectory "))
    assert header["schema"] == 2
    assert header["pipe"] == {
        "turn": "right",
        "diameter_m": 0.1,
        "angle_rad": recorded().header.pipe.angle,
        "bend_radius_m": 0.0,
        "leg_m": 0.6,
        "wall_m": 0.003,
    }
    assert columns.startswith("t_s,l_m,theta1_rad,theta2_rad,theta3_rad,contact_force_n,base_fx_n,base_fy_n,link1_fx_n")
    assert start.split(",")[0] == "0.0"


def test_times_are_whole_control_periods() -> None:
    assert recorded().time.tolist() == [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]


Edit = Callable[[list[str]], list[str]]


def cell(line: int, column: int, text: str) -> Edit:
    """Another value in one cell; lines count from 1, as messages do."""

    def edit(lines: list[str]) -> list[str]:
        cells = lines[line - 1].split(",")
        cells[column] = text
        return [*lines[: line - 1], ",".join(cells), *lines[line:]]

    return edit


def head(**changes: Any) -> Edit:
    return lambda lines: [PREFIX + json.dumps(json.loads(lines[0].removeprefix(PREFIX)) | changes), *lines[1:]]


def without_column(column: int) -> Edit:
    return lambda lines: [lines[0], *(",".join(np.delete(line.split(","), column)) for line in lines[1:])]


@pytest.mark.parametrize(
    ("edit", "names"),
    [
        (lambda lines: lines[:0], ["does not begin with"]),
        (lambda lines: lines[1:], ["does not begin with"]),
        (lambda lines: [PREFIX + "{", *lines[1:]], ["line 1"]),
        (lambda lines: [PREFIX + "[1]", *lines[1:]], ["line 1"]),
        (lambda lines: lines[:1], ["no column 't_s'"]),
        (lambda lines: lines[:3], ["fewer than two rows"]),
        (lambda lines: [*lines[:6], *lines[7:]], ["line 7", "t_s", "0.5", "instead of 0.4"]),
        (lambda lines: [*lines[:2], *lines[3:]], ["line 3", "t_s", "0.1", "instead of 0:"]),
        (lambda lines: [*lines[:4], lines[4] + ",1", *lines[5:]], ["line 5", "15 values for 14 columns"]),
        (lambda lines: [*lines[:4], "", *lines[5:]], ["line 5", "1 values"]),
        (without_column(2), ["no column 'theta1_rad'"]),
        (without_column(9), ["no column 'link1_fy_n'"]),
        (cell(2, 5, "force_n"), ["unknown", "'force_n'", "contact_force_n"]),
        (cell(2, 5, "l_m"), ["doubled", "'l_m'"]),
        (cell(5, 3, "nan"), ["line 5", "theta2_rad", "'nan' is not a finite number"]),
        (cell(5, 0, "inf"), ["line 5", "t_s", "'inf'"]),
        (cell(8, 1, "much"), ["line 8", "l_m", "'much'"]),
        (cell(8, 1, "0.4"), ["line 8", "l_m", "0.4", "-0.05 to 0.343"]),
        (cell(13, 4, "-3"), ["line 13", "theta3_rad", "-3", "-2.4 to 2.4"]),
        (cell(13, 5, "-3"), ["line 13", "contact_force_n", "negative"]),
        (head(schema=3), ["line 1: schema", "given 3"]),
        (head(robot="high-five"), ["'high-five'"]),
        (head(robot=None), ["line 1: robot"]),
        (head(base_m="near"), ["line 1: base_m", "'near'"]),
        (head(outcome="won"), ["line 1: outcome", "'won'", "reached"]),
        (head(stage="middle"), ["line 1: stage", "'middle'"]),
        (head(goal_m=[0.0, 0.3]), ["goal_m (0, 0.3) lies outside the pipe"]),
        (head(goal_m=[0.0]), ["line 1: goal_m"]),
        (head(pipe=[1, 2]), ["line 1: pipe"]),
        (head(pipe={"diameter_m": 0.1}), ["line 1: pipe.angle"]),
        (
            head(pipe={"turn": "left", "diameter_m": 0.5, "angle_rad": 1.0, "leg_m": 2.0}),
            ["line 1: pipe", "500 mm", "300 mm"],
        ),
    ],
)
def test_what_cannot_be_is_refused_by_name(tmp_path: Path, edit: Edit, names: list[str]) -> None:
    path = tmp_path / "front.csv"
    write_trajectory(path, recorded())
    path.write_text("".join(line + "\n" for line in edit(path.read_text().splitlines())))
    with pytest.raises((TrajectoryFileError, UnknownName)) as refusal:
        read_trajectory(path)
    message = str(refusal.value)
    assert all(name in message for name in names), message
    assert "\n" not in message
    assert message.endswith((".", "?"))


def test_a_file_of_schema_1_calls_reaching_front(tmp_path: Path) -> None:
    path = tmp_path / "front.csv"
    write_trajectory(path, recorded())
    edit = head(schema=1, stage="front")
    path.write_text("".join(line + "\n" for line in edit(path.read_text().splitlines())))
    assert read_trajectory(path).header.stage is PassageStage.REACH


def test_another_robot_is_refused_by_name(tmp_path: Path) -> None:
    write_trajectory(tmp_path / "front.csv", recorded())
    other = ROBOT.model_copy(update={"name": "other"})
    with pytest.raises(TrajectoryFileError, match="of robot 'basic', not of 'other'"):
        read_trajectory(tmp_path / "front.csv", other)


def test_keys_of_later_versions_are_skipped(tmp_path: Path) -> None:
    path = tmp_path / "front.csv"
    write_trajectory(path, recorded())
    path.write_text("\n".join(head(weather="dry")(path.read_text().splitlines())))
    assert read_trajectory(path).header == recorded().header


def test_files_that_are_none(tmp_path: Path) -> None:
    (tmp_path / "image.csv").write_bytes(b"\xff\xfe\x00")
    for name in ("missing.csv", ".", "image.csv"):
        with pytest.raises(PipenavError):
            read_trajectory(tmp_path / name)


def test_a_file_without_end_is_not_read_to_its_end() -> None:
    with pytest.raises(TrajectoryFileError, match="not a plain file"):
        read_trajectory(Path("/dev/zero"))
