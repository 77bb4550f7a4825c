"""`pipenav view`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, cast

import typer

from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from rich.console import Console

    from pipenav.locating.locator import Variant
    from pipenav.motions.trajectory import Trajectory
    from pipenav.pipes.pipe import Pipe
    from pipenav.recording.film import Progress
    from pipenav.recording.record import RecordingSettings

    Record = Callable[[Pipe, int, RecordingSettings], Trajectory]
    Parse = Callable[[Sequence[str]], Sequence[Pipe]]

TABLE = ".csv"
DEFAULT_PIPE = "d=90,angle=60"


def view(
    policy: Annotated[
        str | None,
        typer.Option(help="best.zip, a shipped policy's name, or baseline: and a name as for `pipenav eval`."),
    ] = None,
    behaviour: Annotated[
        Literal["locate:map", "locate:thesis"] | None,
        typer.Option(help="Draw how the robot finds a target itself, instead of a policy; see `locate-target`."),
    ] = None,
    trajectory: Annotated[
        list[Path] | None, typer.Option(help="Draw this recorded trajectory instead; repeatable: one after another.")
    ] = None,
    pipes: Annotated[
        list[str] | None,
        typer.Option(help=f"Pipe set, runs-level:3, FILE.toml or d=90,angle=60; repeatable. Default: {DEFAULT_PIPE}."),
    ] = None,
    backend: Annotated[str, typer.Option(help="Simulator backend; see `pipenav backends`.")] = "mujoco",
    robot: Annotated[
        str | None,
        typer.Option(help="Robot of a behaviour (basic) or baseline, or of a trajectory whose robot is not shipped."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of start and target, as in `pipenav eval`.")] = 0,
    episode: Annotated[
        int, typer.Option(min=0, help="Which of the episodes that `pipenav eval` runs in each pipe, from 0.")
    ] = 0,
    option: Annotated[list[str] | None, typer.Option(help="Backend setting, key=value; repeatable.")] = None,
    out: Annotated[
        list[Path] | None,
        typer.Option(help="Picture .png (a strip), film .gif or .mp4, or trajectory .csv; repeatable."),
    ] = None,
    live: Annotated[bool, typer.Option("--live", help="Open the simulator's own viewer and run in real time.")] = False,
) -> None:
    """Draw what a policy, a behaviour or a trajectory file does, from above: links, beams, target, contact forces.

    Examples:

        pipenav view --policy arm --pipes d=90,angle=60

        pipenav view --policy arm --pipes d=90,angle=60,turn=right --episode 7 --out film.mp4 --out front.csv

        pipenav view --trajectory front.csv --trajectory rear.csv --out passage.gif

        pipenav view --behaviour locate:map --robot high-fidelity --pipes d=70,angle=120

        pipenav view --policy pirate --pipes runs-level:3 --out run.gif

        pipenav view --policy pirate --pipes runs-rolled:3 --out roll.png

        pipenav view --policy baseline:centreline --live
    """
    from rich.console import Console

    if [policy is None, behaviour is None, not trajectory].count(False) != 1:
        raise PipenavError(
            "nothing to draw, or several things at once: give one of --policy, --behaviour and --trajectory."
        )
    paths = _checked_outputs(out, live, trajectory, pipes)
    console = Console()
    with _simulator(backend, option or [], live) as simulator:
        if trajectory:
            shown = _read(trajectory, robot, simulator if live else None)
        else:
            parse, record = _policy(policy, robot, seed) if policy else _locating(behaviour or "", robot, seed)
            chosen = _few(parse(pipes or [DEFAULT_PIPE]))
            if policy and not all(pipe.planar for pipe in chosen):
                _view_in_space(policy, robot, chosen, seed, episode, simulator, paths, console)
                return
            shown = [record(pipe, episode, simulator) for pipe in chosen]
        for one in shown:
            console.print(_sentence(one), highlight=False)
    for path in paths or ([] if live else [Path(f"view-{shown[0].header.pipe.name}.png")]):
        _write(path, shown, console)
        console.print(f"written: {path}", highlight=False, soft_wrap=True)


def _checked_outputs(
    out: list[Path] | None, live: bool, trajectory: list[Path] | None, pipes: list[str] | None
) -> list[Path]:
    """The files to write, each of a kind that can be written, before any work is done for them."""
    from pipenav.recording.film import SUFFIXES, check_suffix

    for path in out or []:
        if path.suffix.lower() != TABLE:
            check_suffix(path, [*SUFFIXES, TABLE])
        elif trajectory:
            raise PipenavError(
                f"{path}: a trajectory is recorded from a --policy or --behaviour; --trajectory only draws one."
            )
        if not path.parent.is_dir():
            raise PipenavError(f"there is no folder {path.parent} for {path.name}: make it first.")
    if trajectory and pipes:
        raise PipenavError("--pipes goes with --policy and --behaviour: a trajectory brings its own pipe.")
    if live and trajectory and out:
        raise PipenavError("--live shows a trajectory and writes nothing: give it without --out, or --out without it.")
    return out or []


@contextmanager
def _simulator(backend: str, options: list[str], live: bool) -> Iterator[RecordingSettings]:
    from pipenav.backends.registry import check_options
    from pipenav.backends.simulators import load_simulator
    from pipenav.cli.options import parse_options
    from pipenav.recording.live import live_window
    from pipenav.recording.record import RecordingSettings

    parsed = parse_options(options)
    check_options(backend, load_simulator(backend), parsed)
    if not live:
        yield RecordingSettings(backend, parsed)
        return
    with live_window() as window:
        yield RecordingSettings(backend, parsed, window)


def _few(pipes: Sequence[Pipe]) -> Sequence[Pipe]:
    from pipenav.recording.film import MAX_ROWS

    if len(pipes) > MAX_ROWS:
        raise PipenavError(f"{len(pipes)} pipes are too many to look at: name at most {MAX_ROWS}.")
    return pipes


def _policy(name: str, robot: str | None, seed: int) -> tuple[Parse, Record]:
    from pipenav.policies.named import open_controller
    from pipenav.recording.record import record_task
    from pipenav.tasks.registry import task_of

    controller = open_controller(name, robot, seed)
    return task_of(controller.task).parse_pipes, lambda pipe, episode, simulator: record_task(
        controller, name, pipe, seed, episode, simulator
    )


def _view_in_space(
    policy: str,
    robot: str | None,
    runs: Sequence[Pipe],
    seed: int,
    episode: int,
    simulator: RecordingSettings,
    paths: list[Path],
    console: Console,
) -> None:
    """Draw one run that leaves the plane."""
    from pipenav.pipes.route import as_route
    from pipenav.policies.named import open_controller
    from pipenav.recording.film import SUFFIXES, check_suffix
    from pipenav.recording.record_rolling import record_in_space
    from pipenav.recording.rolling_film import draw_in_space

    (run, *others) = runs
    if others:
        raise PipenavError("a picture in space shows one run: name one, for example runs-rolled:3.")
    outputs = paths or [Path(f"view-{run.name}.png")]
    for path in outputs:
        check_suffix(path, SUFFIXES)
    recording = record_in_space(open_controller(policy, robot, seed), policy, as_route(run), seed, episode, simulator)
    said = f"{run.label}, traverse: {recording.outcome} after {recording.time[-1]:.1f} s"
    console.print(f"{said}, largest contact force {recording.contact_force.max():.1f} N", highlight=False)
    for path in outputs:
        with _drawing_bar(path, console) as progress:
            draw_in_space(path, recording, progress)
        console.print(f"written: {path}", highlight=False, soft_wrap=True)


def _locating(behaviour: str, robot: str | None, seed: int) -> tuple[Parse, Record]:
    from pipenav.pipes.corner_sets import parse_corners
    from pipenav.recording.record import record_locate
    from pipenav.robots.robot import load_robot

    spec, variant = load_robot(robot or "basic"), cast("Variant", behaviour.removeprefix("locate:"))
    return (
        parse_corners,
        lambda pipe, episode, simulator: (
            record_locate(spec, variant, pipe.require_corner(), seed, episode, simulator).trajectory
        ),
    )


def _read(paths: list[Path], robot: str | None, simulator: RecordingSettings | None) -> list[Trajectory]:
    from pipenav.motions.trajectory_file import read_trajectory
    from pipenav.recording.live import play
    from pipenav.robots.robot import load_robot

    spec = None if robot is None else load_robot(robot)
    read = [read_trajectory(path, spec) for path in paths]
    if simulator is not None:
        play(read, simulator)
    return read


def _sentence(trajectory: Trajectory) -> str:
    """What happened, in one line."""
    header, seconds = trajectory.header, trajectory.time[-1]
    force = trajectory.contact_force
    touched = "" if force is None else f", largest contact force {force.max():.1f} N"
    return f"{header.pipe.label}, {header.stage}: {header.outcome or 'not run'} after {seconds:.1f} s{touched}"


def _write(path: Path, trajectories: list[Trajectory], console: Console) -> None:
    from pipenav.motions.trajectory_file import write_trajectory
    from pipenav.recording.film import write_film

    if path.suffix.lower() == TABLE:
        if len(trajectories) > 1:
            raise PipenavError(f"{path}: a trajectory file holds one motion: name one pipe.")
        write_trajectory(path, trajectories[0])
        return
    with _drawing_bar(path, console) as progress:
        write_film(path, trajectories, progress)


@contextmanager
def _drawing_bar(path: Path, console: Console) -> Iterator[Progress]:
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    shown = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f}%"))
    columns = (*shown, TextColumn("left"), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(f"drawing {path.name}")
        yield lambda done, total: bar.update(task, completed=done, total=total)
