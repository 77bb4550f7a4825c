"""`pipenav run-real`."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import IO, TYPE_CHECKING, Annotated, Any, cast

import typer
from rich.console import Console

from pipenav.cli.hw_check import problems, show_findings
from pipenav.cli.option_groups import takes_option_groups
from pipenav.cli.run_real_options import ArmOptions, EmulationOptions, PipeOptions, StoppingOptions
from pipenav.cli.terminal import refuse_ignored, say
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from pipenav.arrays import Floats
    from pipenav.backends.real_robot import RealRobot
    from pipenav.deployment.emulation import Emulation
    from pipenav.deployment.plan import MissionPlan
    from pipenav.deployment.session import Ending
    from pipenav.locating.locator import Exit
    from pipenav.pipes.corner import PipeCorner
    from pipenav.robots.robot import RobotSpec

ARM_FILE = Path("arm.toml")
"""Description of the arm where no other is named."""

DRY_RUN_TICKS = 100
"""Length of a dry run where no other is given [ticks]: ten seconds."""

LAST_WORDS = 1.0
"""Longest wait for the terminal to take what was shown [s]; torque is off then."""


@takes_option_groups
def run_real(
    arm_options: ArmOptions,
    pipe_options: PipeOptions,
    stopping: StoppingOptions,
    emulation_options: EmulationOptions,
    policy: Annotated[
        str | None, typer.Option(help="best.zip, or a shipped policy's name; default the shipped one for the robot.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Mission folder; default runs/real-N.")] = None,
) -> None:
    """Drive the arm with a policy: locate a target, reach it, back out; safe to stop at any moment.

    Without hardware: pipenav run-real --emulate --d 130 --angle 90

    With the thesis's bad scanner: pipenav run-real --emulate --faults thesis

    The arm: pipenav run-real --policy best.zip --arm arm.toml --turn left

    Look before you move: pipenav run-real --policy best.zip --dry-run

    With a policy of your own: pipenav train --preset real-setup, then pipenav calibrate --port /dev/ttyUSB0, then
    pipenav run-real --policy runs/real-setup/best.zip
    """
    from pipenav.cli.run_real_summary import conclude
    from pipenav.deployment.arm_policy import policy_for
    from pipenav.deployment.plan import MissionPlan, check_stop_file, free_folder
    from pipenav.storage.atomic_files import used_folder

    if emulation_options.emulate:
        refuse_ignored({"--arm": arm_options.arm}, "--emulate needs no real arm")
    loaded = policy_for(policy, arm_options.robot)
    pipe = _pipe(pipe_options, emulation_options.emulate)
    target, exit_ = _target(pipe_options.target, loaded.header.robot), _exit(pipe_options)
    emulation = _emulation(emulation_options, loaded.header.robot, pipe)
    folder = free_folder(out)
    if stopping.stop_file is not None:
        check_stop_file(stopping.stop_file)
    stop_file = stopping.stop_file or folder / "STOP"
    most_ticks = stopping.ticks or (DRY_RUN_TICKS if arm_options.dry_run else None)
    plan = MissionPlan(loaded, exit_, target, stopping.retreat, folder, stop_file, most_ticks)
    console = Console()
    with contextlib.ExitStack() as opened:
        opened.enter_context(used_folder(folder))
        arm = _connected(console, opened, plan, arm_options, emulation)
        _announce(console, plan, arm_options.dry_run)
        if not (arm_options.yes or arm_options.dry_run or emulation) and not typer.confirm("Move the arm?"):
            raise PipenavError("not started: nothing has moved.")
        ending = _carry_out(console, arm, plan, stopping.hold_on_stop)
    conclude(console, plan, ending, pipe, emulation)


def _pipe(given: PipeOptions, emulate: bool) -> PipeCorner | None:
    """The pipe around the arm; None where it is not known."""
    from pipenav.pipes.bend_radius import bend_radius_mm
    from pipenav.pipes.corner import PipeCorner
    from pipenav.pipes.tee import TeePassage, tee

    if given.d is None and given.angle is None and not emulate:
        return None
    if not emulate and (given.d is None or given.angle is None):
        raise PipenavError("a pipe is known by its diameter and its angle: give --d and --angle, or neither.")
    diameter, angle = (130.0 if given.d is None else given.d), (90.0 if given.angle is None else given.angle)
    if given.tee:
        return tee(diameter, angle, TeePassage("straight" if given.straight_on else "into", given.turn))
    return PipeCorner.of(diameter, angle, given.turn, bend_radius_mm(given.bend_radius, diameter))


def _exit(given: PipeOptions) -> Exit:
    """The exit that the arm is told to take."""
    from pipenav.locating.locator import Exit
    from pipenav.pipes.bend_radius import bend_radius_mm

    if given.turn not in ("left", "right"):
        raise PipenavError(f"turn {given.turn!r} is neither left nor right: give the side that the pipe turns to.")
    if given.straight_on and not given.tee:
        raise PipenavError("--straight-on is an exit of a tee: give --tee too, and the side of its branch as --turn.")
    bend = bend_radius_mm(given.bend_radius, 1.0) > 0  # in bores of any width, a radius is more than 0 or none
    if bend and given.tee:
        raise PipenavError("the pipe ahead is a bend or a tee, not both: give --bend-radius or --tee.")
    return Exit("left" if given.turn == "left" else "right", given.tee, given.straight_on, bend)


def _target(text: str | None, robot: RobotSpec) -> Floats | None:
    """The target in the robot's frame, (2,) [m], within the robot's reach; None to look for one."""
    import numpy as np

    from pipenav.deployment.target import parse_target, require_reachable

    if text is None:
        return None
    target = parse_target(text)
    require_reachable(robot, target, np.array([[joint.lower, joint.upper] for joint in robot.joints]))
    return target


def _emulation(given: EmulationOptions, robot: RobotSpec, pipe: PipeCorner | None) -> Emulation | None:
    """The emulated arm as it will be started; None for the real one."""
    from pipenav.deployment.emulation import plan_emulation

    if given.emulate:
        assert pipe is not None, "an emulated arm always has a pipe"
        return plan_emulation(robot, pipe, given.seed or 0, given.faults, given.patience)
    refuse_ignored({"--seed": given.seed}, "it is the seed of an emulated arm")
    if given.faults is not None:
        raise PipenavError("--faults are those of an emulated arm: give --emulate too.")
    if given.patience > 1:
        raise PipenavError("--patience would delay the stops of a real arm: give --emulate too, or leave it out.")
    return None


def _connected(
    console: Console,
    opened: contextlib.ExitStack,
    plan: MissionPlan,
    given: ArmOptions,
    emulation: Emulation | None,
) -> RealRobot:
    """The arm, checked and connected, until `opened` is closed; where it is emulated, its emulator too."""
    from pipenav.backends.real_robot import load_real_robot
    from pipenav.backends.registry import check_options, open_backend
    from pipenav.deployment.target import require_reachable

    robot, backend_class = plan.policy.header.robot, load_real_robot()
    settings: dict[str, Any] = {"listen_only": given.dry_run, "allow_slow_bus": given.allow_slow_bus}
    if emulation is None:
        options = check_options("hardware", backend_class, {"arm": str(given.arm or ARM_FILE), **settings})
    else:
        pipe, start, seed, faults, patience = emulation
        emulated = opened.enter_context(backend_class.emulate(robot, pipe, start, plan.folder, seed, faults))
        options = emulated.options.model_copy(update={**settings, "patience": patience})
    found = show_findings(console, backend_class.check(options, robot))
    if count := problems(found):
        raise PipenavError(f"the arm has {count} problem(s), see above: nothing has moved.")
    arm = open_backend("hardware", robot, 1, options)
    assert isinstance(arm, backend_class)
    opened.callback(arm.close)
    if plan.target is not None:
        require_reachable(robot, plan.target, arm.joint_limits)
    said = {f"{finding.what}: {finding.remedy}" for finding in found}
    for warning in arm.warnings:
        if warning not in said:
            say(f"warning: {warning}", "yellow", console)
    return arm


def _announce(console: Console, plan: MissionPlan, dry_run: bool) -> None:
    """Say what will happen, before it happens."""
    where = "a target that it looks for" if plan.target is None else "the given target"
    what = "would move" if dry_run else "is going to move"
    say(
        f"The arm {what}: {where} {plan.exit_.label}, policy {plan.policy.path}, then back out. "
        f"Keep clear of it. Space, Ctrl-C, SIGUSR1 or the file {plan.stop_file} stop it; the power switch always does.",
        console=console,
    )


def _carry_out(console: Console, arm: RealRobot, plan: MissionPlan, hold_on_stop: bool) -> Ending:
    from pipenav.cli.outlet import Outlet
    from pipenav.cli.run_real_view import MissionView
    from pipenav.deployment.session import execute

    outlet = Outlet(sys.stdout)
    shown = Console(file=cast(IO[str], outlet), width=console.width)
    try:
        with MissionView(shown, plan.policy.header.robot) as view:
            return execute(arm, plan, view, view.released if hold_on_stop else None)
    finally:
        outlet.finish(LAST_WORDS)
