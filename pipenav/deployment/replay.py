"""A recorded mission once more, without its arm: the same bytes must give the same readings, actions and packets."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from pipenav.backends.real_robot import Recoder, load_real_robot
from pipenav.backends.safety import Stopped
from pipenav.deployment.loop import RETREATABLE, decision_record
from pipenav.deployment.mission import Mission, mission_of
from pipenav.deployment.plan import POLICY_COPY
from pipenav.deployment.telemetry import Recording, TelemetryFileError, read_telemetry
from pipenav.errors import PipenavError, shown
from pipenav.policies.policy import load_policy

COMPARED = ("stage", "q", "qd", "ranges", "time", "observation", "action", "command", "sent", "clamped", "packet")


class Replay(NamedTuple):
    """The result of a replay.

    Attributes:
        recording: the log that was replayed.
        ticks: number of ticks that were compared.
        packets: number of packets that were the same.
        difference: the first difference in words; empty where there is none.
    """

    recording: Recording
    ticks: int
    packets: int
    difference: str


def replay(path: Path) -> Replay:
    """Do a recorded mission's arithmetic again and compare every bit.

    Raises:
        TelemetryFileError, FileProblem, PolicyFileError: the log, or the policy beside it, cannot be used.
    """
    recording = read_telemetry(path)
    copy = path.with_name(POLICY_COPY)
    if not copy.exists():
        raise PipenavError(f"{path} has no {POLICY_COPY} beside it: replay it in the folder of its mission.")
    policy = load_policy(copy)
    try:
        header = recording.header
        recoder = load_real_robot(header["backend"]).recoder(policy.header.robot, header["machine"])
        mission = mission_of(policy, header["run"])
        return _compare(recording, recoder, mission)
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:  # of any part of a tick
        problem = f"lacks what a replay needs ({type(error).__name__}: {shown(error, quoted=False)})"
        raise TelemetryFileError(path, problem) from error


def _compare(recording: Recording, recoder: Recoder, mission: Mission) -> Replay:
    packets = 0
    for tick in recording.ticks:
        try:
            again = _again(tick, recoder, mission)
        except Stopped as stopped:
            again = {"stopped": stopped.cause}
        if "stopped" in tick:
            continue  # what stopped it may have been a signal, the clock or a servo: no arithmetic
        for key in COMPARED:
            if tick.get(key) != again.get(key):
                new, old = (shown(record.get(key), longest=300) for record in (again, tick))
                difference = f"tick {tick['tick']}: {key} is {new}, recorded {old}"
                return Replay(recording, tick["tick"], packets, difference)
        packets += bool(tick.get("packet"))
    return Replay(recording, len(recording.ticks), packets, "")


def _again(tick: dict[str, Any], recoder: Recoder, mission: Mission) -> dict[str, Any]:
    """The record of a tick, made anew from its raw bytes."""
    reading = recoder.read(tick["raw"])
    if "stopped" in tick:
        if tick["stopped"] in RETREATABLE:
            mission.back_out(tick["stopped"])
        return {}
    if reading is None:
        return {"stage": "hold"}
    decision = mission.decide(reading)
    record = decision_record(reading, decision)
    if decision.command is not None:
        sent = recoder.write(decision.command)
        record.update(sent=sent.positions, clamped=sent.clamped, packet=sent.packet)
    return record
