"""A recorded run once more, without its arm: the same bytes must give the same readings, actions and packets."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from pipenav.backends.real_robot import Recoder, load_real_robot
from pipenav.backends.safety import Stopped
from pipenav.deployment.loop import RETREATABLE, seen
from pipenav.deployment.mission import Mission, mission_of
from pipenav.deployment.telemetry import Recording, TelemetryFileError, read_telemetry
from pipenav.policies.policy import load_policy

POLICY_COPY = "policy.zip"
"""The policy that ran lies beside its telemetry."""

COMPARED = ("stage", "q", "qd", "ranges", "time", "observation", "action", "command", "sent", "clamped", "packet")


class Replay(NamedTuple):
    """What came of a replay.

    Attributes:
        ticks: how many were compared.
        packets: how many packets were the same.
        difference: the first difference in words; empty where there is none.
    """

    ticks: int
    packets: int
    difference: str


def replay(path: Path) -> tuple[Replay, Recording]:
    """Do a recorded run's arithmetic again and compare every bit.

    Raises:
        TelemetryFileError, FileProblem, PolicyFileError: the log or the policy beside it cannot be used.
    """
    recording = read_telemetry(path)
    policy = load_policy(path.with_name(POLICY_COPY))
    try:
        header = recording.header
        recoder = load_real_robot(header["backend"]).recoder(policy.header.robot, header["machine"])
        run = mission_of(policy, header["run"])
        return _compare(recording, recoder, run), recording
    except (KeyError, TypeError, ValueError) as error:
        raise TelemetryFileError(path, f"lacks what a replay needs ({type(error).__name__}: {error})") from error


def _compare(recording: Recording, recoder: Recoder, run: Mission) -> Replay:
    packets = 0
    for tick in recording.ticks:
        try:
            again = _again(tick, recoder, run)
        except Stopped as stopped:
            again = {"stopped": stopped.cause}
        if "stopped" in tick:
            continue  # what stopped it may have been a signal, the clock or a servo: no arithmetic
        for key in COMPARED:
            if tick.get(key) != again.get(key):
                return Replay(
                    tick["tick"],
                    packets,
                    f"tick {tick['tick']}: {key} is {again.get(key)}, recorded {tick.get(key)}",
                )
        packets += bool(tick.get("packet"))
    return Replay(len(recording.ticks), packets, "")


def _again(tick: dict[str, Any], recoder: Recoder, run: Mission) -> dict[str, Any]:
    """One tick's record, made anew from its raw bytes."""
    reading = recoder.read(tick["raw"])
    if "stopped" in tick:
        if tick["stopped"] in RETREATABLE:
            run.back_out(tick["stopped"])
        return {}
    if reading is None:
        return {"stage": "hold"}
    decision = run.decide(reading)
    record = seen(reading, decision)
    if decision.command is not None:
        sent = recoder.write(decision.command)
        record.update(sent=sent.positions, clamped=sent.clamped, packet=sent.packet)
    return record
