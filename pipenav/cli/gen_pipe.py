"""`pipenav gen-pipe`: make one pipe corner, as files for simulators, printers and people."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pipenav.pipe import (
    ANGLE_RANGE_DEG,
    BEND_RADIUS_MAX_MM,
    DEFAULT_WALL,
    DIAMETER_RANGE_MM,
    LEG_MAX_MM,
    WALL_RANGE_MM,
    Pipe,
)
from pipenav.units import m_to_mm, rad_to_deg

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
OUT_HELP = "Folder in which the pipe's own folder is made; a pipe folder of the same name is replaced."


def gen_pipe(
    d: Annotated[float, typer.Option("--d", metavar="MM", help=DIAMETER_HELP, show_default=False)],
    angle: Annotated[float, typer.Option(metavar="DEG", help=ANGLE_HELP, show_default=False)],
    turn: Annotated[str, typer.Option(metavar="SIDE", help=TURN_HELP)] = "left",
    bend_radius: Annotated[float, typer.Option(metavar="MM", help=BEND_HELP)] = 0.0,
    leg: Annotated[float | None, typer.Option(metavar="MM", help=LEG_HELP, show_default=False)] = None,
    wall: Annotated[float, typer.Option(metavar="MM", help=WALL_HELP)] = m_to_mm(DEFAULT_WALL),
    out: Annotated[Path, typer.Option(metavar="FOLDER", help=OUT_HELP)] = Path(),
) -> None:
    """Make a pipe corner: a folder with STL meshes, MuJoCo, URDF and SDF models, a drawing and its numbers.

    A sharp corner to the left: pipenav gen-pipe --d 100 --angle 75

    A swept bend to the right: pipenav gen-pipe --d 100 --angle 90 --turn right --bend-radius 150 --out my-pipes
    """
    from pipenav.pipe_export import write_pipe_folder

    pipe = Pipe.of(d, angle, turn, bend_radius, leg, wall)
    _report(pipe, write_pipe_folder(pipe, out))


def _report(pipe: Pipe, folder: Path) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from pipenav.pipe_export import FILES

    console = Console(highlight=False, soft_wrap=True)
    console.print(Text.assemble("Made ", (str(folder), "bold")))
    files = Table.grid(padding=(0, 2))
    for name, purpose in FILES.items():
        files.add_row("", Text(name, style="cyan"), purpose)
    console.print(files)
    console.print()
    sizes = Table.grid(padding=(0, 2))
    for what, value, note in _key_dimensions(pipe):
        sizes.add_row("", what, Text(value, style="bold", justify="right"), note)
    console.print(sizes)


def _key_dimensions(pipe: Pipe) -> list[tuple[str, str, str]]:
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


def _heading(pipe: Pipe) -> str:
    change = abs(rad_to_deg(pipe.heading_change))
    return f"interior: the heading changes by {change:g} deg to the {pipe.turn}" if change else "a straight pipe"
