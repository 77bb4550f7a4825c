"""The end of `pipenav run-real`: the summary of the mission, and the exit code."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import typer
from rich.console import Console

from pipenav.cli.terminal import say
from pipenav.deployment.emulation import Emulation
from pipenav.deployment.guard import StoppedBySignal
from pipenav.deployment.html_report import mission_page
from pipenav.deployment.plan import PAGE, TELEMETRY, MissionPlan
from pipenav.deployment.session import PASSED, Ending
from pipenav.deployment.summary import located_placement, pace, write_motions
from pipenav.deployment.telemetry import read_telemetry
from pipenav.deployment.trajectories import ArmPlacement
from pipenav.errors import PipenavError
from pipenav.pipes.corner import PipeCorner
from pipenav.storage.atomic_files import atomic_write


def conclude(
    console: Console, plan: MissionPlan, ending: Ending, pipe: PipeCorner | None, emulation: Emulation | None
) -> None:
    """Show the summary of a mission, see `show_summary`, and end the command by the right exit code.

    Where the summary cannot be shown or written, what stopped the arm is said all the same.

    Raises:
        typer.Exit, Stopped, PipenavError: see `require_success`.
    """
    problem: BaseException | None = None
    try:
        show_summary(console, plan, ending, pipe, emulation)
    except (PipenavError, OSError, SystemExit) as raised:  # rich leaves by SystemExit where nobody reads its output
        problem = raised
    require_success(plan, ending)
    if problem is not None:
        raise problem


def show_summary(
    console: Console, plan: MissionPlan, ending: Ending, pipe: PipeCorner | None, emulation: Emulation | None
) -> None:
    """Print the summary of a mission, and write its picture and its motions; nothing where no tick was recorded.

    Args:
        console: the terminal.
        plan: the mission's plan.
        ending: how the mission ended.
        pipe: the pipe around the arm; None where it is not known.
        emulation: the emulated arm; None for the real one.
    """
    if not ending.last_ticks:
        return
    if ending.stopped is not None:
        _show_last(console, ending.last_ticks)
        if ending.stopped.cause == "telemetry":
            return  # the disk takes nothing
    recording = read_telemetry(plan.folder / TELEMETRY)
    ticks = recording.ticks
    kept = pace(ticks)
    parts = ", ".join(f"{name} {seconds * 1e3:.1f}" for name, seconds in kept.parts.items())
    say(
        f"{ending.outcome}: {kept.ticks} ticks at {kept.rate:.2f} Hz of 10, worst tick {kept.worst * 1e3:.1f} ms, "
        f"{kept.late} late, {kept.clamped} limited; mean ms: {parts}",
        console=console,
    )
    placement = None if emulation is None else ArmPlacement(emulation.pipe, emulation.start.base)
    if placement is None and pipe is not None:
        placement = located_placement(plan, ticks, pipe)
    written = [path.name for path in write_motions(plan, ticks, ending.outcome, placement)]
    atomic_write(plan.folder / PAGE, mission_page(recording, plan.policy.header.robot, plan.folder, placement))
    say(f"mission folder {plan.folder}: {', '.join([TELEMETRY, *written, PAGE])}", console=console)


def require_success(plan: MissionPlan, ending: Ending) -> None:
    """End the command by the right exit code.

    Raises:
        typer.Exit: a signal stopped the arm.
        Stopped: something else stopped it.
        PipenavError: the mission ended without success, and not because all its ticks were done.
    """
    stopped = ending.stopped
    if isinstance(stopped, StoppedBySignal):
        typer.echo(f"pipenav: {stopped}", err=True)
        raise typer.Exit(128 + stopped.number)
    if stopped is not None:
        raise stopped
    if ending.outcome != PASSED and not (plan.most_ticks and ending.outcome == "ended"):
        raise PipenavError(f"the mission ended without success: {ending.outcome}; see {plan.folder}.")


def _show_last(console: Console, ticks: Sequence[dict[str, Any]]) -> None:
    """Print the last ticks before a stop, one line each."""
    say(f"the last {len(ticks)} ticks: tick, stage, positions, sent, ms taken", console=console)
    for tick in ticks:
        numbers = [" ".join(f"{value:+.3f}" for value in tick.get(key) or []) for key in ("q", "sent")]
        taken = tick["raw"]["seconds"].get("taken")
        shown = "" if taken is None else f"{1e3 * taken:.1f}"
        stage = tick.get("stage", tick.get("stopped", ""))
        say(f"{tick['tick']:5d} {stage:8} {numbers[0]} | {numbers[1]} | {shown}", console=console)
