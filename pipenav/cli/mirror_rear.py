"""`pipenav mirror-rear`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipenav.errors import PipenavError

if TYPE_CHECKING:
    from pipenav.motions.trajectory import Trajectory

TRAJECTORY_HELP = (
    "The front half's recorded passage; for a passage in parts, give the locating part first and the front part last."
)
PASSAGE, REPLAY = "The passage", "Replay"
DEFAULT_BACKEND = "mujoco"


TrajectoryOption = Annotated[
    list[Path], typer.Option(help=TRAJECTORY_HELP, show_default=False, rich_help_panel=PASSAGE)
]
RobotOption = Annotated[
    str | None, typer.Option(help="Robot, if the trajectory's is not a shipped one.", rich_help_panel=PASSAGE)
]
OutOption = Annotated[Path, typer.Option(help="The rear half's trajectory.", rich_help_panel=PASSAGE)]
ReplayOption = Annotated[
    bool, typer.Option("--replay", help="Run it in a simulator and say how well it goes.", rich_help_panel=REPLAY)
]
RecordOption = Annotated[
    Path | None,
    typer.Option(help="With --replay: also write what the arm really did, as a trajectory.", rich_help_panel=REPLAY),
]
BackendOption = Annotated[
    str | None,
    typer.Option(
        help="Simulator of the replay; see `pipenav backends`.", show_default=DEFAULT_BACKEND, rich_help_panel=REPLAY
    ),
]
ReplaySettingsOption = Annotated[
    list[str] | None,
    typer.Option("--option", help="Setting of that simulator, key=value; repeatable.", rich_help_panel=REPLAY),
]


def mirror_rear(
    trajectory: TrajectoryOption,
    robot: RobotOption = None,
    out: OutOption = Path("rear.csv"),
    replay: ReplayOption = False,
    record: RecordOption = None,
    backend: BackendOption = None,
    option: ReplaySettingsOption = None,
) -> None:
    """Turn a front half's recorded passage into the rear half's: mirrored in space, reversed in time (approach II).

    Examples:

        pipenav view --policy arm --pipes d=90,angle=60 --out front.csv
        pipenav mirror-rear --trajectory front.csv --out rear.csv --replay
        pipenav mirror-rear --trajectory front.csv --replay --record replayed.csv --option timestep=0.001
        pipenav mirror-rear --trajectory locate.csv --trajectory front.csv
    """
    from pipenav.cli.options import recording_settings
    from pipenav.cli.terminal import refuse_ignored, say
    from pipenav.motions.mirror import plan_rear
    from pipenav.motions.trajectory_file import read_trajectory, write_trajectory
    from pipenav.recording.record import record_rear
    from pipenav.robots.robot import load_robot
    from pipenav.storage.atomic_files import check_outputs

    if record is not None and not replay:
        raise PipenavError("--record writes what --replay runs: give both.")
    if not replay:
        refuse_ignored({"--backend": backend, "--option": option}, "only --replay runs a simulator")
    settings = recording_settings(backend or DEFAULT_BACKEND, option or [])
    check_outputs([out, *([] if record is None else [record])], inputs=[*trajectory, *_robot_file(robot)])
    spec = None if robot is None else load_robot(robot)
    parts = [read_trajectory(path, spec) for path in trajectory]
    plan = plan_rear(parts)
    write_trajectory(out, plan)
    say(f"written: {out}, {len(plan.q)} rows, {plan.time[-1]:.1f} s, {plan.header.pipe.label}")
    say(_hand_over_sentence(plan, parts[-1]))
    if not replay:
        return
    done = record_rear(plan, settings)
    say(_replay_sentence(plan, done, backend or DEFAULT_BACKEND))
    if record is not None:
        write_trajectory(record, done)
        say(f"written: {record}")


def _robot_file(robot: str | None) -> list[Path]:
    return [Path(robot)] if robot is not None and robot.endswith(".toml") else []


def _hand_over_sentence(plan: Trajectory, front: Trajectory) -> str:
    from pipenav.motions.mirror import hand_over
    from pipenav.units import m_to_mm, rad_to_deg

    jump = hand_over(plan.robot, front.motion)
    return (
        f"hand-over jump: the robot's middle {m_to_mm(jump.straight):.0f} mm ({m_to_mm(jump.distance):.0f} mm along "
        f"the pipe) and {rad_to_deg(jump.turn_angle):.0f} deg; "
        f"largest joint change {rad_to_deg(jump.joint_change):.0f} deg"
    )


def _replay_sentence(plan: Trajectory, done: Trajectory, backend: str) -> str:
    from pipenav.recording.record import tracking
    from pipenav.units import m_to_mm, rad_to_deg

    error = tracking(plan, done)
    force = 0.0 if done.contact_force is None else float(done.contact_force.max())
    end = "the arm came out of the corner" if done.succeeded else f"the arm did not come out: {done.header.outcome}"
    joints = f"{rad_to_deg(error.joint):.1f} deg of a hinge, {m_to_mm(error.slide):.1f} mm of the slide"
    return (
        f"replay on {backend}: {end} after {done.time[-1]:.1f} s; largest tracking error {m_to_mm(error.tip):.1f} mm "
        f"at the tip, {joints}; largest contact force {force:.1f} N"
    )
