"""Torque off, however the arm is left: at the end, by an error or by a signal."""

from __future__ import annotations

import contextlib
import gc
import signal
from collections.abc import Iterator
from types import FrameType

from pipenav.backends.real_robot import Stoppable
from pipenav.backends.safety import Stopped, TorqueUnconfirmed
from pipenav.errors import PipenavError

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1)
"""Signals that stop the arm from outside; SIGUSR1 is the emergency stop for scripts and foot switches."""


class StoppedBySignal(Stopped):
    """A signal stopped the arm.

    Attributes:
        number: number of the signal.
    """

    def __init__(self, number: int) -> None:
        self.number = number
        name = signal.Signals(number).name
        cause = "e-stop" if number == signal.SIGUSR1 else "signal"
        super().__init__(cause, f"{name} came", "start again when the arm is free")


@contextlib.contextmanager
def guarded(arm: Stoppable) -> Iterator[None]:
    """Torque off at the end of this context, however it is left.

    A signal cuts torque inside its handler, before anything else can happen, and leaves the context by
    `StoppedBySignal`; further signals cut once more and disturb nothing. A death without a handler is the supervisor
    process's business. The joints that did not confirm are named by whatever leaves this context.

    Python's own garbage collection comes at any moment and takes longer the more there is to look through, half a tick
    after some thousand ticks: it waits until torque is off, and `control_loop` collects what is new between ticks.

    Raises:
        Stopped: a signal came, or a joint did not confirm that its torque is off.
    """
    stopping, collecting = False, gc.isenabled()
    gc.disable()

    def stop(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  # the signature of a handler
        nonlocal stopping
        arm.cut()
        if not stopping:
            stopping = True
            raise StoppedBySignal(number)

    before = {number: signal.signal(number, stop) for number in SIGNALS}
    error: BaseException | None = None
    try:
        yield
    except BaseException as raised:
        error = raised
        raise
    finally:
        stopping = True
        unconfirmed = arm.off()
        for number, handler in before.items():
            signal.signal(number, handler)
        if collecting:
            gc.enable()
        if unconfirmed:
            _name(unconfirmed, error)


def _name(joints: list[str], error: BaseException | None) -> None:
    """Have the error that leaves the arm name the joints that did not confirm.

    Raises:
        TorqueUnconfirmed: there was no error, or one that is no stop.
    """
    if isinstance(error, Stopped):
        error.unconfirmed = joints
    elif error is None:
        raise TorqueUnconfirmed(joints)
    else:
        what = str(error).rstrip(".") if isinstance(error, PipenavError) else f"{type(error).__name__}: {error}"
        raise TorqueUnconfirmed(joints, what) from error
