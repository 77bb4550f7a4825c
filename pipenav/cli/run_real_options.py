"""The options of `pipenav run-real`, in the groups that its help shows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from pipenav.cli.option_groups import OptionGroup


@dataclass(frozen=True)
class ArmOptions(OptionGroup):
    """The arm that moves, and whether it may."""

    panel: ClassVar[str] = "The arm"
    arm: Annotated[
        Path | None, typer.Option(help="The arm's description, from pipenav calibrate.", show_default="arm.toml")
    ] = None
    robot: Annotated[
        str | None, typer.Option(help="The arm's robot: a policy for another is refused; default real-setup.")
    ] = None
    allow_slow_bus: Annotated[bool, typer.Option("--allow-slow-bus", help="Accept a slow adapter.")] = False
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the arm moves.")] = False
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Read and compute, send nothing that moves.")] = False


@dataclass(frozen=True)
class PipeOptions(OptionGroup):
    """The pipe, as far as it is known, and the target in it."""

    panel: ClassVar[str] = "The pipe"
    turn: Annotated[str, typer.Option(help="Side that the pipe turns to: left or right.")] = "left"
    tee: Annotated[bool, typer.Option("--tee", help="The pipe ahead is a tee or a cross: take its exit at --turn.")] = (
        False
    )
    straight_on: Annotated[
        bool, typer.Option("--straight-on", help="Go straight on in the tee, past its branch at --turn.")
    ] = False
    bend_radius: Annotated[
        str,
        typer.Option(
            metavar="MM|1.5D",
            help="The pipe ahead is a bend of this radius. The arm is told that it is one, and finds out the rest.",
            show_default="0, a sharp corner",
        ),
    ] = "0"
    target: Annotated[
        str | None, typer.Option(metavar="X,Y", help="Target in the robot's frame in mm, instead of looking for one.")
    ] = None
    d: Annotated[
        float | None, typer.Option("--d", metavar="MM", help="Pipe diameter, if known; with --emulate 130 by default.")
    ] = None
    angle: Annotated[
        float | None, typer.Option(metavar="DEG", help="Interior pipe angle, if known; with --emulate 90 by default.")
    ] = None


@dataclass(frozen=True)
class EmulationOptions(OptionGroup):
    """An arm made of software in place of the real one."""

    panel: ClassVar[str] = "Emulation"
    emulate: Annotated[
        bool, typer.Option("--emulate", help="Drive an arm made of software, in a pipe of --d and --angle.")
    ] = False
    faults: Annotated[
        str | None, typer.Option(help="What goes wrong: 'thesis' for the thesis's scanner, or a JSON file.")
    ] = None
    seed: Annotated[
        int | None, typer.Option(min=0, help="Seed of the start pose, of noise and of faults.", show_default="0")
    ] = None
    patience: Annotated[float, typer.Option(min=1, max=100, help="Factor on all time limits, for busy machines.")] = 1.0


@dataclass(frozen=True)
class StoppingOptions(OptionGroup):
    """The end of a mission, and what follows a failure or a stop."""

    panel: ClassVar[str] = "Stopping"
    ticks: Annotated[int | None, typer.Option(min=1, help="End after so many ticks of 0.1 s.")] = None
    retreat: Annotated[bool, typer.Option("--retreat", help="Back out along the recorded path after a failure.")] = (
        False
    )
    hold_on_stop: Annotated[
        bool, typer.Option("--hold-on-stop", help="After a stop hold the arm until a key is pressed.")
    ] = False
    stop_file: Annotated[Path | None, typer.Option(help="Emergency stop when this file appears.")] = None
