"""The options of `pipenav drive`, in the groups that its help shows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import typer

from pipenav.cli.option_groups import OptionGroup


@dataclass(frozen=True)
class DriverOptions(OptionGroup):
    """Who drives, and by what."""

    panel: ClassVar[str] = "Who drives"
    policy: Annotated[
        str | None,
        typer.Option(
            help="Shared control: this policy or baseline drives, and the operator takes over while a key is held."
        ),
    ] = None
    operator: Annotated[
        Literal["person", "scripted", "none"],
        typer.Option(help="A person; a fixed, noisy script; or none: the policy alone."),
    ] = "person"
    input: Annotated[
        Literal["keyboard", "gamepad", "midi"],
        typer.Option("--input", help="Device of a person; gamepad and midi need pip install 'pipenav[drive]'."),
    ] = "keyboard"
    device: Annotated[
        str | None, typer.Option(help="Which gamepad or MIDI port, by name, or a raw MIDI device's path.")
    ] = None
    mapping: Annotated[Path | None, typer.Option(metavar="FILE.toml", help="Keys, buttons and faders of your own.")] = (
        None
    )


@dataclass(frozen=True)
class DrivePipeOptions(OptionGroup):
    """The robot, and the numbered pipes."""

    panel: ClassVar[str] = "What and where"
    robot: Annotated[str | None, typer.Option(help="The robot; default that of the policy, else pirate.")] = None
    pipes: Annotated[
        list[str] | None,
        typer.Option(metavar="PIPE", help="Pipes, as for pipenav eval; repeatable.", show_default="d=90,angle=90"),
    ] = None
    episodes: Annotated[int, typer.Option(min=1, max=1000, help="Episodes in each pipe, numbered by the seed.")] = 1
    seed: Annotated[int, typer.Option(min=0, help="Seed of starts and targets: the same for every driver.")] = 0
    disturb: Annotated[
        str | None, typer.Option(help="Disturb the robots: a name of pipenav list disturbances, or FILE.toml.")
    ] = None


@dataclass(frozen=True)
class ArmDriveOptions(OptionGroup):
    """The real arm, or an emulated one, in place of a simulator."""

    panel: ClassVar[str] = "The arm"
    emulate: Annotated[bool, typer.Option("--emulate", help="Drive an arm made of software over its own bus.")] = False
    arm: Annotated[Path | None, typer.Option(metavar="arm.toml", help="Drive the real arm of this description.")] = None
    allow_slow_bus: Annotated[bool, typer.Option("--allow-slow-bus", help="Accept a slow adapter.")] = False
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the arm moves.")] = False
    patience: Annotated[
        float, typer.Option(min=1, max=100, help="Factor on all time limits of an emulated arm, for busy machines.")
    ] = 1.0
    ticks: Annotated[int | None, typer.Option(min=1, help="End after so many ticks of 0.1 s.")] = None


@dataclass(frozen=True)
class DriveOptions(OptionGroup):
    """The simulator, and what is kept and shown."""

    panel: ClassVar[str] = "How"
    backend: Annotated[str, typer.Option(help="Simulator backend; see `pipenav backends`.")] = "mujoco"
    option: Annotated[list[str] | None, typer.Option("--option", help="Backend setting, key=value; repeatable.")] = None
    watch: Annotated[bool, typer.Option("--watch", help="Show a script or a policy as it drives, one at a time.")] = (
        False
    )
    window: Annotated[
        bool, typer.Option("--window", help="Open the simulator's window too, where there is a display.")
    ] = False
    record: Annotated[bool, typer.Option("--record/--no-record", help="Keep the telemetry of every control step.")] = (
        True
    )
