"""`pipenav drive`."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipenav.cli.drive_options import ArmDriveOptions, DriveOptions, DrivePipeOptions, DriverOptions
from pipenav.cli.option_groups import takes_option_groups
from pipenav.cli.terminal import progress_console, say
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from pipenav.driving.ask import Operator
    from pipenav.driving.plans import DrivePlan
    from pipenav.driving.records import DriveRecords
    from pipenav.driving.sessions import Session
    from pipenav.driving.shown import Shown

DEFAULT_PIPE = "d=90,angle=90"

MOST_FAILURES = 20
"""Most failed episodes that are listed."""


@takes_option_groups
def drive(
    driver: DriverOptions,
    where: DrivePipeOptions,
    arm: ArmDriveOptions,
    how: DriveOptions,
    out: Annotated[Path | None, typer.Option(help="Drive folder; default runs/drive-N.")] = None,
) -> None:
    """Drive a robot by hand: joint by joint, by the tip, or by the thesis's steps (a)-(e); alone or with a policy.

    The whole robot by the keys a, b, c, d and e: pipenav drive

    The arm by its tip: pipenav drive --robot basic --pipes d=100,angle=75

    Shared control, a held key takes over: pipenav drive --policy pirate-strong --pipes d=70,angle=55

    Corners in several planes, with a roll (r) into each: pipenav drive --robot pirate-strong --pipes runs-rolled:1

    Without a person: pipenav drive --operator scripted --pipes working-range --episodes 10

    An arm made of software, over its bus, alone or with a policy: pipenav drive --emulate --policy real-setup
    """
    from pipenav.driving.plans import free_drive_folder, make_plan
    from pipenav.driving.records import write_records
    from pipenav.storage.atomic_files import used_folder

    _require_driver(driver)
    if arm.emulate or arm.arm is not None:
        from pipenav.cli.drive_arm import drive_arm

        drive_arm(driver, where, arm, out)
        return
    folder = free_drive_folder(out)
    plan = make_plan(driver.policy, where.robot, where.pipes or [DEFAULT_PIPE], where.episodes, where.seed)
    plan = plan.on(how.backend, _options(how), where.disturb, folder if how.record else None)
    with used_folder(folder):
        with contextlib.ExitStack() as opened:
            operators, mapping = _operators(opened, driver, plan)
            session, ended = _drive(opened, plan, driver, how, operators, mapping)
        written = _records(plan, driver, how, session, where.disturb)
        write_records(folder, written)
    _show(written)
    say(f"drive folder {folder}: drive.json{', and a telemetry file of every episode' if how.record else ''}")
    if ended is not None:
        raise ended


def _require_driver(driver: DriverOptions) -> None:
    if driver.operator == "none" and driver.policy is None:
        raise PipenavError("nobody drives: give --policy, or leave out --operator none.")
    if driver.operator != "person" and (driver.device or driver.mapping):
        raise PipenavError("--device and --mapping are a person's: leave them out, or choose --operator person.")


def _options(how: DriveOptions) -> dict[str, Any]:
    from pipenav.cli.options import checked_options

    return checked_options(how.backend, how.option or [])


def _operators(
    opened: contextlib.ExitStack, driver: DriverOptions, plan: DrivePlan
) -> tuple[Callable[[int], Operator] | None, Mapping[str, str]]:
    """Operators of the robots by index, and the mapping that the screen shows."""
    from pipenav.cli.drive_devices import person
    from pipenav.driving.route_steps import require_room
    from pipenav.driving.scripted import script_for

    if driver.operator == "none":
        return None, {}
    if driver.operator == "scripted":
        shared = plan.controller is not None
        if plan.robot.free and not shared:
            for pipe in plan.pipes:
                require_room(plan.robot, pipe)
        return (lambda _: script_for(plan.robot, plan.seed, shared)), {}
    operator, mapping = person(opened, driver, plan.robot)
    return (lambda _: operator), mapping


def _drive(
    opened: contextlib.ExitStack,
    plan: DrivePlan,
    driver: DriverOptions,
    how: DriveOptions,
    operators: Callable[[int], Operator] | None,
    mapping: Mapping[str, str],
) -> tuple[Session, BaseException | None]:
    """Run the session; the session, and what ended it before its last episode."""
    from rich.console import Console

    from pipenav.cli.drive_view import DriveView, with_window
    from pipenav.cli.progress_bars import episode_bar
    from pipenav.cli.signals import Interrupted
    from pipenav.driving.ask import OperatorLost
    from pipenav.driving.sessions import EndedByPerson, Session

    looked_at = driver.operator == "person" or how.watch or how.window
    view: Callable[[Shown], None] | None = None
    if looked_at:
        view = opened.enter_context(DriveView(Console(), mapping))
    if view is not None and how.window:
        view = with_window(opened, view)
    bar = None if looked_at else opened.enter_context(episode_bar(progress_console()))
    row = None if bar is None else bar.add_task("driving", total=plan.total)

    def report(done: int, passed: int) -> None:
        if bar is not None and row is not None:
            bar.update(row, completed=done, description=f"driving: {passed / done:.1%} passed")

    session = Session(plan, operators, view, looked_at, report)
    ended: BaseException | None = None
    try:
        session.run()
    except EndedByPerson:
        pass
    except (OperatorLost, Interrupted) as error:
        ended = error
    return session, ended


def _records(
    plan: DrivePlan, driver: DriverOptions, how: DriveOptions, session: Session, disturb: str | None
) -> DriveRecords:
    from pipenav.driving.records import DriveRecords

    order = {name: number for number, name in enumerate(plan.names)}
    return DriveRecords(
        schema=1,
        robot=plan.robot.name,
        policy=driver.policy,
        operator=driver.operator,
        input=driver.input if driver.operator == "person" else None,
        backend=how.backend,
        seed=plan.seed,
        disturb=disturb,
        episodes=tuple(sorted(session.records, key=lambda record: (order[record.pipe], record.number))),
    )


def _show(records: DriveRecords) -> None:
    """Say how the episodes went that came to their ends."""
    from pipenav.evaluation.interval import wilson

    episodes, n = records.episodes, len(records.episodes)
    if not n:
        say("no episode came to its end")
        return
    passed = sum(episode.passed for episode in episodes)
    low, high = wilson(passed, n)
    say(
        f"{records.driver}: {passed} of {n} episodes passed, {passed / n:.1%} "
        f"(95 % interval {low:.1%} to {high:.1%}), {sum(episode.seconds for episode in episodes) / n:.1f} s each, "
        f"{sum(episode.takeovers for episode in episodes)} take-overs"
    )
    failed = [episode for episode in episodes if not episode.passed]
    for episode in failed[:MOST_FAILURES]:
        say(f"  failed: {episode.pipe}, episode {episode.number}: {episode.outcome} after {episode.seconds:.1f} s")
    if len(failed) > MOST_FAILURES:
        say(f"  and {len(failed) - MOST_FAILURES} more, see drive.json")
