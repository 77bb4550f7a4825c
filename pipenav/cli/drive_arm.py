"""`pipenav drive` on the real arm, or on one made of software."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

from pipenav.cli.drive_options import ArmDriveOptions, DrivePipeOptions, DriverOptions
from pipenav.cli.hw_check import problems, show_findings
from pipenav.cli.terminal import say
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from collections.abc import Callable

    from pipenav.backends.messages import Reading
    from pipenav.backends.real_robot import RealRobot
    from pipenav.deployment.emulation import Emulation
    from pipenav.deployment.session import Ending
    from pipenav.driving.arm_session import ArmScene, HandMission
    from pipenav.driving.ask import Operator
    from pipenav.pipes.corner import PipeCorner
    from pipenav.robots.robot import RobotSpec

DEFAULT_ROBOT, DEFAULT_PIPE = "real-setup", "d=130,angle=90"


def drive_arm(driver: DriverOptions, where: DrivePipeOptions, given: ArmDriveOptions, out: Path | None) -> None:
    """Drive an arm by hand, or beside a policy, until the person or the mission ends it, or something stops it.

    Raises:
        Stopped: something stopped the arm; its torque is off.
        PipenavError: the arm cannot be driven; nothing has moved.
    """
    from pipenav.cli.drive_view import DriveView
    from pipenav.deployment.arm_policy import policy_for
    from pipenav.driving.arm_session import Beside, HandMission, drive_by_hand
    from pipenav.driving.door import Door
    from pipenav.driving.plans import free_drive_folder
    from pipenav.locating.locator import require_arm
    from pipenav.robots.robot import load_robot
    from pipenav.storage.atomic_files import used_folder

    _refuse(driver, where, given)
    policy = None if driver.policy is None else policy_for(driver.policy, where.robot)
    robot = load_robot(where.robot or DEFAULT_ROBOT) if policy is None else policy.header.robot
    require_arm(robot)
    pipe = _pipe(where, given.emulate)
    folder = free_drive_folder(out)
    console = Console()
    with contextlib.ExitStack() as opened:
        operator, mapping = _operator(opened, driver, robot, where.seed)
        opened.enter_context(used_folder(folder))
        scene, emulation = _scene(
            robot, pipe, where.seed, given, folder, driver.operator == "scripted" and policy is None
        )
        arm = _connected(console, opened, robot, given, emulation, folder)
        say(
            f"The arm is going to move as you drive it. Keep clear of it. The stop key, Ctrl-C, SIGUSR1 or the file "
            f"{scene.stop_file} stop it; the power switch always does.",
            console=console,
        )
        if not (given.yes or given.emulate) and not typer.confirm("Move the arm?"):
            raise PipenavError("not started: nothing has moved.")
        beside = None if policy is None or pipe is None else Beside(policy, _settings(pipe))
        mission = HandMission(robot, Door(robot, operator, beside is not None), scene, beside)
        view = opened.enter_context(DriveView(console, mapping, sleep=lambda _: None))
        header = {"robot": robot.name, "operator": driver.operator, "input": driver.input}
        ending = drive_by_hand(arm, mission, scene, _shower(view, mission, robot, scene), header)
    _conclude(console, ending, folder)


def _refuse(driver: DriverOptions, where: DrivePipeOptions, given: ArmDriveOptions) -> None:
    if given.emulate and given.arm is not None:
        raise PipenavError("--emulate needs no real arm: leave out --arm.")
    if driver.operator == "none":
        raise PipenavError("a policy alone drives the arm by pipenav run-real: leave out --operator none.")
    if driver.policy is not None and not given.emulate and where.pipes is None:
        raise PipenavError("the policy must be told which way the pipe turns: name the pipe with --pipes.")
    if where.episodes > 1 or where.disturb is not None:
        raise PipenavError("--episodes and --disturb are for simulators: leave them out.")
    if driver.operator == "scripted" and not given.emulate:
        raise PipenavError("a script never drives the real arm: give --emulate instead of --arm.")
    if given.patience > 1 and not given.emulate:
        raise PipenavError("--patience would delay the stops of a real arm: give --emulate instead, or leave it out.")


def _pipe(where: DrivePipeOptions, emulate: bool) -> PipeCorner | None:
    """The pipe around the arm; None where it is not known."""
    from pipenav.pipes.corner_sets import parse_corners

    if where.pipes is None and not emulate:
        return None
    corners = parse_corners(where.pipes or [DEFAULT_PIPE])
    if len(corners) > 1:
        raise PipenavError(f"the arm stands in one pipe, and these are {len(corners)}: name one with --pipes.")
    return corners[0]


def _operator(
    opened: contextlib.ExitStack, driver: DriverOptions, robot: RobotSpec, seed: int
) -> tuple[Operator, dict[str, str]]:
    from pipenav.cli.drive_devices import person
    from pipenav.driving.scripted import script_for

    if driver.operator == "scripted":
        return script_for(robot, seed, driver.policy is not None), {}
    operator, mapping = person(opened, driver, robot)
    return operator, dict(mapping)


def _scene(
    robot: RobotSpec, pipe: PipeCorner | None, seed: int, given: ArmDriveOptions, folder: Path, ends: bool
) -> tuple[ArmScene, Emulation | None]:
    """Surroundings of the arm, and the emulated arm as it will be started; None for the real one."""
    import numpy as np

    from pipenav.deployment.emulation import plan_emulation
    from pipenav.driving.arm_session import ArmScene
    from pipenav.driving.door import Scene
    from pipenav.robots import frames
    from pipenav.tasks.reach import episode
    from pipenav.tasks.reach.config import ReachConfig

    task = ReachConfig()
    reached = task.reach_tolerance if ends else 0.0
    gap = sum(task.start_gap) / 2
    if pipe is None or not given.emulate:
        return ArmScene(Scene(pipe, gap, None), 0.0, folder, folder / "STOP", given.ticks), None
    emulation = plan_emulation(robot, pipe, seed, None, given.patience)
    drawn = episode.sample(robot, task, [pipe], np.random.default_rng(seed))
    target = frames.canonical_to_robot(drawn.target[0], pipe.turn_sign)
    return ArmScene(Scene(pipe, gap, target), reached, folder, folder / "STOP", given.ticks), emulation


def _connected(
    console: Console,
    opened: contextlib.ExitStack,
    robot: RobotSpec,
    given: ArmDriveOptions,
    emulation: Emulation | None,
    folder: Path,
) -> RealRobot:
    """The arm, checked and connected, until `opened` is closed."""
    from pipenav.backends.real_robot import load_real_robot
    from pipenav.backends.registry import check_options, open_backend

    backend_class = load_real_robot()
    settings: dict[str, Any] = {"allow_slow_bus": given.allow_slow_bus}
    if emulation is None:
        options = check_options("hardware", backend_class, {"arm": str(given.arm), **settings})
    else:
        pipe, start, seed, faults, patience = emulation
        emulated = opened.enter_context(backend_class.emulate(robot, pipe, start, folder, seed, faults))
        options = emulated.options.model_copy(update={**settings, "patience": patience})
    found = show_findings(console, backend_class.check(options, robot))
    if count := problems(found):
        raise PipenavError(f"the arm has {count} problem(s), see above: nothing has moved.")
    arm = open_backend("hardware", robot, 1, options)
    assert isinstance(arm, backend_class)
    opened.callback(arm.close)
    return arm


def _settings(pipe: PipeCorner) -> dict[str, Any]:
    """Settings of the policy's mission: it looks for its target, and is told which way the pipe goes."""
    from pipenav.deployment.mission import mission_settings
    from pipenav.locating.locator import Exit

    return mission_settings(Exit.of(pipe), None, False)


