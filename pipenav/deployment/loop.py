"""The control loop of the real arm: read, decide, send and wait, until the mission ends or something stops the arm."""

from __future__ import annotations

import contextlib
import gc
import itertools
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from pipenav.arrays import Floats
from pipenav.backends.messages import Reading
from pipenav.backends.real_robot import RealRobot
from pipenav.backends.safety import Stopped
from pipenav.deployment.stages import Decision
from pipenav.deployment.telemetry import Telemetry
from pipenav.errors import FileProblem

HOLD_PERIOD = 0.05
"""Period of the sign of life to the supervisor while the arm is held [s]."""

RETREATABLE = {"stall"}
"""Causes after which the arm may still be moved: bus, sensors and clock are well."""


class Decider(Protocol):
    """A mission as the loop sees it: it has a command for every reading.

    Attributes:
        outcome: how it ended; empty while it goes on.
    """

    outcome: str

    @property
    def target(self) -> Floats | None:
        """Target in the robot's own frame, (2,) [m]; None before one is known."""
        ...

    def decide(self, reading: Reading) -> Decision:
        """Decide what to do after a reading."""
        ...

    def back_out(self, why: str) -> bool:
        """Back out after a stop that allows it; False where the mission does not."""
        ...


def control_loop(
    arm: RealRobot,
    mission: Decider,
    telemetry: Telemetry,
    show: Callable[[dict[str, Any]], None],
    stop_file: Path,
    most_ticks: int | None = None,
) -> str:
    """Drive the arm until its mission has ended.

    Args:
        arm: the real robot, switched on by `reset`.
        mission: decides from every reading what to do.
        telemetry: gets the record of every tick.
        show: called with the record of every tick.
        stop_file: a file whose appearance is an emergency stop.
        most_ticks: number of ticks after which the loop ends; None for as many as the mission takes.

    Returns:
        The mission's outcome; `ended` after `most_ticks`.

    Raises:
        Stopped: whatever stopped the arm.
    """
    for tick in itertools.count() if most_ticks is None else range(most_ticks):
        decision = _recorded_tick(arm, mission, telemetry, show, tick)
        if decision is not None and decision.command is None:
            return mission.outcome
        if stop_file.exists():
            raise Stopped("e-stop", f"the file {stop_file} appeared", "remove it, then start again")
        gc.collect(1)
        arm.wait()
    return "ended"


def hold_until(arm: RealRobot, released: Callable[[], bool]) -> None:
    """Keep the arm where it is until someone holds it, for arms that would fall without torque.

    Whatever stopped it, a lost sensor for example, is no reason to let it fall.
    """
    while not released():
        arm.hold()
        time.sleep(HOLD_PERIOD)


def _recorded_tick(
    arm: RealRobot, mission: Decider, telemetry: Telemetry, show: Callable[[dict[str, Any]], None], tick: int
) -> Decision | None:
    """Carry out a tick, and record and show it; None where the arm holds.

    Raises:
        Stopped: whatever stopped the arm, unless it may be moved still and backs out.
    """
    record: dict[str, Any] = {"tick": tick}
    try:
        decision = _tick(arm, mission, record)
    except Stopped as stopped:
        with contextlib.suppress(FileProblem):  # it must not hide what stopped the arm
            telemetry.tick({**record, "raw": arm.raw(), "stopped": stopped.cause})
        if stopped.cause not in RETREATABLE or not mission.back_out(stopped.cause):
            raise
        arm.hold()
        return None
    telemetry.tick(record)
    show(record)
    return decision


def _tick(arm: RealRobot, mission: Decider, record: dict[str, Any]) -> Decision | None:
    """Read, decide, send; None where the reading was not whole and the arm holds."""
    reading = arm.read()
    if not arm.complete:
        arm.hold()
        record.update(stage="hold", raw=arm.raw())
        return None
    begun = time.perf_counter()
    decision = mission.decide(reading)
    decided = time.perf_counter() - begun
    record.update(decision_record(reading, decision))
    if decision.command is not None:
        sent = arm.send(decision.command)
        record.update(sent=sent.positions, clamped=sent.clamped, packet=sent.packet)
    record.update(raw=arm.raw(), warnings=arm.warnings)
    record["target"] = None if mission.target is None else mission.target.tolist()
    record["seconds"] = {**record["raw"]["seconds"], "decide": decided}
    return decision


def decision_record(reading: Reading, decision: Decision) -> dict[str, Any]:
    """The reading and the decision of a tick, as they go into the telemetry."""

    def numbers(values: Any) -> list[float] | None:
        return None if values is None else np.asarray(values, float).tolist()

    asked = {} if decision.asked is None else {"asked": decision.asked, "step": decision.step}
    return asked | {
        "stage": decision.stage,
        "q": numbers(reading.q[0]),
        "qd": numbers(reading.qd[0]),
        "ranges": numbers(reading.ranges[0]),
        "time": float(reading.time[0]),
        "observation": numbers(decision.observation),
        "action": numbers(decision.action),
        "command": None if decision.command is None else numbers(np.asarray(decision.command.values)[0]),
    }
