"""The terminal's keyboard as a device: a terminal tells of keys that go down, never of keys that come up.

So a key counts as held until its repetitions stay away: for a moment after the first press, which a terminal repeats
only after a while, and for less after each repetition.
"""

from __future__ import annotations

import contextlib
import os
import select
import termios
import time
import tty
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import Any, Self

from pipenav.driving.ask import Ask, OperatorLost, Seen
from pipenav.driving.hands import Hands
from pipenav.driving.mapping import TAPS
from pipenav.errors import PipenavError

FIRST, REPEATED = 0.55, 0.25
"""Time for which a key counts as held after its first press, and after a repetition [s]: terminals begin to repeat
after 0.25 to 0.5 s, and then repeat 20 to 30 times a second."""

NAMES = {
    b"\x1b[A": "up",
    b"\x1b[B": "down",
    b"\x1b[C": "right",
    b"\x1b[D": "left",
    b"\x1bOA": "up",
    b"\x1bOB": "down",
    b"\x1bOC": "right",
    b"\x1bOD": "left",
    b" ": "space",
    b"\r": "enter",
    b"\n": "enter",
    b"\t": "tab",
    b"\x1b": "esc",
    b"\x7f": "backspace",
    b"\x08": "backspace",
}
"""Names of keys that are no letters, by the bytes that a terminal sends (ECMA-48, and DEC's application keys)."""


class Keyboard:
    """Keys of a terminal, one at a time from its own mode in which they come at once; a context manager.

    Args:
        mapping: action of each key.
        descriptor: the terminal's file descriptor.
        clock: gives the time [s].

    Raises:
        PipenavError: the descriptor is no terminal.
    """

    def __init__(
        self, mapping: Mapping[str, str], descriptor: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        if not os.isatty(descriptor):
            raise PipenavError(
                "the keyboard is read from a terminal, and stdin is none: run this in a terminal, or choose --input "
                "gamepad or midi, or --operator scripted."
            )
        self._mapping, self._descriptor, self._clock = dict(mapping), descriptor, clock
        self._until: dict[str, float] = {}
        self._hands = Hands()
        self._before: list[Any] | None = None

    def __enter__(self) -> Self:
        self._before = termios.tcgetattr(self._descriptor)
        tty.setcbreak(self._descriptor)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._before is not None:
            with contextlib.suppress(OSError, termios.error):  # the terminal may be gone
                termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._before)

    def ask(self, seen: Seen) -> Ask:  # noqa: ARG002  # the signature of an operator
        now, tapped = self._clock(), []
        for key in keys(self._read()):
            action = self._mapping.get(key)
            if action is None:
                continue
            if action in TAPS:
                tapped.append(action)
            else:
                again = self._until.get(action, 0.0) > now
                self._until[action] = now + (REPEATED if again else FIRST)
        self._until = {action: until for action, until in self._until.items() if until > now}
        return self._hands.ask(dict.fromkeys(self._until, 1.0), tapped, {})

    def _read(self) -> bytes:
        """All bytes that have come since the last time.

        Raises:
            OperatorLost: the terminal was closed.
        """
        try:
            if not select.select([self._descriptor], [], [], 0)[0]:
                return b""
            come = os.read(self._descriptor, 1024)
        except (OSError, ValueError):
            come = b""
        if not come:
            raise OperatorLost("the terminal")
        return come


def keys(come: bytes) -> list[str]:
    """Names of the keys in the bytes of a terminal, in order; unknown sequences are left out."""
    names, at = [], 0
    while at < len(come):
        for length in (3, 1):
            name = NAMES.get(come[at : at + length])
            if name is not None:
                names.append(name)
                at += length
                break
        else:
            letter = come[at : at + 1]
            if b"!" <= letter <= b"~":
                names.append(letter.decode("ascii"))
            at += 1
    return names
