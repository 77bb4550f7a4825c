"""The command `gen-pipe`, through a small application of its own."""

from __future__ import annotations

from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner, Result

from pipenav.cli.gen_pipe import gen_pipe
from pipenav.errors import PipenavError
from pipenav.export.corner_folder import FILES, read_pipe
from pipenav.export.route_folder import read_route_folder, route_files
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.network_file import read_network
from pipenav.pipes.reducer import reducer
from pipenav.pipes.route_sets import parse_routes, read_route
from pipenav.pipes.s_bend import s_bend
from pipenav.pipes.tee import TeePassage, tee_route

NETWORK = """
schema = 1
nodes.a.at_mm = [0, 0]
nodes.b.at_mm = [700, 0]
nodes.c.at_mm = [1300, 0]
nodes.d.at_mm = [700, 600]
pipes = [
    { from = "a", to = "b", diameter_mm = 100 },
    { from = "b", to = "c", diameter_mm = 100 },
    { from = "b", to = "d", diameter_mm = 80 },
]
"""

app = typer.Typer()
app.command("gen-pipe")(gen_pipe)
WIDE = {"COLUMNS": "200", "TERM": "dumb", "NO_COLOR": "1"}


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the slow part, the drawing."""
    monkeypatch.setattr("pipenav.drawing.corner.draw_pipe", lambda _, path: path.write_bytes(b"png"))
    monkeypatch.setattr("pipenav.drawing.route.draw_route", lambda _, name, path: path.write_bytes(name.encode()))


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments], env=WIDE)


def test_makes_the_pipe_that_was_asked_for(tmp_path: Path) -> None:
    result = run("--d", 100, "--angle", 75, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert read_pipe(tmp_path / "corner-d100-a75-left") == PipeCorner.of(100, 75)


def test_every_option_reaches_the_pipe(tmp_path: Path) -> None:
    options = (
        "--turn",
        "right",
        "--bend-radius",
        150,
        "--leg",
        800,
        "--wall",
        4.5,
        "--out",
        tmp_path / "new" / "place",
    )
    assert run("--d", 62.5, "--angle", 90, *options).exit_code == 0
    folder = tmp_path / "new" / "place" / "corner-d62.5-a90-r150-right"
    assert read_pipe(folder) == PipeCorner.of(62.5, 90, "right", 150, leg_mm=800, wall_mm=4.5)


def test_says_what_it_made(tmp_path: Path) -> None:
    output = run("--d", 100, "--angle", 75, "--out", tmp_path).output
    assert str(tmp_path / "corner-d100-a75-left") in output.replace("\n", "")
    for name, purpose in FILES.items():
        assert name in output and purpose in output
    for dimension in ("164.3 mm", "65.2 mm", "changes by 105 deg to the left"):
        assert dimension in output


def test_a_straight_pipe_is_called_so(tmp_path: Path) -> None:
    assert "a straight pipe" in run("--d", 120, "--angle", 180, "--out", tmp_path).output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--d", 10, "--angle", 75), "diameter 10 mm is out of range: choose 40 to 300 mm."),
        (("--d", 100, "--angle", 20), "interior angle 20 deg is out of range: choose 30 to 180 deg."),
        (("--d", 100, "--angle", 75, "--turn", "up"), "turn 'up' is unknown: choose 'left' or 'right'."),
        (("--d", 100, "--angle", 75, "--leg", 10), "leg length 10 mm is out of range: choose 80 to 20000 mm."),
    ],
)
def test_a_problem_is_left_to_the_caller_and_nothing_is_made(
    tmp_path: Path, arguments: tuple[object, ...], message: str
) -> None:
    result = run(*arguments, "--out", tmp_path)
    assert isinstance(result.exception, PipenavError) and str(result.exception) == message
    assert list(tmp_path.iterdir()) == []


RUN = """
schema = 1
diameter_mm = 100
first_straight_mm = 800
[[corners]]
angle_deg = 90
turn = "left"
straight_mm = 500
[[corners]]
angle_deg = 62.5
turn = "right"
roll_deg = 90
straight_mm = 700
"""


def test_makes_the_route_of_a_file_in_a_folder_of_its_name(tmp_path: Path) -> None:
    file = tmp_path / "my-run.toml"
    file.write_text(RUN)
    result = run("--run", file, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    made = read_route(file)
    assert read_route_folder(tmp_path / "my-run") == made
    for name, purpose in route_files(made).items():
        assert name in result.output and purpose in result.output
    for text in ("2.00 m", "in space", "62.5 deg", "to the right after a roll of 90 deg, then 700.0 mm"):
        assert text in result.output


def test_makes_a_route_of_a_shipped_set(tmp_path: Path) -> None:
    result = run("--run", "runs-level:7", "--out", tmp_path)
    assert result.exit_code == 0 and "in one plane" in result.output
    assert read_route_folder(tmp_path / "runs-level-7") == parse_routes(["runs-level"])[6]


def test_makes_a_reducer(tmp_path: Path) -> None:
    result = run("--d", 100, "--to-d", 80, "--leg", 700, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert "80.0 mm  over 100 mm, then 700.0 mm" in result.output
    assert read_route_folder(tmp_path / "reducer-d100-to80") == reducer(100, 80, 100, 700)
    assert run("--d", 100, "--to-d", 80, "--over", 0, "--out", tmp_path).exit_code == 0
    assert read_route_folder(tmp_path / "reducer-d100-to80") == reducer(100, 80, 0)


def test_makes_a_tee_in_every_way(tmp_path: Path) -> None:
    for way in ("straight", "into", "out"):
        options = ("--tee", 60, "--branch-d", 80, "--way", way, "--turn", "right", "--out", tmp_path)
        result = run("--d", 100, *options)
        assert result.exit_code == 0, result.output
        made = read_route_folder(tmp_path / f"tee-d100-b80-a60-{way}-right")
        assert made == tee_route(100, 80, 60, TeePassage(way, "right"))
        assert "branch" in result.output


def test_makes_a_network_and_a_route_through_it(tmp_path: Path) -> None:
    file = tmp_path / "town.toml"
    file.write_text(NETWORK)
    result = run("--network", file, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert {path.name for path in (tmp_path / "town").iterdir()} >= {"network.json", "tube.stl", "pipe.xml"}
    assert "1.90 m  of 3 pipes, from node to node" in result.output
    assert run("--network", file, "--through", "a, b ,d", "--out", tmp_path).exit_code == 0
    assert read_route_folder(tmp_path / "town-a-b-d") == read_network(file).route(["a", "b", "d"])


def test_makes_an_s_bend_of_a_corner(tmp_path: Path) -> None:
    corner = ("--d", 100, "--angle", 135, "--turn", "right", "--bend-radius", "1.5D", "--leg", 700)
    assert run(*corner, "--s-bend", "--out", tmp_path).exit_code == 0
    folder = tmp_path / "s-bend-d100-a135-r150-right"
    made = s_bend(PipeCorner.of(100, 135, "right", 150, leg_mm=700))
    assert read_route_folder(folder) == made
    assert (folder / "run.json").read_text().startswith('{\n  "schema": 2')


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--run", "runs-level:1", "--d", 100, "--bend-radius", 0), "leave out --d, --bend-radius."),
        (("--run", "runs-level:1", "--wall", 3), "leave out --wall."),
        (("--run", "runs-level:1", "--s-bend"), "leave out --s-bend."),
        (("--d", 100, "--to-d", 80, "--angle", 90), "a reducer goes straight on: leave out --angle."),
        (("--d", 100, "--to-d", 80, "--tee", 90), "a tee has an angle of its own and no bend: leave out --to-d."),
        (("--d", 100, "--angle", 90, "--branch-d", 80), "belong to a tee, which --tee makes: leave out --branch-d."),
        (("--tee", 90), "--d missing: give the diameter of the tee's run too."),
        (("--network", "x.toml", "--d", 100), "--network reads all pipes from its file: leave out --d."),
        (("--through", "a,b"), "--through names nodes of a network: give --network FILE too."),
        (("--d", 100, "--angle", 90, "--over", 50), "--over is the length of a reducer, which --to-d makes: leave out"),
        (("--d", 100, "--to-d", 100), "--to-d 100 is the diameter before the reducer too: give another one."),
        (("--d", 100, "--angle", 180, "--s-bend"), "an angle of 180 deg makes no S-bend: give a smaller one"),
        (("--to-d", 80), "--d missing: give the diameter before the reducer too."),
        (
            ("--d", 100),
            "--angle missing: give --d and --angle for one corner, --d and --to-d for a reducer, --d and --tee",
        ),
        ((), "--d and --angle missing"),
    ],
)
def test_a_route_and_a_corner_are_not_mixed(tmp_path: Path, arguments: tuple[object, ...], message: str) -> None:
    result = run(*arguments, "--out", tmp_path)
    assert result.exit_code == 2
    assert message in " ".join(result.output.replace("│", " ").split())
    assert list(tmp_path.iterdir()) == []


def test_a_route_that_is_not_possible_is_left_to_the_caller_and_nothing_is_made(tmp_path: Path) -> None:
    file = tmp_path / "my-run.toml"
    file.write_text(RUN.replace("500", "50"))
    result = run("--run", file, "--out", tmp_path)
    assert isinstance(result.exception, PipenavError)
    assert str(result.exception).startswith(f"{file}: length of straight 2, 50 mm, is out of range: choose ")
    assert list(tmp_path.iterdir()) == [file]


def test_help_names_units_ranges_and_examples() -> None:
    output = " ".join(run("--help").output.replace("│", " ").split())
    for text in (
        "in mm, 40 to 300",
        "in deg, 30 to 180",
        "0.5 to 50",
        "pipenav gen-pipe --d 100 --angle 75",
        "left or right",
        "pipenav gen-pipe --route my-route.toml",
        "runs-level:3",
    ):
        assert text in output
