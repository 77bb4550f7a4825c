"""`pipenav mirror-rear`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from pipenav.motions.trajectory import Trajectory


def mirror_rear(
    trajectory: Annotated[
        list[Path],
        typer.Option(
            help="The front half's recorded passage; of a passage in parts, give locating first and the front last.",
            show_default=False,
        ),
    ],
    out: Annotated[Path, typer.Option(help="The rear half's trajectory.")] = Path("rear.csv"),
    replay: Annotated[bool, typer.Option("--replay", help="Run it in a simulator and say how well it goes.")] = False,
    record: Annotated[
        Path | None, typer.Option(help="With --replay: also write what the arm really did, as a trajectory.")
    ] = None,
    backend: Annotated[str, typer.Option(help="Simulator of the replay; see `pipenav backends`.")] = "mujoco",
    robot: Annotated[str | None, typer.Option(help="Robot, if the trajectory's is not a shipped one.")] = None,
    option: Annotated[list[str] | None, typer.Option(help="Setting of that simulator, key=value; repeatable.")] = None,
) -> None:
    """Turn a front half's recorded passage into the rear half's: mirrored in space, reversed in time (approach II).

    Examples:

        pipenav view --policy arm --pipes d=90,angle=60 --out front.csv

        pipenav mirror-rear --trajectory front.csv --out rear.csv --replay

        pipenav mirror-rear --trajectory front.csv --replay --record replayed.csv --option timestep=0.001

        pipenav mirror-rear --trajectory locate.csv --trajectory front.csv
    """
    from rich.console import Console

    from pipenav.motions.mirror import hand_over, plan_rear
    from pipenav.motions.trajectory_file import read_trajectory, write_trajectory
    from pipenav.robots.robot import load_robot
    from pipenav.units import m_to_mm, rad_to_deg

    if record is not None and not replay:
        raise PipenavError("--record writes what --replay runs: give both.")
    spec = None if robot is None else load_robot(robot)
    parts = [read_trajectory(path, spec) for path in trajectory]
    plan = plan_rear(parts)
    write_trajectory(out, plan)
    console = Console(highlight=False, soft_wrap=True)
    console.print(f"written: {out}, {len(plan.q)} rows, {plan.time[-1]:.1f} s, {plan.header.pipe.label}")
    jump = hand_over(plan.robot, parts[-1].motion)
    console.print(
        f"hand-over jump: the robot's middle {m_to_mm(jump.straight):.0f} mm ({m_to_mm(jump.distance):.0f} mm along "
        f"the pipe) and {rad_to_deg(jump.turn_angle):.0f} deg; "
        f"largest joint change {rad_to_deg(jump.joint_change):.0f} deg"
    )
    if replay:
        replayed = _replay(plan, backend, option or [])
        console.print(replayed[1])
        if record is not None:
            write_trajectory(record, replayed[0])
            console.print(f"written: {record}")


def _replay(plan: Trajectory, backend: str, options: list[str]) -> tuple[Trajectory, str]:
    """What the arm did, and the same in a sentence."""
    from pipenav.backends.registry import check_options
    from pipenav.backends.simulators import load_simulator
    from pipenav.cli.options import parse_options
    from pipenav.recording.record import RecordingSettings, record_rear, tracking
    from pipenav.units import m_to_mm, rad_to_deg

    parsed = parse_options(options)
    check_options(backend, load_simulator(backend), parsed)
    done = record_rear(plan, RecordingSettings(backend, parsed))
    error = tracking(plan, done)
    force = 0.0 if done.contact_force is None else float(done.contact_force.max())
    end = "the arm came out of the corner" if done.succeeded else f"the arm did not come out: {done.header.outcome}"
    joints = f"{rad_to_deg(error.joint):.1f} deg of a hinge, {m_to_mm(error.slide):.1f} mm of the slide"
    return done, (
        f"replay on {backend}: {end} after {done.time[-1]:.1f} s; largest tracking error {m_to_mm(error.tip):.1f} mm "
        f"at the tip, {joints}; largest contact force {force:.1f} N"
    )
