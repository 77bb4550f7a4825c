"""Ctrl-C, SIGTERM and SIGHUP: answered at once, as an interrupt or as a request to save and stop."""

from __future__ import annotations

import contextlib
import os
import signal
import stat
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that ask a command to end."""

PATIENCE_S = 4.0
"""Time in which an interrupted command ends by itself [s]: one with nothing to save is then ended."""


class Interrupted(BaseException):
    """A signal ended the command; not an `Exception`, so that nothing on the way takes it for an error.

    Attributes:
        number: number of the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(f"{signal.Signals(number).name} came")
        self.number = number


class StopRequest:
    """The question whether a signal has asked to stop, which long work asks now and then.

    Attributes:
        number: number of the signal; 0 while there was none.
        heeded: whether the work has begun to ask, and will save.
    """

    def __init__(self) -> None:
        self.number = 0
        self.heeded = False

    def __call__(self) -> bool:
        self.heeded = True
        return self.number != 0

    @property
    def exit_code(self) -> int:
        """Exit code of a command that a signal ended."""
        return 128 + self.number


@contextmanager
def interrupts() -> Iterator[None]:
    """Turn signals into `Interrupted`, and end the process where that is not enough."""
    endings: list[threading.Timer] = []
    seen: list[int] = []

    def interrupt(number: int, _frame: object) -> None:
        seen.append(number)
        if not endings:
            _answer(number, "stopping ...")
            endings.append(threading.Timer(PATIENCE_S, os._exit, [128 + number]))
            endings[0].daemon = True
            endings[0].start()
        raise Interrupted(number)

    try:
        with _handled_by(interrupt):
            yield
    except (Exception, SystemExit) as error:
        if seen:  # libraries that were interrupted in C raise errors of their own
            raise Interrupted(seen[0]) from error
        raise
    finally:
        for ending in endings:
            ending.cancel()


@contextmanager
def stop_signals() -> Iterator[StopRequest]:
    """Turn signals into a request, which long work asks for now and then to save and end.

    Until it asks for the first time it has nothing to save: a signal is then an interrupt as for any command.
    """
    interrupt = signal.getsignal(signal.SIGINT)
    request = StopRequest()

    def note(number: int, _frame: object) -> None:
        if not request.heeded and callable(interrupt):
            interrupt(number, None)
        elif not request.number:
            request.number = number
            _answer(number, "stopping, saving ...")
        elif number == signal.SIGINT:
            raise Interrupted(number)  # a second Ctrl-C does not wait for the saving

    with _handled_by(note):
        yield request


@contextmanager
def _handled_by(handler: Callable[[int, object], None]) -> Iterator[None]:
    """Handle the signals for a while, except a SIGHUP that is ignored, as under nohup; only the main thread can."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    wanted = [n for n in STOPPING if not (n == signal.SIGHUP and signal.getsignal(n) == signal.SIG_IGN)]
    before = {number: signal.signal(number, handler) for number in wanted}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


def _answer(number: int, text: str) -> None:
    """Write a line at once, past every lock and buffer."""
    if number == signal.SIGHUP:
        _leave_terminal()
        return
    with contextlib.suppress(OSError):
        line = f"\n{text}\n" if os.isatty(2) else f"{text}\n"  # a progress bar may stand in the terminal's line
        os.write(2, line.encode())


def _leave_terminal() -> None:
    """Let go of a terminal that was closed, so that what is written still is no error."""
    for descriptor in (0, 1, 2):
        with contextlib.suppress(OSError):
            if stat.S_ISCHR(os.fstat(descriptor).st_mode):
                nowhere = os.open(os.devnull, os.O_RDWR)
                os.dup2(nowhere, descriptor)
                os.close(nowhere)
