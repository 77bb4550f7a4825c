"""`pipenav gen-pipe`: make a corner, a fitting, a route or a network, as files for simulators, printers and people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipenav.cli.gen_pipe_options import CornerOptions, FileOptions, FittingOptions
from pipenav.cli.option_groups import takes_option_groups

if TYPE_CHECKING:
    from pipenav.pipes.route import PipeRoute

OUT_HELP = "Folder in which the pipe's own folder is made; a pipe folder of the same name is replaced."

CORNER, FITTING = (tuple(field.name for field in fields(group)) for group in (CornerOptions, FittingOptions))
"""Names of the options of a corner and of the other fittings."""

REDUCER, TEE = ("to_d", "over"), ("tee", "branch_d", "way")

OutOption = Annotated[Path, typer.Option(metavar="FOLDER", help=OUT_HELP, rich_help_panel="Output")]


@takes_option_groups
def gen_pipe(
    context: typer.Context, corner: CornerOptions, fitting: FittingOptions, file: FileOptions, out: OutOption = Path()
) -> None:
    """Make a pipe, a corner or a network: STL meshes, MuJoCo, URDF and SDF models, a drawing, its numbers.

    A sharp corner to the left: pipenav gen-pipe --d 100 --angle 75

    An elbow to the right: pipenav gen-pipe --d 100 --angle 90 --turn right --bend-radius 1.5D --out my-pipes

    An S-bend: pipenav gen-pipe --d 100 --angle 135 --bend-radius 1.5D --s-bend

    A reducer: pipenav gen-pipe --d 100 --to-d 80

    A tee, passed into its branch: pipenav gen-pipe --d 100 --tee 90 --branch-d 80 --way into

    Corners in a row: pipenav gen-pipe --route my-route.toml

    A network: pipenav gen-pipe --network my-network.toml
    """
    if file.network is not None:
        _refuse(context, (*CORNER, *FITTING, "route"), "--network reads all pipes from its file")
        _make_network(Path(file.network), file.through, out)
    elif file.through is not None:
        raise typer.BadParameter("--through names nodes of a network: give --network FILE too.")
    elif file.route is not None:
        from pipenav.pipes.route_sets import parse_route

        _refuse(context, (*CORNER, *FITTING), "--route reads the whole route from its file")
        _write_route(*parse_route(file.route), out)
    elif fitting.tee is not None:
        _refuse(context, ("angle", "bend_radius", "s_bend", *REDUCER), "a tee has an angle of its own and no bend")
        _make_tee(corner, fitting, out)
    elif fitting.to_d is not None:
        _refuse(context, ("angle", "turn", "bend_radius", "s_bend", *TEE), "a reducer goes straight on")
        _make_reducer(corner, fitting.to_d, fitting.over, out)
    else:
        _refuse(context, ("over",), "--over is the length of a reducer, which --to-d makes")
        _refuse(context, ("branch_d", "way"), "--branch-d and --way belong to a tee, which --tee makes")
        _make_corner(corner, fitting.s_bend, out)


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


def _make_corner(corner: CornerOptions, twice: bool, out: Path) -> None:
    """Make the folder of a corner, or of the S-bend that has it twice."""
    from pipenav.cli.gen_pipe_report import corner_dimensions, report
    from pipenav.export.corner_folder import FILES, write_pipe_folder
    from pipenav.pipes.bend_radius import bend_radius_mm
    from pipenav.pipes.corner import PipeCorner
    from pipenav.pipes.s_bend import s_bend

    if corner.d is None or corner.angle is None:
        missing = " and ".join(f"--{name}" for name in ("d", "angle") if getattr(corner, name) is None)
        raise typer.BadParameter(
            f"{missing} missing: give --d and --angle for one corner, --d and --to-d for a reducer, --d and --tee "
            "for a tee, --route FILE for several corners, or --network FILE."
        )
    radius = bend_radius_mm(corner.bend_radius, corner.d)
    pipe = PipeCorner.of(corner.d, corner.angle, corner.turn, radius, corner.leg, corner.wall)
    if twice and not pipe.heading_change:
        raise typer.BadParameter("an angle of 180 deg makes no S-bend: give a smaller one, or leave out --s-bend.")
    if twice:
        _write_route(f"s-bend{pipe.name.removeprefix('corner')}", s_bend(pipe), out)
    else:
        report(write_pipe_folder(pipe, out), FILES, corner_dimensions(pipe))


def _make_reducer(corner: CornerOptions, to_d: float, over: float | None, out: Path) -> None:
    from pipenav.pipes.reducer import reducer

    if corner.d is None:
        raise typer.BadParameter("--d missing: give the diameter before the reducer too.")
    if corner.d == to_d:
        raise typer.BadParameter(f"--to-d {to_d:g} is the diameter before the reducer too: give another one.")
    route = reducer(corner.d, to_d, over, corner.leg, corner.wall)
    _write_route(f"reducer-d{corner.d:g}-to{to_d:g}", route, out)


def _make_tee(corner: CornerOptions, fitting: FittingOptions, out: Path) -> None:
    from pipenav.pipes.tee import TeePassage, tee_route

    if corner.d is None:
        raise typer.BadParameter("--d missing: give the diameter of the tee's run too.")
    assert fitting.tee is not None
    branch_d = corner.d if fitting.branch_d is None else fitting.branch_d
    passage = TeePassage(fitting.way, corner.turn)
    route = tee_route(corner.d, branch_d, fitting.tee, passage, corner.leg, corner.wall)
    narrower = "" if branch_d == corner.d else f"-b{branch_d:g}"
    _write_route(f"tee-d{corner.d:g}{narrower}-a{fitting.tee:g}-{fitting.way}-{corner.turn}", route, out)


def _make_network(path: Path, through: str | None, out: Path) -> None:
    """Make the folder of a network, or of the route through some of its nodes."""
    from pipenav.cli.gen_pipe_report import network_dimensions, report
    from pipenav.export.network_folder import FILES, write_network_folder
    from pipenav.pipes.network_file import read_network

    network = read_network(path)
    if through is None:
        report(write_network_folder(network, path.stem, out), FILES, network_dimensions(network))
    else:
        way = [name.strip() for name in through.split(",")]
        _write_route("-".join([path.stem, *way]), network.route(way), out)


def _write_route(name: str, route: PipeRoute, out: Path) -> None:
    from pipenav.cli.gen_pipe_report import report, route_dimensions
    from pipenav.export.route_folder import route_files, write_route_folder

    report(write_route_folder(route, name, out), route_files(route), route_dimensions(route))
