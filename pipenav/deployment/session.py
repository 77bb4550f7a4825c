"""One run on an arm from its preparation to its summary, for whoever asks and shows."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable, Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Reading
from pipenav.backends.real_robot import RealRobot
from pipenav.backends.safety import Stopped
from pipenav.deployment import loop
from pipenav.deployment.mission import mission_of
from pipenav.deployment.picture import mission_picture
from pipenav.deployment.replay import POLICY_COPY
from pipenav.deployment.telemetry import Telemetry
from pipenav.deployment.trajectories import ArmPlacement, parts, placement_of
from pipenav.errors import PipenavError
from pipenav.locating.locator import LocateConfig, require_arm
from pipenav.motions.trajectory_file import write_trajectory
from pipenav.pipes.corner import PipeCorner, Turn
from pipenav.policies.header import RATE_HZ, installed_versions
from pipenav.policies.policy import Policy, load_policy, policy_names, resolve_policy
from pipenav.robots import kinematics
from pipenav.robots.robot import RobotSpec, load_robot
from pipenav.storage.atomic_files import atomic_write, prepare_folder
from pipenav.tasks.registry import require_reach

TELEMETRY, PICTURE = "telemetry.jsonl", "run.png"
PASSED = "passed"

DEFAULT_ROBOT = "real-setup"
"""The physical arm."""


class MissionPlan(NamedTuple):
    """What a run shall do.

    Attributes:
        policy: what reaches the target.
        turn: the side that the pipe turns to.
        target: target in the robot's own frame, (2,) [m]; None to look for one.
        retreat: whether to back out when it is not found or not reached.
        folder: where telemetry, policy and picture go.
        stop_file: a file whose appearance is an emergency stop.
        most_ticks: end after so many; None for no such end.
    """

    policy: Policy
    turn: Turn
    target: Floats | None
    retreat: bool
    folder: Path
    stop_file: Path
    most_ticks: int | None = None


class Ending(NamedTuple):
    """How a run ended.

    Attributes:
        outcome: `passed`, or the word of what it failed by.
        stopped: what stopped it; None where it ended by itself.
        last_ticks: the newest records.
    """

    outcome: str
    stopped: Stopped | None
    last_ticks: list[dict[str, Any]]


def free_folder(given: Path | None) -> Path:
    """The folder of a new run: the given one, which must hold no run yet, or the next free one under `runs/`."""
    if given is not None:
        if (given / TELEMETRY).exists():
            raise PipenavError(f"{given} holds a run already: give another folder by --out.")
        return prepare_folder(given)
    number = 1
    while (folder := Path("runs") / f"real-{number}").exists():
        number += 1
    return prepare_folder(folder)


def policy_for(name: str | None, robot: str | None) -> Policy:
    """The policy for an arm.

    Args:
        name: a policy file or a shipped policy's name; None for the shipped one that drives the robot.
        robot: the robot's name; None for the policy's own, or where no policy is named for `DEFAULT_ROBOT`.

    Raises:
        UnknownName, PolicyFileError: there is no such policy or robot, or the file cannot be used.
        PipenavError: no shipped policy drives the robot; the policy is for another one, commands torques, or was
            trained at another rate.
    """
    if name is None:
        return _shipped_policy(load_robot(robot or DEFAULT_ROBOT))
    policy = load_policy(resolve_policy(name))
    if robot is not None:
        policy.require(load_robot(robot))
    _require_drivable(policy)
    return policy


def _shipped_policy(robot: RobotSpec) -> Policy:
    for name in policy_names():
        policy = load_policy(resolve_policy(name))
        if policy.header.robot == robot and policy.header.task.control == "position":
            return policy
    raise PipenavError(
        f"no shipped policy drives robot {robot.name!r}: train one (pipenav presets lists recipes) and give --policy."
    )


def _require_drivable(policy: Policy) -> None:
    require_arm(policy.header.robot)
    header = policy.header
    require_reach(header.task, "a run on an arm")
    if header.task.control != "position":
        raise PipenavError(
            f"policy {policy.path} commands torques, and the arm's servos take positions: "
            "train one with --control position."
        )
    if abs(header.rate_hz - RATE_HZ) > 1e-9:
        raise PipenavError(
            f"policy {policy.path} was trained at {header.rate_hz:g} Hz, the arm is driven at {RATE_HZ:g} Hz: "
            "train one with this version."
        )


def mission_settings(turn: Turn, target: Floats | None, retreat: bool) -> dict[str, Any]:
    """What a telemetry's header says of a run, and `mission_of` makes it from.

    Args:
        turn: the side that the pipe turns to.
        target: target in the robot's own frame, (2,) [m]; None to look for one.
        retreat: whether to back out when it is not found or not reached.
    """
    return {
        "side": 1.0 if turn == "left" else -1.0,
        "period_s": CONTROL_PERIOD,
        "goal_m": None if target is None else [float(x) for x in target],
        "locate": LocateConfig().model_dump(),
        "retreat": retreat,
    }


def execute(
    machine: RealRobot, plan: MissionPlan, show: Callable[[dict[str, Any]], None], released: Callable[[], bool] | None
) -> Ending:
    """Switch the arm on, drive it, switch it off; its telemetry is on disk then.

    Args:
        machine: connected.
        plan: what to do.
        show: called with every tick's record.
        released: with `--hold-on-stop`: whether someone holds the arm now; None to switch off at once.
    """
    settings = mission_settings(plan.turn, plan.target, plan.retreat)
    run = mission_of(plan.policy, settings)
    content = plan.policy.path.read_bytes()
    atomic_write(plan.folder / POLICY_COPY, content)
    stopped: Stopped | None = None
    with contextlib.ExitStack() as opened:
        try:
            with loop.guarded(machine):
                first = machine.read()
                rehearse(plan.policy, settings, first)
                start = first.q
                machine.reset(np.array([0]), [], start, np.zeros(1))
                header = {
                    "started": datetime.now(UTC).isoformat(timespec="seconds"),
                    "backend": "hardware",
                    "robot": plan.policy.header.robot.name,
                    "policy": str(plan.policy.path),
                    "policy_sha256": hashlib.sha256(content).hexdigest(),
                    "run": settings,
                    "machine": machine.description(),
                    "versions": installed_versions(),
                }
                telemetry = opened.enter_context(Telemetry(plan.folder / TELEMETRY, header))
                try:
                    outcome = loop.drive(machine, run, telemetry, show, plan.stop_file, plan.most_ticks)
                except Stopped as broken:
                    telemetry.end("stopped", broken.cause, broken.what)
                    if released is not None and not isinstance(broken, loop.Interrupted):
                        loop.hold_until(machine, released)
                    raise
        except Stopped as broken:
            stopped, outcome = broken, broken.cause
        else:
            telemetry.end(outcome, None, "")
        return Ending(outcome, stopped, list(telemetry.last) if "telemetry" in locals() else [])


def rehearse(policy: Policy, settings: dict[str, Any], reading: Reading) -> None:
    """Decide once in every stage, before torque is on: what a first time takes would make a tick late."""
    tip = kinematics.forward(policy.header.robot, reading.q).tip[0]
    for target in (None, [float(tip[0]) + 0.1, float(tip[1]) + 0.1]):
        mission_of(policy, settings | {"goal_m": target}).decide(reading)


class Pace(NamedTuple):
    """How well the loop kept its time.

    Attributes:
        ticks: how many.
        rate: achieved [Hz].
        worst: longest time from when a tick was due to when its command was out [s].
        late: ticks later than their deadline.
        parts: mean time of each part of the loop [s].
        clamped: ticks in which a set-point was limited.
    """

    ticks: int
    rate: float
    worst: float
    late: int
    parts: dict[str, float]
    clamped: int


def pace(ticks: Sequence[dict[str, Any]]) -> Pace:
    """The pace of recorded ticks."""
    timed = [tick for tick in ticks if "seconds" in tick]
    names = ("bus", "read", "decide", "send", "taken")
    parts = {
        name: float(np.mean([tick["seconds"][name] for tick in timed if name in tick["seconds"]] or [0.0]))
        for name in names
    }
    span = timed[-1]["time"] - timed[0]["time"] if len(timed) > 1 else 0.0
    count = timed[-1]["tick"] - timed[0]["tick"] if timed else 0
    return Pace(
        ticks=len(ticks),
        rate=count / span if span else 0.0,
        worst=max((tick["seconds"].get("taken", 0.0) for tick in timed), default=0.0),
        late=max((tick["raw"]["late"] for tick in ticks), default=0),
        parts=parts,
        clamped=sum(bool(tick.get("clamped")) for tick in ticks),
    )


def located_place(plan: MissionPlan, ticks: Sequence[dict[str, Any]], pipe: PipeCorner) -> ArmPlacement | None:
    """Where the arm stood in a pipe that is known; None where it located no target."""
    target = next((tick["target"] for tick in reversed(ticks) if tick.get("target")), None)
    if plan.target is not None or target is None:
        return None
    return placement_of(pipe, np.array(target), LocateConfig().depth)


def write_motions(
    plan: MissionPlan, ticks: Sequence[dict[str, Any]], outcome: str, place: ArmPlacement | None
) -> Iterator[Path]:
    """Write the run's picture, and where its place is known its motions as trajectory files.

    Args:
        plan: the run.
        ticks: its records.
        outcome: how it ended.
        place: where the arm stood.
    """
    robot = plan.policy.header.robot
    where = "" if place is None else f" in {place.pipe.label}"
    title = f"{robot.name}{where}: {outcome}, {len(ticks)} ticks"
    picture = plan.folder / PICTURE
    pipe, base = (None, 0.0) if place is None else place
    atomic_write(picture, mission_picture(robot, ticks, title, pipe, base))
    yield picture
    if place is not None:
        for name, trajectory in parts(plan.policy, ticks, place):
            path = plan.folder / f"{name}.csv"
            write_trajectory(path, trajectory)
            yield path
