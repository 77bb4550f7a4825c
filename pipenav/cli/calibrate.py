"""`pipenav calibrate`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipenav.cli.terminal import refuse_ignored
from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from pipenav.backends.real_robot import Calibrator
    from pipenav.robots.robot import RobotSpec


def calibrate(
    port: Annotated[str | None, typer.Option(help="Device of the servo bus, for example /dev/ttyUSB0.")] = None,
    scanner_port: Annotated[str, typer.Option(help="Device of the scanner.")] = "/dev/ttyACM0",
    front_port: Annotated[str | None, typer.Option(help="Device of the front sensor, if there is one.")] = None,
    robot: Annotated[str, typer.Option(help="The arm's robot; see `pipenav robots`.")] = "real-setup",
    arm: Annotated[Path, typer.Option(help="File to write; the file to read with --store-only.")] = Path("arm.toml"),
    write_servos: Annotated[
        bool, typer.Option("--write-servos", help="Store limits and torque in the servos' EEPROM too.")
    ] = False,
    store_only: Annotated[
        bool, typer.Option("--store-only", help="Ask nothing: store what --arm says in the servos' EEPROM.")
    ] = False,
) -> None:
    """Describe an arm: it moves each joint a few degrees, asks which way it went, and writes arm.toml.

    Examples:

        pipenav calibrate --port /dev/ttyUSB0 --scanner-port /dev/ttyACM0 --front-port /dev/ttyACM1

        pipenav calibrate --port /dev/ttyUSB0 --write-servos

        pipenav calibrate --store-only --arm arm.toml
    """
    from pipenav.backends.real_robot import load_real_robot
    from pipenav.locating.locator import require_arm
    from pipenav.robots.robot import load_robot
    from pipenav.storage.atomic_files import check_outputs

    if store_only:
        ignored = {"--port": port, "--front-port": front_port, "--write-servos": write_servos}
        refuse_ignored(ignored, "--store-only stores what --arm says, at the port that it names")
        _store(arm)
        return
    if port is None:
        raise typer.BadParameter("name the device of the servo bus, for example --port /dev/ttyUSB0.")
    ports = {"servos": port, "scanner": scanner_port} | ({"front": front_port} if front_port else {})
    spec = load_robot(robot)
    check_outputs([arm])
    require_arm(spec)
    calibrator = load_real_robot().calibrator(spec, ports, write_servos)
    try:
        _calibrate(calibrator, spec, arm, write_servos)
    finally:
        calibrator.close()
    typer.echo(f"next: {shlex.join(['pipenav', 'hw-check', '--arm', str(arm)])}")


def _calibrate(calibrator: Calibrator, robot: RobotSpec, arm: Path, write_servos: bool) -> None:
    """Ask, write the file, and store the limits; what was answered is kept whatever the servos do then."""
    from pipenav.deployment.guard import guarded
    from pipenav.storage.atomic_files import atomic_write

    with guarded(calibrator):
        _ask(calibrator, robot)
        _keep_former(arm)
        atomic_write(arm, calibrator.text())
        typer.echo(f"wrote {arm}")
        if not write_servos:
            return
        try:
            for line in calibrator.write_servos():
                typer.echo(line)
        except PipenavError as error:
            command = shlex.join(["pipenav", "calibrate", "--store-only", "--arm", str(arm)])
            raise PipenavError(
                f"{error} Not all is stored: your answers are kept in {arm}; store them by {command}"
            ) from error


def _keep_former(arm: Path) -> None:
    """Keep an earlier description, which may be another arm's, under a name with a number."""
    from pipenav.storage.atomic_files import atomic_write

    if not arm.exists():
        return
    number = 1
    while (former := arm.with_stem(f"{arm.stem}-{number}")).exists():
        number += 1
    atomic_write(former, arm.read_bytes())
    typer.echo(f"kept the former {arm} as {former}")


def _store(arm: Path) -> None:
    """Store what an arm's description says in its servos."""
    from pipenav.backends.real_robot import load_real_robot
    from pipenav.backends.registry import check_options

    backend_class = load_real_robot()
    for line in backend_class.store(check_options("hardware", backend_class, {"arm": str(arm)})):
        typer.echo(line)


def _ask(calibrator: Calibrator, robot: RobotSpec) -> None:
    """Have every joint move, and ask the person at the arm what it did."""
    typer.prompt("Put the arm straight, its carriage at the start, and press Enter", default="", show_default=False)
    calibrator.set_zero()
    for joint in robot.joints:
        slide = joint.type == "slide"
        typer.prompt(f"{joint.name} moves a little now; keep clear and press Enter", default="", show_default=False)
        if abs(calibrator.nudge(joint.name)) < 0.05:
            raise PipenavError(f"{joint.name} did not move: free it, check its supply, and calibrate again.")
        positive = typer.confirm(f"Did {joint.name} move {'forwards, into the pipe' if slide else 'to the left'}?")
        moved = typer.prompt("By how many mm?", type=float) if slide else None
        if moved is not None and not 0.5 <= abs(moved) <= 500:
            raise PipenavError(f"{moved:g} mm is not a possible travel of the carriage: measure again, 0.5 to 500 mm.")
        calibrator.set_direction(joint.name, positive, moved)
