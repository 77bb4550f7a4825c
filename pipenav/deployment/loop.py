"""Driving one real arm: the loop of read, decide, send and wait, and the ways out of it, all ending torque-off."""

from __future__ import annotations

import contextlib
import gc
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

import numpy as np

from pipenav.backends.messages import Reading
from pipenav.backends.real_robot import RealRobot
from pipenav.backends.safety import Stopped
from pipenav.deployment.mission import Decision, Mission
from pipenav.deployment.telemetry import Telemetry

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1)
"""What stops the arm from outside; SIGUSR1 is the emergency stop for scripts and foot switches."""

HOLD_PERIOD = 0.05
"""How often a held arm's supervisor hears that someone is there [s]."""

RETREATABLE = {"stall"}
"""Causes after which the arm may still be moved: bus, sensors and clock are well."""


class Interrupted(Stopped):
    """A signal stopped the arm.

    Attributes:
        number: of the signal.
    """

    def __init__(self, number: int) -> None:
        self.number = number
        name = signal.Signals(number).name
        cause = "e-stop" if number == signal.SIGUSR1 else "signal"
        super().__init__(cause, f"{name} came", "torque is off; start again when the arm is free")


class Stoppable(Protocol):
    """What torque can be switched off of; see `RealRobot`."""

    def cut(self) -> None: ...

    def off(self) -> list[str]: ...


@contextlib.contextmanager
def guarded(machine: Stoppable) -> Iterator[None]:
    """Torque off at the end of this context, however it is left.

    A signal cuts torque inside its handler, before anything else can happen, and leaves the context by `Interrupted`;
    further signals cut once more and disturb nothing. A death without a handler is the supervisor process's business.

    Python's own garbage collection comes at any moment and takes longer the more there is to look through, half a tick
    after some thousand ticks: it waits until torque is off, and `drive` collects what is new between ticks.
    """
    stopping, collecting = False, gc.isenabled()
    gc.disable()

    def stop(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  # the signature of a handler
        nonlocal stopping
        machine.cut()
        if not stopping:
            stopping = True
            raise Interrupted(number)

    before = {number: signal.signal(number, stop) for number in SIGNALS}
    try:
        yield
    finally:
        stopping = True
        machine.off()
        for number, handler in before.items():
            signal.signal(number, handler)
        if collecting:
            gc.enable()


def drive(
    machine: RealRobot,
    run: Mission,
    telemetry: Telemetry,
    show: Callable[[dict[str, Any]], None],
    stop_file: Path,
    most_ticks: int | None = None,
) -> str:
    """Run to the end.

    Args:
        machine: switched on by `reset`.
        run: what to do.
        telemetry: gets every tick.
        show: called with every tick's record.
        stop_file: a file whose appearance is an emergency stop.
        most_ticks: end after so many; without it only the run's own end counts.

    Returns:
        The run's outcome.

    Raises:
        Stopped: whatever stopped the arm.
    """
    tick = 0
    while most_ticks is None or tick < most_ticks:
        record: dict[str, Any] = {"tick": tick}
        try:
            decision = _tick(machine, run, record)
        except Stopped as stopped:
            telemetry.tick({**record, "raw": machine.raw(), "stopped": stopped.cause})
            if stopped.cause not in RETREATABLE or not run.back_out(stopped.cause):
                raise
            machine.hold()
            decision = None
        else:
            telemetry.tick(record)
            show(record)
        if decision is not None and decision.command is None:
            return run.outcome
        if stop_file.exists():
            raise Stopped("e-stop", f"the file {stop_file} appeared", "remove it, then start again")
        gc.collect(1)
        machine.wait()
        tick += 1
    return "ended"


def hold_until(machine: RealRobot, released: Callable[[], bool]) -> None:
    """Keep the arm where it is, for arms that would fall without torque, until someone holds it.

    Whatever stopped it, a lost sensor for example, is no reason to let it fall.
    """
    while not released():
        machine.hold()
        time.sleep(HOLD_PERIOD)


def _tick(machine: RealRobot, run: Mission, record: dict[str, Any]) -> Decision | None:
    """Read, decide, send; None where the reading was not whole and the arm holds."""
    reading = machine.read()
    if not machine.complete:
        machine.hold()
        record.update(stage="hold", raw=machine.raw())
        return None
    begun = time.perf_counter()
    decision = run.decide(reading)
    decided = time.perf_counter() - begun
    record.update(seen(reading, decision))
    if decision.command is not None:
        sent = machine.send(decision.command)
        record.update(sent=sent.positions, clamped=sent.clamped, packet=sent.packet)
    record.update(raw=machine.raw(), warnings=machine.warnings)
    record["target"] = None if run.target is None else run.target.tolist()
    record["seconds"] = {**record["raw"]["seconds"], "decide": decided}
    return decision


def seen(reading: Reading, decision: Decision) -> dict[str, Any]:
    """What a tick read and decided, as it goes into the telemetry."""

    def numbers(values: Any) -> list[float] | None:
        return None if values is None else np.asarray(values, float).tolist()

    return {
        "stage": decision.stage,
        "q": numbers(reading.q[0]),
        "qd": numbers(reading.qd[0]),
        "ranges": numbers(reading.ranges[0]),
        "time": float(reading.time[0]),
        "observation": numbers(decision.observation),
        "action": numbers(decision.action),
        "command": None if decision.command is None else numbers(np.asarray(decision.command.values)[0]),
    }
