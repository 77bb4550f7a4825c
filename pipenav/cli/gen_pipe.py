"""`pipenav gen-pipe`: make one pipe corner or a route, as files for simulators, printers and people."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from pipenav.pipes.bend_radius import bend_radius_mm
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
    from collections.abc import Sequence

    from pipenav.pipes.route import PipeRoute

DIAMETER_HELP = f"Inner diameter in mm, {DIAMETER_RANGE_MM[0]:g} to {DIAMETER_RANGE_MM[1]:g}."
ANGLE_HELP = (
    f"Interior angle between the legs in deg, {ANGLE_RANGE_DEG[0]:g} to {ANGLE_RANGE_DEG[1]:g}: "
    "small is sharp, 180 is a straight pipe."
)
TURN_HELP = "Side that the pipe turns to, seen by the robot: left or right."
BEND_HELP = (
    f"Radius of the centre line's bend in mm, 0 to {BEND_RADIUS_MAX_MM:g}, or in diameters, for example 1.5D; "
    "0 is a mitre."
)
TO_D_HELP = "Make a reducer instead of a corner: the inner diameter behind it, in mm."
OVER_HELP = "Length of a reducer along its centre line, in mm; 0 is a step. By default the larger diameter."
S_BEND_HELP = "Make the corner twice, the second time to the other side, as near to the first as they fit."
LEG_HELP = (
    f"Length of each leg along its centre line, from the corner, in mm, up to {LEG_MAX_MM:g}. "
    "By default as long as the corner and a robot need, 600 or more."
)
WALL_HELP = f"Wall thickness in mm, {WALL_RANGE_MM[0]:g} to {WALL_RANGE_MM[1]:g}."
ROUTE_HELP = (
    "Several corners in a row instead of one: a route's TOML file, or one of a shipped set by its number, for example "
    "runs-level:3; see `pipenav list pipes`. --run is the older name of this option."
)
OUT_HELP = "Folder in which the pipe's own folder is made; a pipe folder of the same name is replaced."

DEFAULT_WALL_MM = m_to_mm(DEFAULT_WALL)
CORNER, ROUTE, OUTPUT = "One corner", "Several corners", "Output"

CORNER_OPTIONS = ("d", "angle", "turn", "bend_radius", "leg", "wall", "s_bend", "to_d", "over")
"""Parameters of one corner, which a route takes from its file."""


DiameterOption = Annotated[
    float | None, typer.Option("--d", metavar="MM", help=DIAMETER_HELP, show_default=False, rich_help_panel=CORNER)
]
AngleOption = Annotated[
    float | None, typer.Option(metavar="DEG", help=ANGLE_HELP, show_default=False, rich_help_panel=CORNER)
]
TurnOption = Annotated[str, typer.Option(metavar="SIDE", help=TURN_HELP, rich_help_panel=CORNER)]
BendRadiusOption = Annotated[str, typer.Option(metavar="MM|xD", help=BEND_HELP, rich_help_panel=CORNER)]
LegOption = Annotated[
    float | None, typer.Option(metavar="MM", help=LEG_HELP, show_default=False, rich_help_panel=CORNER)
]
WallOption = Annotated[float, typer.Option(metavar="MM", help=WALL_HELP, rich_help_panel=CORNER)]
SBendOption = Annotated[bool, typer.Option("--s-bend", help=S_BEND_HELP, rich_help_panel=ROUTE)]
ToDiameterOption = Annotated[
    float | None, typer.Option("--to-d", metavar="MM", help=TO_D_HELP, show_default=False, rich_help_panel=ROUTE)
]
OverOption = Annotated[
    float | None, typer.Option(metavar="MM", help=OVER_HELP, show_default=False, rich_help_panel=ROUTE)
]
RouteOption = Annotated[
    str | None,
    typer.Option("--route", "--run", metavar="FILE|NAME:K", help=ROUTE_HELP, show_default=False, rich_help_panel=ROUTE),
]
OutOption = Annotated[Path, typer.Option(metavar="FOLDER", help=OUT_HELP, rich_help_panel=OUTPUT)]


def gen_pipe(
    context: typer.Context,
    d: DiameterOption = None,
    angle: AngleOption = None,
    turn: TurnOption = "left",
    bend_radius: BendRadiusOption = "0",
    leg: LegOption = None,
    wall: WallOption = DEFAULT_WALL_MM,
    s_bend: SBendOption = False,
    to_d: ToDiameterOption = None,
    over: OverOption = None,
    route: RouteOption = None,
    out: OutOption = Path(),
) -> None:
    """Make a pipe, one corner or several: STL meshes, MuJoCo, URDF and SDF models, a drawing, its numbers.

    A sharp corner to the left: pipenav gen-pipe --d 100 --angle 75

    An elbow to the right: pipenav gen-pipe --d 100 --angle 90 --turn right --bend-radius 1.5D --out my-pipes

    An S-bend: pipenav gen-pipe --d 100 --angle 135 --bend-radius 1.5D --s-bend

    A reducer: pipenav gen-pipe --d 100 --to-d 80

    Corners in a row: pipenav gen-pipe --route my-route.toml
    """
    from pipenav.pipes.route_sets import parse_route

    if route is not None:
        _refuse(context, CORNER_OPTIONS, "--route reads the whole route from its file")
        _write_route(*parse_route(route), out)
    elif d is not None and to_d is not None:
        from pipenav.pipes.reducer import reducer

        if d == to_d:
            raise typer.BadParameter(f"--to-d {to_d:g} is the diameter before the reducer too: give another one.")
        _refuse(context, ("angle", "turn", "bend_radius", "s_bend"), "a reducer goes straight on")
        _write_route(f"reducer-d{d:g}-to{to_d:g}", reducer(d, to_d, over, leg, wall), out)
    elif to_d is not None:
        raise typer.BadParameter("--d missing: give the diameter before the reducer too.")
    elif d is None or angle is None:
        missing = " and ".join(f"--{name}" for name, given in (("d", d), ("angle", angle)) if given is None)
        raise typer.BadParameter(
            f"{missing} missing: give --d and --angle for one corner, --d and --to-d for a reducer, or --route FILE "
            "for several corners."
        )
    else:
        _refuse(context, ("over",), "--over is the length of a reducer, which --to-d makes")
        corner = PipeCorner.of(d, angle, turn, bend_radius_mm(bend_radius, d), leg, wall)
        _write_corner(corner, s_bend, out)


def _refuse(context: typer.Context, names: Sequence[str], reason: str) -> None:
    """Refuse options that were typed and would do nothing.

    Raises:
        BadParameter: with their names.
    """
    sources = {name: context.get_parameter_source(name) for name in names}
    given = [
        f"--{name.replace('_', '-')}" for name, source in sources.items() if source and source.name == "COMMANDLINE"
    ]
    if given:
        raise typer.BadParameter(f"{reason}: leave out {', '.join(given)}.")


def _write_corner(corner: PipeCorner, twice: bool, out: Path) -> None:
    """Write the folder of a corner, or of the S-bend that has it twice."""
    from pipenav.export.corner_folder import FILES, write_pipe_folder
    from pipenav.pipes.s_bend import s_bend

    if twice and not corner.heading_change:
        raise typer.BadParameter("an angle of 180 deg makes no S-bend: give a smaller one, or leave out --s-bend.")
    if twice:
        _write_route(f"s-bend{corner.name.removeprefix('corner')}", s_bend(corner), out)
    else:
        _report(write_pipe_folder(corner, out), FILES, _corner_dimensions(corner))


def _write_route(name: str, route: PipeRoute, out: Path) -> None:
    from pipenav.export.route_folder import route_files, write_route_folder

    _report(write_route_folder(route, name, out), route_files(route), _route_dimensions(route))


class _Dimension(NamedTuple):
    """A line about a dimension: its name, its value with the unit, and what it means."""

    name: str
    value: str
    meaning: str


def _report(folder: Path, purposes: dict[str, str], dimensions: list[_Dimension]) -> None:
    """Say what was made.

    Args:
        folder: folder of the pipe.
        purposes: files of the folder, each with one line that says what it is for.
        dimensions: dimensions of the pipe.
    """
    from rich.table import Table
    from rich.text import Text

    from pipenav.cli.terminal import say, show

    say(f"Made {folder}", "bold")
    files = Table.grid(padding=(0, 2))
    for name, purpose in purposes.items():
        files.add_row("", Text(name, style="cyan"), purpose)
    show(files, "")
    sizes = Table.grid(padding=(0, 2))
    for dimension in dimensions:
        value = Text(dimension.value, style="bold", justify="right")
        sizes.add_row("", dimension.name, value, dimension.meaning)
    show(sizes)


def _corner_dimensions(pipe: PipeCorner) -> list[_Dimension]:
    """Dimensions of a corner that decide whether a robot fits."""
    bend = f"{m_to_mm(pipe.bend_radius):.1f} mm" if pipe.bend_radius else "none"
    return [
        _Dimension("diameter", f"{m_to_mm(pipe.diameter):.1f} mm", "inside"),
        _Dimension("angle", f"{rad_to_deg(pipe.angle):.1f} deg", _heading(pipe)),
        _Dimension("bend radius", bend, "of the centre line" if pipe.bend_radius else "a mitre"),
        _Dimension("leg", f"{m_to_mm(pipe.leg):.1f} mm", "each, from the crossing of the centre lines"),
        _Dimension("wall", f"{m_to_mm(pipe.wall):.1f} mm", "outside of the diameter"),
        _Dimension("gap", f"{m_to_mm(pipe.gap):.1f} mm", "across the corner, from wall to wall"),
        _Dimension(
            "inner edge", f"{m_to_mm(pipe.inner_edge):.1f} mm", "before the corner, where the inner wall begins to turn"
        ),
    ]


def _heading(pipe: PipeCorner) -> str:
    change = abs(rad_to_deg(pipe.heading_change))
    return f"interior: the heading changes by {change:g} deg to the {pipe.turn}" if change else "a straight pipe"


def _route_dimensions(route: PipeRoute) -> list[_Dimension]:
    """Dimensions of a route and of every corner in it that decide whether a robot fits."""
    plane = "in one plane" if route.planar else "in space"
    dimensions = [
        _Dimension("diameter", f"{m_to_mm(route.diameter):.1f} mm", "inside"),
        _Dimension("wall", f"{m_to_mm(route.wall):.1f} mm", "outside of the diameter"),
        _Dimension("length", f"{sum(route.straights):.2f} m", f"along the centre line, {plane}"),
        _Dimension("start", f"{m_to_mm(route.straights[0]):.1f} mm", "to the first corner"),
    ]
    for i, (corner, straight) in enumerate(zip(route.corners, route.straights[1:], strict=True), 1):
        roll = f" after a roll of {rad_to_deg(corner.roll):g} deg" if corner.roll else ""
        bend = f" in a bend of {m_to_mm(corner.bend_radius):g} mm" if corner.bend_radius else ""
        then = f"to the {corner.turn}{bend}{roll}, then {m_to_mm(straight):.1f} mm"
        if corner.to_diameter is None:
            dimensions.append(_Dimension(f"corner {i}", f"{rad_to_deg(corner.angle):.1f} deg", then))
        else:
            shape = f"over {m_to_mm(corner.length):g} mm" if corner.length else "in a step"
            over = f"{shape}, then {m_to_mm(straight):.1f} mm"
            dimensions.append(_Dimension(f"reducer {i}", f"{m_to_mm(corner.to_diameter):.1f} mm", over))
    return dimensions
