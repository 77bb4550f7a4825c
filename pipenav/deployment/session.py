"""A session of the real arm: switch it on, let it carry out its mission, switch it off."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np

from pipenav.backends.messages import Reading
from pipenav.backends.real_robot import RealRobot
from pipenav.backends.safety import Stopped
from pipenav.deployment.guard import StoppedBySignal, guarded
from pipenav.deployment.loop import control_loop, hold_until
from pipenav.deployment.mission import mission_of, mission_settings
from pipenav.deployment.plan import POLICY_COPY, TELEMETRY, MissionPlan
from pipenav.deployment.telemetry import Telemetry
from pipenav.errors import FileProblem
from pipenav.policies.header import installed_versions
from pipenav.policies.policy import Policy
from pipenav.robots import kinematics
from pipenav.storage.atomic_files import atomic_write

PASSED = "passed"


class Ending(NamedTuple):
    """End of a mission.

    Attributes:
        outcome: `passed`, or the word for how it failed.
        stopped: what stopped the arm; None where the mission ended by itself.
        last_ticks: the newest records.
    """

    outcome: str
    stopped: Stopped | None
    last_ticks: list[dict[str, Any]]


def execute(
    arm: RealRobot, plan: MissionPlan, show: Callable[[dict[str, Any]], None], released: Callable[[], bool] | None
) -> Ending:
    """Switch the arm on, let it carry out a mission, switch it off; its telemetry is on disk then.

    Args:
        arm: the real robot, connected.
        plan: the mission's plan.
        show: called with the record of every tick.
        released: with `--hold-on-stop`: whether someone holds the arm now; None to switch off at once.
    """
    settings = mission_settings(plan.exit_, plan.target, plan.retreat)
    mission = mission_of(plan.policy, settings)
    policy_bytes = plan.policy.path.read_bytes()
    atomic_write(plan.folder / POLICY_COPY, policy_bytes)
    with Telemetry(plan.folder / TELEMETRY) as telemetry:
        try:
            with guarded(arm):
                switch_on(arm, plan.policy, settings)
                try:
                    telemetry.begin(_header(arm, plan.policy, policy_bytes, settings))
                    outcome = control_loop(arm, mission, telemetry, show, plan.stop_file, plan.most_ticks)
                except FileProblem as problem:
                    raise Stopped("telemetry", str(problem).rstrip("."), "make room, then start again") from problem
                except Stopped as stopped:
                    if released is not None and not isinstance(stopped, StoppedBySignal):
                        _end(telemetry, stopped)
                        hold_until(arm, released)
                    raise
        except Stopped as stopped:
            _end(telemetry, stopped)  # not before torque is off: a disk may take its time
            return Ending(stopped.cause, stopped, list(telemetry.last))
        telemetry.end(outcome, None, "")
        return Ending(outcome, None, list(telemetry.last))


def _end(telemetry: Telemetry, stopped: Stopped) -> None:
    """Write what stopped the arm, as far as it can be written: a full disk must not hide it."""
    with contextlib.suppress(FileProblem):
        telemetry.end("stopped", stopped.cause, stopped.what)


def switch_on(arm: RealRobot, policy: Policy, settings: dict[str, Any]) -> None:
    """Read, rehearse, and switch torque on where the arm is."""
    first = arm.read()
    rehearse(policy, settings, first)
    arm.reset(np.array([0]), [], first.q, np.zeros(1))


def rehearse(policy: Policy, settings: dict[str, Any], reading: Reading) -> None:
    """Decide once in every stage, before torque is on: what a first time takes would make a tick late.

    Args:
        policy: the policy.
        settings: settings of the mission, see `mission_settings`.
        reading: readings of the sensors now, rows of one.
    """
    tip = kinematics.forward(policy.header.robot, reading.q).tip[0]
    for target in (None, [float(tip[0]) + 0.1, float(tip[1]) + 0.1]):
        mission_of(policy, settings | {"goal_m": target}).decide(reading)


def _header(arm: RealRobot, policy: Policy, policy_bytes: bytes, settings: dict[str, Any]) -> dict[str, Any]:
    """The header of a telemetry, see docs/formats/telemetry.md."""
    return {
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "backend": "hardware",
        "robot": policy.header.robot.name,
        **policy_record(policy, policy_bytes, settings),
        "machine": arm.description(),
        "versions": installed_versions(),
    }


def policy_record(policy: Policy, policy_bytes: bytes, settings: dict[str, Any]) -> dict[str, Any]:
    """Part of a telemetry's header about the policy and its mission.

    Args:
        policy: the policy.
        policy_bytes: content of its file.
        settings: settings of the mission, see `mission_settings`.
    """
    return {
        "policy": str(policy.path),
        "policy_sha256": hashlib.sha256(policy_bytes).hexdigest(),
        "run": settings,
    }