def _shower(
    view: Callable[[Any], None], mission: HandMission, robot: RobotSpec, scene: ArmScene
) -> Callable[[dict[str, Any]], None]:
    """A function that shows the record of a tick."""
    import numpy as np

    from pipenav.driving.shown import Picture, Shown
    from pipenav.robots import frames, kinematics

    pipe = scene.scene.pipe
    label, walls = ("", np.zeros((0, 2, 2))) if pipe is None else (pipe.label, pipe.segments)
    base = 0.0 if pipe is None else -pipe.inner_edge - scene.scene.tip_gap - robot.length

    def show(record: dict[str, Any]) -> None:
        if "q" not in record:
            return
        q = np.array(record["q"])
        points = frames.robot_to_pipe(kinematics.waypoints(robot, q[None])[0], base)
        seen = None if mission.target is None else frames.robot_to_pipe(mission.target, base)
        reading = _reading(record)
        picture = Picture(label, walls, points, seen)
        view(Shown(picture, reading, mission.door, record["tick"] / 10, 0.0))

    return show


def _reading(record: dict[str, Any]) -> Reading:
    import numpy as np

    from pipenav.backends.messages import Reading

    q, qd, ranges = (np.array([record[key]], float) for key in ("q", "qd", "ranges"))
    return Reading(q, qd, ranges, np.array([record["time"]]))


def _conclude(console: Console, ending: Ending, folder: Path) -> None:
    """Say how the session went, and end the command by the right exit code.

    Raises:
        typer.Exit: a signal stopped the arm.
        Stopped: something else stopped it.
    """
    from pipenav.deployment.guard import StoppedBySignal
    from pipenav.deployment.plan import TELEMETRY
    from pipenav.deployment.summary import pace
    from pipenav.deployment.telemetry import read_telemetry

    if ending.last_ticks and ending.outcome != "telemetry":
        kept = pace(read_telemetry(folder / TELEMETRY).ticks)
        say(
            f"{ending.outcome}: {kept.ticks} ticks at {kept.rate:.2f} Hz of 10, worst tick {kept.worst * 1e3:.1f} ms, "
            f"{kept.late} late, {kept.clamped} limited; drive folder {folder}: {TELEMETRY}",
            console=console,
        )
    if isinstance(ending.stopped, StoppedBySignal):
        typer.echo(f"pipenav: {ending.stopped}", err=True)
        raise typer.Exit(128 + ending.stopped.number)
    if ending.stopped is not None:
        raise ending.stopped
