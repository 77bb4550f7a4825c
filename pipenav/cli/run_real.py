"""`pipenav run-real`."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from pipenav.backends.backend import BackendOptions
    from pipenav.backends.real_robot import RealRobot
    from pipenav.deployment.session import Ending, MissionPlan
    from pipenav.deployment.trajectories import ArmPlacement
    from pipenav.pipes.corner import PipeCorner
    from pipenav.pipes.pipe import Turn

DRY_RUN_TICKS = 100
"""How long a dry run lasts where nobody says [ticks]: ten seconds."""

THESIS_FAULTS: list[dict[str, Any]] = [
    {"device": "scanner", "fault": "minimum", "probability": 0.3},
    {"device": "scanner", "fault": "noise", "value": 0.01},
]
"""The scanner of the thesis (5.4.1): readings of its smallest range where the pipe is open, and noise."""


def run_real(
    policy: Annotated[
        str | None, typer.Option(help="best.zip, or a shipped policy's name; default the shipped one for the robot.")
    ] = None,
    arm: Annotated[Path, typer.Option(help="The arm's description, from pipenav calibrate.")] = Path("arm.toml"),
    turn: Annotated[str, typer.Option(help="Side that the pipe turns to: left or right.")] = "left",
    target: Annotated[
        str | None, typer.Option(metavar="X,Y", help="Target in the robot's frame in mm, instead of looking for one.")
    ] = None,
    emulate: Annotated[bool, typer.Option("--emulate", help="An arm made of software, with --d and --angle.")] = False,
    d: Annotated[
        float | None, typer.Option("--d", metavar="MM", help="Pipe diameter, if known; of --emulate 130 by default.")
    ] = None,
    angle: Annotated[
        float | None, typer.Option(metavar="DEG", help="Interior pipe angle, if known; of --emulate 90 by default.")
    ] = None,
    robot: Annotated[
        str | None, typer.Option(help="The arm's robot: a policy for another is refused; default real-setup.")
    ] = None,
    faults: Annotated[
        str | None, typer.Option(help="Of --emulate: 'thesis' for the thesis's scanner, or a JSON file.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of --emulate: start pose, noise, faults.")] = 0,
    patience: Annotated[
        float, typer.Option(min=1, max=100, help="Of --emulate: factor on every time limit, for busy machines.")
    ] = 1.0,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the arm moves.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Read and compute, send nothing that moves.")] = False,
    ticks: Annotated[int | None, typer.Option(min=1, help="End after so many ticks of 0.1 s.")] = None,
    retreat: Annotated[
        bool, typer.Option("--retreat", help="Back out along the recorded path after a failure.")
    ] = False,
    hold_on_stop: Annotated[
        bool, typer.Option("--hold-on-stop", help="After a stop hold the arm until a key is pressed.")
    ] = False,
    allow_slow_bus: Annotated[bool, typer.Option("--allow-slow-bus", help="Accept a slow adapter.")] = False,
    stop_file: Annotated[Path | None, typer.Option(help="Emergency stop when this file appears.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the run; default runs/real-N.")] = None,
) -> None:
    """Drive the arm by a policy: locate a target, reach it, back out; safe to stop at any moment.

    Without hardware: pipenav run-real --emulate --d 130 --angle 90

    With the thesis's bad scanner: pipenav run-real --emulate --faults thesis

    The arm: pipenav run-real --policy best.zip --arm arm.toml --turn left

    Look before you move: pipenav run-real --policy best.zip --dry-run
    """
    from pipenav.backends.real_robot import load_real_robot
    from pipenav.backends.registry import check_options, open_backend
    from pipenav.deployment.session import PASSED, MissionPlan, execute, free_folder, policy_for
    from pipenav.deployment.trajectories import ArmPlacement

    if patience > 1 and not emulate:
        raise PipenavError("--patience would let a real arm run on when it must stop: it is for --emulate alone.")
    loaded = policy_for(policy, robot)
    pipe = _pipe(d, angle, turn, emulate)
    goal, side = _target(target), _turn(turn)
    fault_list = _faults(faults, emulate)
    kind = load_real_robot()
    folder = free_folder(out)
    most = ticks or (DRY_RUN_TICKS if dry_run else None)
    plan = MissionPlan(loaded, side, goal, retreat, folder, stop_file or folder / "STOP", most)
    console = Console()
    with contextlib.ExitStack() as opened:
        opened.callback(_drop_if_empty, folder)
        extra = {"listen_only": dry_run, "allow_slow_bus": allow_slow_bus, "patience": patience}
        place: ArmPlacement | None = None
        options: BackendOptions
        if emulate:
            assert pipe is not None
            emulated = opened.enter_context(kind.emulate(loaded.header.robot, pipe, folder, seed, fault_list))
            options, place = emulated.options.model_copy(update=extra), ArmPlacement(pipe, emulated.base)
        else:
            options = check_options("hardware", kind, {"arm": str(arm), **extra})
        _check(console, kind, options)
        machine = open_backend("hardware", loaded.header.robot, 1, options)
        assert isinstance(machine, kind)
        opened.callback(machine.close)
        _announce(console, machine, plan, dry_run)
        if not (yes or dry_run or emulate) and not typer.confirm("Move the arm?"):
            raise PipenavError("not started: nothing has moved.")
        ending = _with_view(console, machine, plan, hold_on_stop, execute)
    _tell(console, plan, ending, pipe, place)
    if ending.stopped is not None:
        raise _exit_of(ending)
    if ending.outcome != PASSED and not (most and ending.outcome == "ended"):
        raise PipenavError(f"the run ended without success: {ending.outcome}; see {folder}.")


def _drop_if_empty(folder: Path) -> None:
    """A run that did not begin leaves no folder behind."""
    with contextlib.suppress(OSError):
        folder.rmdir()


def _pipe(d: float | None, angle: float | None, turn: str, emulate: bool) -> PipeCorner | None:
    from pipenav.pipes.corner import PipeCorner

    if emulate:
        return PipeCorner.of(d or 130.0, angle or 90.0, turn)
    if d is None and angle is None:
        return None
    if d is None or angle is None:
        raise PipenavError("a pipe is known by its diameter and its angle: give --d and --angle, or neither.")
    return PipeCorner.of(d, angle, turn)


def _turn(text: str) -> Turn:
    if text not in ("left", "right"):
        raise PipenavError(f"turn {text!r} is neither left nor right: give the side that the pipe turns to.")
    return "left" if text == "left" else "right"


def _target(text: str | None) -> Any:
    import numpy as np

    from pipenav.units import mm_to_m

    if text is None:
        return None
    try:
        x, y = (mm_to_m(float(part)) for part in text.split(","))
    except ValueError:
        raise PipenavError(f"target {text!r} is not X,Y: give two numbers in mm, for example 420,80.") from None
    return np.array([x, y])


def _faults(text: str | None, emulate: bool) -> list[dict[str, Any]]:
    if text is None:
        return []
    if not emulate:
        raise PipenavError("--faults are those of an emulated arm: give --emulate too.")
    if text == "thesis":
        return THESIS_FAULTS
    try:
        loaded = json.loads(Path(text).read_text(encoding="utf-8"))
    except OSError as error:
        raise PipenavError(f"cannot read faults {text}: {error.strerror}; choose thesis or a JSON file.") from error
    except ValueError as error:
        raise PipenavError(f"{text} is not valid JSON: {error}.") from error
    if not isinstance(loaded, list):
        raise PipenavError(f"{text} is no list of faults: see docs/hardware.md, Faults.")
    return loaded


def _check(console: Console, kind: type[RealRobot], options: BackendOptions) -> None:
    from pipenav.cli.hw_check import show_findings

    problems = show_findings(console, kind.check(options))
    if problems:
        raise PipenavError(f"the arm has {problems} problem(s), see above: nothing has moved.")


def _announce(console: Console, machine: RealRobot, plan: MissionPlan, dry_run: bool) -> None:
    where = "a target that it looks for" if plan.target is None else "the given target"
    what = "would move" if dry_run else "is going to move"
    console.print(
        f"The arm {what}: {where} around a {plan.turn} turn, policy {plan.policy.path}, then back out. "
        f"Keep clear of it. Space, Ctrl-C, SIGUSR1 or the file {plan.stop_file} stop it; the power switch always does.",
        highlight=False,
    )
    for warning in machine.warnings:
        console.print(f"warning: {warning}", style="yellow", highlight=False)


def _with_view(console: Console, machine: RealRobot, plan: MissionPlan, hold_on_stop: bool, execute: Any) -> Ending:
    from pipenav.cli.run_real_view import MissionView

    with MissionView(console, plan.policy.header.robot) as view:
        ending: Ending = execute(machine, plan, view, view.released if hold_on_stop else None)
    return ending


def _tell(
    console: Console, plan: MissionPlan, ending: Ending, pipe: PipeCorner | None, place: ArmPlacement | None
) -> None:
    """The summary, the picture, and the motions as trajectories."""
    from pipenav.deployment.session import TELEMETRY, located_place, pace, write_motions
    from pipenav.deployment.telemetry import read_telemetry

    if not ending.last_ticks:
        return
    ticks = read_telemetry(plan.folder / TELEMETRY).ticks
    kept = pace(ticks)
    parts = ", ".join(f"{name} {seconds * 1e3:.1f}" for name, seconds in kept.parts.items())
    if ending.stopped is not None:
        _show_last(console, ending.last_ticks)
    console.print(
        f"{ending.outcome}: {kept.ticks} ticks at {kept.rate:.2f} Hz of 10, worst tick {kept.worst * 1e3:.1f} ms, "
        f"{kept.late} late, {kept.clamped} limited; mean ms: {parts}",
        highlight=False,
    )
    if place is None and pipe is not None:
        place = located_place(plan, ticks, pipe)
    written = [path.name for path in write_motions(plan, ticks, ending.outcome, place)]
    console.print(f"run folder {plan.folder}: {', '.join([TELEMETRY, *written])}", highlight=False)


def _show_last(console: Console, ticks: list[dict[str, Any]]) -> None:
    """The last ticks before a stop, one line each."""
    console.print(f"the last {len(ticks)} ticks: tick, stage, positions, sent, ms taken", highlight=False)
    for tick in ticks:
        numbers = [" ".join(f"{value:+.3f}" for value in tick.get(key) or []) for key in ("q", "sent")]
        taken = tick["raw"]["seconds"].get("taken")
        shown = "" if taken is None else f"{1e3 * taken:.1f}"
        stage = tick.get("stage", tick.get("stopped", ""))
        console.print(f"{tick['tick']:5d} {stage:8} {numbers[0]} | {numbers[1]} | {shown}", highlight=False)


def _exit_of(ending: Ending) -> Exception:
    from pipenav.deployment.loop import Interrupted

    stopped = ending.stopped
    assert stopped is not None
    if isinstance(stopped, Interrupted):
        typer.echo(f"pipenav: {stopped}", err=True)
        return typer.Exit(128 + stopped.number)
    return stopped
