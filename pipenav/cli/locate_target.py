"""`pipenav locate-target`."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from pipenav.cli.options import BackendOption, SettingsOption
from pipenav.cli.terminal import progress_console, say, show
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from rich.table import Table

    from pipenav.pipes.corner import PipeCorner
    from pipenav.recording.record import Located

DIAMETER_HELP = "Inner diameter of the pipe in mm."
ANGLE_HELP = "Interior angle between its legs in deg; small is sharp."
TURN_HELP = "Side that it turns to: left, the default, or right."
VARIANT_HELP = "map: the beams' ends are fitted to a corner; thesis: the method exactly as printed, eq 3.16 to 3.19."
PIPES_HELP = "Instead of --d and --angle: shipped set, FILE.toml or d=90,angle=60[,turn=right]; repeatable."
OUT_HELP = "Folder for each pipe's trajectory (.csv) and picture of what the laser saw (.png)."
PIPE, BEHAVIOUR, OUTPUT = "Which pipe", "Robot and method", "Output"


DiameterOption = Annotated[float | None, typer.Option("--d", metavar="MM", help=DIAMETER_HELP, rich_help_panel=PIPE)]
AngleOption = Annotated[float | None, typer.Option(metavar="DEG", help=ANGLE_HELP, rich_help_panel=PIPE)]
TurnOption = Annotated[str | None, typer.Option(metavar="SIDE", help=TURN_HELP, rich_help_panel=PIPE)]
PipesOption = Annotated[list[str] | None, typer.Option(help=PIPES_HELP, rich_help_panel=PIPE)]
RobotOption = Annotated[str, typer.Option(help="Robot; see `pipenav robots`.", rich_help_panel=BEHAVIOUR)]
# The names of pipenav.locating.locator.Variant, whose import would slow down --help.
VariantOption = Annotated[Literal["map", "thesis"], typer.Option(help=VARIANT_HELP, rich_help_panel=BEHAVIOUR)]
SeedOption = Annotated[
    int, typer.Option(min=0, help="Seed of the start, as in `pipenav eval`.", rich_help_panel=BEHAVIOUR)
]
OutOption = Annotated[Path | None, typer.Option(metavar="FOLDER", help=OUT_HELP, rich_help_panel=OUTPUT)]


def locate_target(
    d: DiameterOption = None,
    angle: AngleOption = None,
    turn: TurnOption = None,
    pipes: PipesOption = None,
    robot: RobotOption = "basic",
    variant: VariantOption = "map",
    seed: SeedOption = 0,
    backend: BackendOption = "mujoco",
    option: SettingsOption = None,
    out: OutOption = None,
) -> None:
    """Let the robot find a target (approach I), knowing only whether the corner turns left or right.

    Exit code 1 if no target was found, or one outside the second leg; in a long bend it may lie as far in as the arm
    can reach.

    `pipenav eval --stage locate` measures it over many starts.

    Examples:

        pipenav locate-target --d 90 --angle 60
        pipenav locate-target --d 110 --angle 75 --turn right --robot high-fidelity --out located
        pipenav locate-target --pipes thesis --robot real-setup
        pipenav locate-target --d 120 --angle 90 --variant thesis
    """
    from rich.progress import track

    from pipenav.cli.options import recording_settings
    from pipenav.recording.record import record_locate
    from pipenav.robots.robot import load_robot
    from pipenav.storage.lock import one_writer
    from pipenav.tasks.reach.episode import check_fits

    wanted = _pipes(d, angle, turn, pipes or [])
    spec = load_robot(robot)
    simulator = recording_settings(backend, option or [])
    check_fits(spec, wanted)
    console = progress_console()
    found = []
    with nullcontext() if out is None else one_writer(out):
        for pipe in track(wanted, "locating", console=console, transient=True, disable=not console.is_terminal):
            found.append(record_locate(spec, variant, pipe, seed, 0, simulator))
            if out is not None:
                _write(out, found[-1])
    show(_facts(found[0]) if len(found) == 1 else _table(found))
    if out is not None:
        say(f"written: {out}, a trajectory and a picture of each pipe")
    if not all(located.trajectory.succeeded for located in found):
        raise typer.Exit(1)


def _pipes(d: float | None, angle: float | None, turn: str | None, sets: list[str]) -> list[PipeCorner]:
    from pipenav.pipes.corner import PipeCorner
    from pipenav.pipes.corner_sets import parse_corners

    if sets and (d, angle, turn) != (None, None, None):
        raise PipenavError("one pipe or a set, not both: give --d and --angle (and --turn), or --pipes.")
    if sets:
        return parse_corners(sets)
    if missing := [name for name, value in (("--d", d), ("--angle", angle)) if value is None]:
        give = "give --d and --angle, for example --d 90 --angle 60, or --pipes"
        raise PipenavError(f"no pipe is named, without {' and '.join(missing)}: {give}.")
    assert d is not None and angle is not None
    return [PipeCorner.of(d, angle, turn or "left")]


def _write(folder: Path, located: Located) -> None:
    from pipenav.drawing.style import png
    from pipenav.motions.trajectory_file import write_trajectory
    from pipenav.recording.locate_figure import locate_figure
    from pipenav.storage.atomic_files import atomic_write

    name = f"locate-{located.trajectory.header.pipe.name}"
    write_trajectory(folder / f"{name}.csv", located.trajectory)
    atomic_write(folder / f"{name}.png", png(locate_figure(located)))


HEADINGS = ("target x [mm]", "target y [mm]", "beam", "found at step", "well placed", "peak force [N]", "outcome")


def _cells(located: Located) -> list[str]:
    """Results in one pipe, a cell for each of `HEADINGS`."""
    import numpy as np

    from pipenav.evaluation.locate_stage import well_placed
    from pipenav.units import m_to_mm

    trajectory = located.trajectory
    header, beams = trajectory.header, trajectory.robot.laser.beams
    force = 0.0 if trajectory.contact_force is None else float(trajectory.contact_force.max())
    x = y = beam = step = inside = "-"
    if header.goal_m is not None and located.beam is not None:
        x, y = (f"{m_to_mm(value):.1f}" for value in header.goal_m)
        beam, step = f"{located.beam + 1} of {beams}", str(located.found)
        pipe, target = header.pipe.require_corner(), np.array(header.goal_m)
        inside = "yes" if well_placed(trajectory.robot, pipe, header.base_m, target) else "no"
    return [x, y, beam, step, inside, f"{force:.1f}", header.outcome or "-"]


NOTES = (
    "mm, in the pipe's frame: from the corner, the first leg along -x",
    "mm, to the left",
    "number, from the right, of the beam on the target or nearest to it",
    "control steps before it was known, 0.1 s each",
    "",
    "N, of the pipe on any one link",
    "",
)


def _facts(located: Located) -> Table:
    from rich.table import Table
    from rich.text import Text

    trajectory = located.trajectory
    header = trajectory.header
    facts = Table.grid(padding=(0, 2))
    facts.title = f"{header.pipe.label}: {header.robot}, {header.controller}, {header.backend}"
    facts.title_justify, facts.title_style = "left", "bold"
    names = [heading.split(" [")[0] for heading in HEADINGS]
    notes = [*NOTES[:-1], f"after {trajectory.time[-1]:.1f} s"]
    for name, value, note in zip(names, _cells(located), notes, strict=True):
        facts.add_row("", name, Text(value, style="bold", justify="right"), note)
    return facts


def _table(found: list[Located]) -> Table:
    from rich.table import Table
    from rich.text import Text

    header = found[0].trajectory.header
    table = Table("pipe", box=None, pad_edge=False, title_justify="left", title_style="bold")
    table.title = f"{header.robot}, {header.controller}, {header.backend}"
    for heading in HEADINGS:
        table.add_column(Text(heading), justify="right")  # a plain string's [mm] would be taken for markup
    for located in found:
        style = None if located.trajectory.succeeded else "red"
        table.add_row(located.trajectory.header.pipe.label, *_cells(located), style=style)
    good = sum(located.trajectory.succeeded for located in found)
    table.caption, table.caption_justify = f"found well placed: {good} of {len(found)} pipes", "left"
    return table
