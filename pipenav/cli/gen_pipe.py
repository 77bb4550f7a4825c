"""`pipenav gen-pipe`: make one pipe corner or a run of them, as files for simulators, printers and people."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.corner_checks import (
    ANGLE_RANGE_DEG,
    BEND_RADIUS_MAX_MM,
    DIAMETER_RANGE_MM,
    LEG_MAX_MM,
    WALL_RANGE_MM,
)
from pipenav.pipes.pipe import DEFAULT_WALL
from pipenav.units import m_to_mm, rad_to_deg

if TYPE_CHECKING:
    from pipenav.pipes.route import PipeRoute

DIAMETER_HELP = f"Inner diameter in mm, {DIAMETER_RANGE_MM[0]:g} to {DIAMETER_RANGE_MM[1]:g}."
ANGLE_HELP = (
    f"Interior angle between the legs in deg, {ANGLE_RANGE_DEG[0]:g} to {ANGLE_RANGE_DEG[1]:g}: "
    "small is sharp, 180 is a straight pipe."
)
TURN_HELP = "Side that the pipe turns to, seen by the robot: left or right."
BEND_HELP = f"Radius of the centre line's bend in mm, 0 to {BEND_RADIUS_MAX_MM:g}; 0 is a mitre."
LEG_HELP = (
    f"Length of each leg along its centre line, from the corner, in mm, up to {LEG_MAX_MM:g}. "
    "By default as long as the corner and a robot need, 600 or more."
)
WALL_HELP = f"Wall thickness in mm, {WALL_RANGE_MM[0]:g} to {WALL_RANGE_MM[1]:g}."
RUN_HELP = (
    "Several corners in a row instead of one: a pipe-run TOML (docs/pipe-run.md), "
    "or one run of a shipped set, as runs-level:3."
)
OUT_HELP = "Folder in which the pipe's own folder is made; a pipe folder of the same name is replaced."


OF_ONE_CORNER = ("d", "angle", "turn", "bend_radius", "leg", "wall")
"""The parameters that a run takes from its file."""


def gen_pipe(
    context: typer.Context,
    d: Annotated[float | None, typer.Option("--d", metavar="MM", help=DIAMETER_HELP, show_default=False)] = None,
    angle: Annotated[float | None, typer.Option(metavar="DEG", help=ANGLE_HELP, show_default=False)] = None,
    turn: Annotated[str, typer.Option(metavar="SIDE", help=TURN_HELP)] = "left",
    bend_radius: Annotated[float, typer.Option(metavar="MM", help=BEND_HELP)] = 0.0,
    leg: Annotated[float | None, typer.Option(metavar="MM", help=LEG_HELP, show_default=False)] = None,
    wall: Annotated[float, typer.Option(metavar="MM", help=WALL_HELP)] = m_to_mm(DEFAULT_WALL),
    run: Annotated[str | None, typer.Option(metavar="FILE", help=RUN_HELP, show_default=False)] = None,
    out: Annotated[Path, typer.Option(metavar="FOLDER", help=OUT_HELP)] = Path(),
) -> None:
    """Make a pipe, one corner or several: STL meshes, MuJoCo, URDF and SDF models, a drawing, its numbers.

    A sharp corner to the left: pipenav gen-pipe --d 100 --angle 75

    A swept bend to the right: pipenav gen-pipe --d 100 --angle 90 --turn right --bend-radius 150 --out my-pipes

    Corners in a row: pipenav gen-pipe --run my-run.toml
    """
    if run is not None:
        _refuse_options_of_one_corner(context)
        _make_run(run, out)
        return
    if d is None or angle is None:
        missing = " and ".join(f"--{name}" for name, given in (("d", d), ("angle", angle)) if given is None)
        raise typer.BadParameter(f"{missing} missing: give --d and --angle for one corner, or --run FILE for a run.")
    from pipenav.export.corner_folder import FILES, write_pipe_folder

    pipe = PipeCorner.of(d, angle, turn, bend_radius, leg, wall)
    _report(write_pipe_folder(pipe, out), FILES, _key_dimensions(pipe))


def _refuse_options_of_one_corner(context: typer.Context) -> None:
    sources = {name: context.get_parameter_source(name) for name in OF_ONE_CORNER}
    given = [
        f"--{name.replace('_', '-')}" for name, source in sources.items() if source and source.name == "COMMANDLINE"
    ]
    if given:
        raise typer.BadParameter(f"--run takes all of a run from its file: leave out {', '.join(given)}.")


def _make_run(text: str, out: Path) -> None:
    from pipenav.export.route_folder import route_files, write_route_folder
    from pipenav.pipes.route_sets import parse_route

    name, run = parse_route(text)
    _report(write_route_folder(run, name, out), route_files(run), _key_dimensions_of_run(run))


def _report(folder: Path, purposes: dict[str, str], dimensions: list[tuple[str, str, str]]) -> None:
    """Say what was made.

    Args:
        folder: where it is.
        purposes: its files, each with one line of what it is.
        dimensions: what, how much and what it means.
    """
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(highlight=False, soft_wrap=True)
    console.print(Text.assemble("Made ", (str(folder), "bold")))
    files = Table.grid(padding=(0, 2))
    for name, purpose in purposes.items():
        files.add_row("", Text(name, style="cyan"), purpose)
    console.print(files)
    console.print()
    sizes = Table.grid(padding=(0, 2))
    for what, value, note in dimensions:
        sizes.add_row("", what, Text(value, style="bold", justify="right"), note)
    console.print(sizes)


def _key_dimensions(pipe: PipeCorner) -> list[tuple[str, str, str]]:
    """What, how much and what it means, of the dimensions that decide whether a robot fits."""
    bend = f"{m_to_mm(pipe.bend_radius):.1f} mm" if pipe.bend_radius else "none"
    return [
        ("diameter", f"{m_to_mm(pipe.diameter):.1f} mm", "inside"),
        ("angle", f"{rad_to_deg(pipe.angle):.1f} deg", _heading(pipe)),
        ("bend radius", bend, "of the centre line" if pipe.bend_radius else "a mitre"),
        ("leg", f"{m_to_mm(pipe.leg):.1f} mm", "each, from the crossing of the centre lines"),
        ("wall", f"{m_to_mm(pipe.wall):.1f} mm", "outside of the diameter"),
        ("gap", f"{m_to_mm(pipe.gap):.1f} mm", "across the corner, from wall to wall"),
        ("inner edge", f"{m_to_mm(pipe.inner_edge):.1f} mm", "before the corner the inner wall begins to turn"),
    ]


def _heading(pipe: PipeCorner) -> str:
    change = abs(rad_to_deg(pipe.heading_change))
    return f"interior: the heading changes by {change:g} deg to the {pipe.turn}" if change else "a straight pipe"


def _key_dimensions_of_run(run: PipeRoute) -> list[tuple[str, str, str]]:
    """As for one corner, of the run and of every corner in it."""
    plane = "in one plane" if run.planar else "in space"
    dimensions = [
        ("diameter", f"{m_to_mm(run.diameter):.1f} mm", "inside"),
        ("wall", f"{m_to_mm(run.wall):.1f} mm", "outside of the diameter"),
        ("length", f"{sum(run.straights):.2f} m", f"along the centre line, {plane}"),
        ("start", f"{m_to_mm(run.straights[0]):.1f} mm", "to the first corner"),
    ]
    for i, (corner, straight) in enumerate(zip(run.corners, run.straights[1:], strict=True), 1):
        roll = f" after a roll of {rad_to_deg(corner.roll):g} deg" if corner.roll else ""
        then = f"to the {corner.turn}{roll}, then {m_to_mm(straight):.1f} mm"
        dimensions.append((f"corner {i}", f"{rad_to_deg(corner.angle):.1f} deg", then))
    return dimensions
