"""`pipenav certify`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from pipenav.cli.terminal import progress_console, refuse_ignored, say, show
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.table import Table

    from pipenav.certify.certificate import Certified
    from pipenav.pipes.corner import PipeCorner
    from pipenav.robots.robot import RobotSpec

WHAT, HOW, OUTPUT = "Which robot and pipes", "How", "Output"
ROBOT_HELP = "Robot; see `pipenav robots`."
PIPES_HELP = "Pipe set, FILE.toml or d=90,angle=60[,bend_radius=1.5D]; repeatable."
BORE_HELP = "plane: between boards; round: in a round tube, where a part of height h sees sqrt(d^2 - h^2)."
OVERLAP_HELP = "Overlap with the wall in mm that is allowed; a task allows 2."
EPISODES_HELP = "Certify this many of the episodes that `pipenav eval` runs in each pipe, and not the pipe."
RESOLUTION_HELP = "Width in deg of the smallest cells of headings."
NEEDED_HELP = "Also say the bore that would be needed, by trying others: takes some ten times as long."
OUT_HELP = "Folder for certificates (.json), motions (.csv) and pictures of their tightest poses (.png), or a frontier."
FRONTIER_HELP = "Compute the bore that the robot needs over the angle instead, as .json and .png in --out."
BENDS_HELP = "Bends of --frontier: mitre, or a radius in bores such as 1.5D."
CHECK_HELP = "Check a certificate from scratch instead; exit code 1 if it does not hold. --robot: if not shipped."

RobotOption = Annotated[str | None, typer.Option(help=ROBOT_HELP, rich_help_panel=WHAT)]
PipesOption = Annotated[list[str] | None, typer.Option(help=PIPES_HELP, rich_help_panel=WHAT)]
BoreOption = Annotated[Literal["plane", "round"], typer.Option(help=BORE_HELP, rich_help_panel=HOW)]
OverlapOption = Annotated[float, typer.Option(min=0, max=20, metavar="MM", help=OVERLAP_HELP, rich_help_panel=HOW)]
EpisodesOption = Annotated[int | None, typer.Option(min=1, help=EPISODES_HELP, rich_help_panel=WHAT)]
SeedOption = Annotated[int, typer.Option(min=0, help="Seed of the episodes.", rich_help_panel=WHAT)]
ResolutionOption = Annotated[
    float, typer.Option(min=0.05, max=15, metavar="DEG", help=RESOLUTION_HELP, rich_help_panel=HOW)
]
NeededOption = Annotated[bool, typer.Option("--needed", help=NEEDED_HELP, rich_help_panel=HOW)]
FrontierOption = Annotated[bool, typer.Option("--frontier", help=FRONTIER_HELP, rich_help_panel=WHAT)]
BendsOption = Annotated[str, typer.Option(metavar="BENDS", help=BENDS_HELP, rich_help_panel=WHAT)]
OutOption = Annotated[Path | None, typer.Option(metavar="FOLDER", help=OUT_HELP, rich_help_panel=OUTPUT)]
CheckOption = Annotated[Path | None, typer.Option(metavar="FILE", help=CHECK_HELP, rich_help_panel=OUTPUT)]

ROUTES = "a route has several corners, which are no single wedge: certify each corner alone"
"""Reason why nothing is said about a route, S-bends among them."""

TASK_OVERLAP = 0.002
"""Overlap that the tasks allow [m], for the second verdict on a pipe that is impossible without any."""


def certify(
    robot: RobotOption = None,
    pipes: PipesOption = None,
    bore: BoreOption = "plane",
    overlap_mm: OverlapOption = 0.0,
    episodes: EpisodesOption = None,
    seed: SeedOption = 0,
    resolution: ResolutionOption = 0.25,
    needed: NeededOption = False,
    out: OutOption = None,
    check: CheckOption = None,
    frontier: FrontierOption = False,
    bends: BendsOption = "mitre",
) -> None:
    """Decide by geometry alone whether a robot can pass a pipe: a proof, a motion that shows it, or undecided.

    The certificate is quasi-static: it knows no motors, friction or weight.

    Examples:

        pipenav certify --robot basic --pipes d=90,angle=60
        pipenav certify --robot pirate --pipes d=60,angle=60 --needed
        pipenav certify --robot real-setup --pipes d=70,angle=60 --bore round
        pipenav certify --robot basic --pipes d=62,angle=60 --episodes 10 --out certified
        pipenav certify --robot basic --frontier --bends 1.5D --out frontiers
        pipenav certify --check certified/basic-corner-d62-a60-left-plane-0.json
    """
    if check is not None:
        refuse_ignored({"--pipes": pipes, "--episodes": episodes, "--out": out}, "a certificate names its own pipe")
        _check(check, robot)
        return
    if robot is None or not (pipes or frontier):
        raise PipenavError("a robot and pipes are needed: give --robot and --pipes, --frontier, or --check FILE.")
    from pipenav.robots.robot import load_robot
    from pipenav.units import deg_to_rad, mm_to_m

    if frontier:
        refuse_ignored({"--pipes": pipes, "--episodes": episodes, "--needed": needed}, "a frontier has its own pipes")
        _frontier(load_robot(robot), bore, bends, deg_to_rad(resolution), out)
        return
    wanted = _Wanted(load_robot(robot), bore, mm_to_m(overlap_mm), episodes, seed, deg_to_rad(resolution))
    _certify(wanted, pipes or [], needed, out)


def _frontier(
    robot: RobotSpec, bore: Literal["plane", "round"], bends: str, resolution: float, out: Path | None
) -> None:
    """Compute a frontier, print it, and write it with its picture."""
    from rich.progress import track
    from rich.table import Table

    from pipenav.certify.frontier import ANGLES_DEG, Wanted, bend_radius_of, write_frontier
    from pipenav.certify.frontier_figure import frontier_figure
    from pipenav.drawing.style import png
    from pipenav.storage.atomic_files import atomic_write

    wanted, console = Wanted(robot, bore, bend_radius_of(bends), resolution), progress_console()
    every = track(wanted.points(), "angles", len(ANGLES_DEG), console=console, disable=not console.is_terminal)
    found = wanted.frontier(tuple(every))
    where = f"{'mitres' if bends == 'mitre' else f'bends of {bends}'}, {_BORES[bore]}"
    table = Table(box=None, pad_edge=False, title_justify="left", title_style="bold")
    table.title = f"{robot.name}: bore that is needed, {where}"
    for column in ("angle [deg]", "impossible up to [mm]", "passable from [mm]"):
        table.add_column(column, justify="right")
    for point in found.points:
        bores = ("-" if bore is None else f"{bore:.1f}" for bore in (point.impossible_mm, point.passable_mm))
        table.add_row(f"{point.angle_deg:g}", *bores)
    show(table)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        path = write_frontier(out, found)
        text = f"{where}: passable above the line, impossible below the band"
        atomic_write(path.with_suffix(".png"), png(frontier_figure([found], robot.name, text)))
        say(f"written: {path}, and its picture")


_BORES = {"plane": "between boards", "round": "round bore"}


def _certify(wanted: _Wanted, pipes: list[str], needed: bool, out: Path | None) -> None:
    """Certify the pipes, write what is wanted of it and print the table."""
    from contextlib import nullcontext

    from rich.progress import track

    from pipenav.pipes.route_sets import parse_pipes
    from pipenav.storage.lock import one_writer

    every_pipe, console, table = parse_pipes(pipes), progress_console(), _table(wanted)
    corners = [pipe.corner for pipe in every_pipe if pipe.corner is not None]
    total = len(corners) * (wanted.episodes or 1)
    with nullcontext() if out is None else one_writer(out):
        every = track(wanted.certified(corners), "certifying", total, console=console, disable=not console.is_terminal)
        for name, one in every:
            if out is not None:
                _write(out, name, one)
            style = {"passable": "green", "impossible": "red"}.get(one.verdict.kind)
            table.add_row(*wanted.cells(one, needed), style=style)
    for pipe in every_pipe:
        if pipe.corner is None:
            table.add_row(pipe.label, "undecided", "", ROUTES)
    show(table)
    if out is not None and corners:
        say(f"written: {out}, a certificate of each corner")


class _Wanted:
    """Robot, bore and episodes that are to be certified."""

    def __init__(
        self, robot: RobotSpec, bore: str, overlap: float, episodes: int | None, seed: int, resolution: float
    ) -> None:
        self.robot, self.bore, self.overlap = robot, bore, overlap
        self.episodes, self.seed, self.resolution = episodes, seed, resolution

    def certified(self, corners: list[PipeCorner]) -> Iterator[tuple[str, Certified]]:
        """Every pipe or episode with its verdict, and a name for its files."""
        from pipenav.certify.arm import Ends
        from pipenav.certify.certificate import Certified
        from pipenav.certify.model import Model
        from pipenav.certify.verdict import certify as verdict_of
        from pipenav.evaluation.episode_runner import random_start
        from pipenav.tasks.reach.config import ReachConfig
        from pipenav.tasks.reach.episode import check_fits
        from pipenav.tasks.registry import default_config

        check_fits(self.robot, corners)
        task = default_config(self.robot)
        start = None if self.episodes is None else random_start(self.robot, task, corners, self.episodes, self.seed)
        for number, pipe in enumerate(corners):
            model = Model(self.robot, pipe, self.bore, self.overlap)
            name = f"{self.robot.name}-{pipe.name}-{self.bore}"
            for episode in range(self.episodes or 1):
                ends = None
                if isinstance(task, ReachConfig):
                    ends = Ends.of_task(model, task)
                    if start is not None:
                        drawn = start(number * (self.episodes or 1) + episode)
                        ends = Ends.of_episode(model, task, drawn.q[0], float(drawn.base[0]), drawn.target[0])
                found = verdict_of(model, ends, self.resolution)
                yield (
                    name if start is None else f"{name}-{episode}",
                    Certified(model, found.ends or ends, self.resolution, found),
                )

    def cells(self, one: Certified, needed: bool) -> list[str]:
        """Row of the table."""
        from pipenav.certify.needed_bore import needed_bore
        from pipenav.certify.verdict import certify as verdict_of

        soft = ""
        if one.verdict.kind == "impossible" and one.model.overlap < TASK_OVERLAP:
            soft = verdict_of(one.model._replace(overlap=TASK_OVERLAP), one.ends, one.resolution).kind
        row = [one.model.pipe.label, one.verdict.kind, soft, one.verdict.reason]
        if needed:
            row.append(str(needed_bore(one.model, one.resolution)))
        return row


def _table(wanted: _Wanted) -> Table:
    from rich.table import Table
    from rich.text import Text

    from pipenav.units import m_to_mm

    table = Table(box=None, pad_edge=False, title_justify="left", title_style="bold")
    allowed = f", overlap up to {m_to_mm(wanted.overlap):g} mm" if wanted.overlap else ""
    table.title = f"{wanted.robot.name}, {'between boards' if wanted.bore == 'plane' else 'round bore'}{allowed}"
    for heading in ("pipe", "verdict", "with 2 mm of overlap", "reason", "needed bore [mm]"):
        table.add_column(Text(heading))
    table.caption, table.caption_justify = "geometry alone: no motors, friction or weight", "left"
    return table


def _write(folder: Path, name: str, one: Certified) -> None:
    from pipenav.certify.certificate import write_certificate
    from pipenav.certify.figure import impossible_figure, tightest_figure
    from pipenav.drawing.style import png
    from pipenav.storage.atomic_files import atomic_write

    write_certificate(folder, name, one)
    if one.verdict.motion is not None:
        atomic_write(folder / f"{name}.png", png(tightest_figure(one)))
    elif (figure := impossible_figure(one)) is not None:
        atomic_write(folder / f"{name}.png", png(figure))


def _check(path: Path, robot: str | None) -> None:
    from pipenav.certify.certificate import check_certificate, read_certificate
    from pipenav.robots.robot import load_robot

    spec = load_robot(robot or read_certificate(path).robot)
    certificate = check_certificate(path, spec)
    say(f"holds: {certificate.robot}, {certificate.pipe.label}: {certificate.verdict}, {certificate.reason}")
