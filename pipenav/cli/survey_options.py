"""The options of `pipenav survey`, in the groups that its help shows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import typer

from pipenav.cli.option_groups import OptionGroup

DIAMETER_HELP = "Field of the diameters and its unit, as in bore:mm, for GeoJSON, CSV and shapefiles."
SNAP_HELP = "Distance within which ends of lines are one node, in m."
COORDINATES_HELP = "Unit of coordinates in files of lines; lonlat for degrees."
SERVICE_HELP = "Bore up to which a line is a service, which is not surveyed, in mm; 0 for none but those that say so."
ACCURACY_HELP = "Standard deviation of a position in the map on each axis, in m."
BENDS_HELP = "Radius of bends that state none: 0 for mitres, or in bores, as in 1.5D."
CONFIDENCE_HELP = "Least probability of passing a fitting, and of coming to a place."
FROM_HELP = "Nodes by which the robot goes in, separated by commas; without it, entries are proposed."
ENTRIES_HELP = "Entries to propose: a number, or the share of the length in the robot's bores that they should see."

IDEAL_HELP = (
    "Take a perfect policy in place of trials: it passes all that the robot's shape can, in the policy's bores."
)


@dataclass(frozen=True)
class MapOptions(OptionGroup):
    """Options of the reader and of the map."""

    panel: ClassVar[str] = "The map"
    diameter: Annotated[str | None, typer.Option(metavar="FIELD:UNIT", help=DIAMETER_HELP)] = None
    snap: Annotated[float, typer.Option(min=0.0, max=10.0, metavar="M", help=SNAP_HELP)] = 0.1
    coordinates: Annotated[
        Literal["auto", "m", "ft", "lonlat"], typer.Option(metavar="auto|m|ft|lonlat", help=COORDINATES_HELP)
    ] = "auto"
    service_bore: Annotated[float, typer.Option(min=0.0, max=1000.0, metavar="MM", help=SERVICE_HELP)] = 0.0
    accuracy: Annotated[float, typer.Option(min=0.0, max=10.0, metavar="M", help=ACCURACY_HELP)] = 0.25
    bends: Annotated[str, typer.Option(metavar="xD", help=BENDS_HELP)] = "0"


@dataclass(frozen=True)
class WayOptions(OptionGroup):
    """Options of the robot's ways."""

    panel: ClassVar[str] = "Ways of the robot"
    entry: Annotated[str | None, typer.Option("--from", metavar="NODE,...", help=FROM_HELP)] = None
    entries: Annotated[str | None, typer.Option(metavar="N|X%", help=ENTRIES_HELP, show_default="80%")] = None
    confidence: Annotated[float, typer.Option(min=0.01, max=1.0, help=CONFIDENCE_HELP)] = 0.95
    untethered: Annotated[bool, typer.Option("--untethered", help="The robot pulls no cable.")] = False
    cable: Annotated[float, typer.Option(min=1.0, max=100_000.0, metavar="M", help="Length of the cable, in m.")] = (
        250.0
    )
    pull: Annotated[float, typer.Option(min=0.01, max=10_000.0, metavar="N", help="Pull of the robot, in N.")] = 14.0
    friction: Annotated[float, typer.Option(min=0.0, max=2.0, help="Friction of the cable in the pipe.")] = 0.3
    cable_weight: Annotated[
        float, typer.Option(min=0.0, max=1000.0, metavar="N/M", help="Weight of the cable, in N/m.")
    ] = 0.185


@dataclass(frozen=True)
class TrialOptions(OptionGroup):
    """Options of the trials of classes."""

    panel: ClassVar[str] = "Trials"
    policy: Annotated[str, typer.Option(help="Policy of a whole robot: a shipped one's name or FILE.zip.")] = "pirate"
    episodes: Annotated[int, typer.Option(min=2, max=100_000, help="Episodes in each class of fittings.")] = 20
    seed: Annotated[int, typer.Option(min=0, help="Seed of the starts.")] = 0
    backend: Annotated[str, typer.Option(help="Simulator backend; see `pipenav backends`.")] = "mujoco"
    option: Annotated[list[str] | None, typer.Option("--option", help="Backend setting, key=value; repeatable.")] = None
    ideal: Annotated[bool, typer.Option("--ideal", help=IDEAL_HELP)] = False
    cache: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Where trials are kept.", show_default="pipenav/trials in ~/.cache"),
    ] = None


@dataclass(frozen=True)
class ResultOptions(OptionGroup):
    """Options of the result."""

    panel: ClassVar[str] = "Result"
    check: Annotated[bool, typer.Option("--check", help="Only read the map and say what is doubtful in it.")] = False
    out: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Where the survey goes.", show_default="runs/survey-NAME"),
    ] = None
    routes: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Write a route file for each way to a far end here.")
    ] = None
