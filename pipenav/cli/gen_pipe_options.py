"""The options of `pipenav gen-pipe`, in the groups that its help shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import typer

from pipenav.cli.option_groups import OptionGroup
from pipenav.pipes.corner_checks import (
    ANGLE_RANGE_DEG,
    BEND_RADIUS_MAX_MM,
    DIAMETER_RANGE_MM,
    LEG_MAX_MM,
    WALL_RANGE_MM,
)
from pipenav.pipes.pipe import DEFAULT_WALL
from pipenav.units import m_to_mm

DIAMETER_HELP = f"Inner diameter in mm, {DIAMETER_RANGE_MM[0]:g} to {DIAMETER_RANGE_MM[1]:g}."
ANGLE_HELP = (
    f"Interior angle between the legs in deg, {ANGLE_RANGE_DEG[0]:g} to {ANGLE_RANGE_DEG[1]:g}: "
    "small is sharp, 180 is a straight pipe."
)
TURN_HELP = "Side that the pipe turns to, or where the branch of a tee lies, seen by the robot: left or right."
BEND_HELP = (
    f"Radius of the centre line's bend in mm, 0 to {BEND_RADIUS_MAX_MM:g}, or in diameters, for example 1.5D; "
    "0 is a mitre."
)
LEG_HELP = (
    f"Length of each leg along its centre line, from the corner, in mm, up to {LEG_MAX_MM:g}. "
    "By default as long as the corner and a robot need, 600 or more."
)
WALL_HELP = f"Wall thickness in mm, {WALL_RANGE_MM[0]:g} to {WALL_RANGE_MM[1]:g}."
TO_D_HELP = "Make a reducer instead of a corner: the inner diameter behind it, in mm."
OVER_HELP = "Length of a reducer along its centre line, in mm; 0 is a step. By default the larger diameter."
S_BEND_HELP = "Make the corner twice, the second time to the other side, as near to the first as they fit."
TEE_HELP = (
    "Make a tee instead of a corner: the interior angle between its branch and the part of its run that the robot "
    "passes, in deg, 30 to 150."
)
BRANCH_D_HELP = "Inner diameter of the tee's branch in mm, up to --d. By default --d."
WAY_HELP = "The robot's way through the tee: straight past the branch, into it, or out of it."
ROUTE_HELP = (
    "Several corners in a row: a route's TOML file, or a route of a shipped set by its number, for example "
    "runs-level:3; see `pipenav list pipes`. --run is the older name of this option."
)
NETWORK_HELP = "A whole network of pipes: its TOML file."
THROUGH_HELP = "Names of nodes of the network, separated by commas: make the route through them instead of the whole."

DEFAULT_WALL_MM = m_to_mm(DEFAULT_WALL)


@dataclass(frozen=True)
class CornerOptions(OptionGroup):
    """A single corner."""

    panel: ClassVar[str] = "One corner"
    d: Annotated[float | None, typer.Option("--d", metavar="MM", help=DIAMETER_HELP, show_default=False)] = None
    angle: Annotated[float | None, typer.Option(metavar="DEG", help=ANGLE_HELP, show_default=False)] = None
    turn: Annotated[str, typer.Option(metavar="SIDE", help=TURN_HELP)] = "left"
    bend_radius: Annotated[str, typer.Option(metavar="MM|xD", help=BEND_HELP)] = "0"
    leg: Annotated[float | None, typer.Option(metavar="MM", help=LEG_HELP, show_default=False)] = None
    wall: Annotated[float, typer.Option(metavar="MM", help=WALL_HELP)] = DEFAULT_WALL_MM


@dataclass(frozen=True)
class FittingOptions(OptionGroup):
    """Another fitting in the corner's place."""

    panel: ClassVar[str] = "Other fittings"
    s_bend: Annotated[bool, typer.Option("--s-bend", help=S_BEND_HELP)] = False
    to_d: Annotated[float | None, typer.Option("--to-d", metavar="MM", help=TO_D_HELP, show_default=False)] = None
    over: Annotated[float | None, typer.Option(metavar="MM", help=OVER_HELP, show_default=False)] = None
    tee: Annotated[float | None, typer.Option(metavar="DEG", help=TEE_HELP, show_default=False)] = None
    branch_d: Annotated[
        float | None, typer.Option("--branch-d", metavar="MM", help=BRANCH_D_HELP, show_default=False)
    ] = None
    way: Annotated[str, typer.Option(metavar="straight|into|out", help=WAY_HELP)] = "straight"


@dataclass(frozen=True)
class FileOptions(OptionGroup):
    """A file that describes the whole."""

    panel: ClassVar[str] = "Routes and networks"
    route: Annotated[
        str | None, typer.Option("--route", "--run", metavar="FILE|NAME:K", help=ROUTE_HELP, show_default=False)
    ] = None
    network: Annotated[str | None, typer.Option(metavar="FILE", help=NETWORK_HELP, show_default=False)] = None
    through: Annotated[str | None, typer.Option(metavar="A,B,C", help=THROUGH_HELP, show_default=False)] = None
