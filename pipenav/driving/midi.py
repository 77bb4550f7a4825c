"""MIDI faders as a device, with pick-up: a fader moves nothing until it has met its joint's position.

Where a fader stands is unknown until it is moved, so its first message must not move the joint to it.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterable, Mapping
from types import TracebackType
from typing import Any, Protocol, Self

from pipenav.driving.ask import POLICY, Ask, OperatorLost, Seen
from pipenav.driving.hands import Hands
from pipenav.driving.mapping import ANALOGUE, TAPS
from pipenav.errors import PipenavError
from pipenav.robots.robot import RobotSpec

TOP = 127
"""Largest value of a fader (MIDI 1.0)."""

MIDDLE = 64
"""Value of a fader in its middle: there a fader of a speed stands still."""

NEAR = 1.5
"""Distance from its joint's position within which a fader has met it [counts]."""

LOOK_EVERY = 0.5
"""Time between looks whether the port is still there [s]: rtmidi does not say when one goes."""

INSTALL = "MIDI needs the extra 'drive': pip install 'pipenav[drive]'."
"""Message where mido is missing."""


class MidiPort(Protocol):
    """A port that messages come from."""

    def messages(self) -> Iterable[Any]:
        """Messages that have come since the last time, as mido has them.

        Raises:
            OperatorLost: the port is gone.
        """
        ...

    def close(self) -> None:
        """Close the port; closing twice is harmless."""
        ...


class Faders:
    """Faders and notes of a MIDI panel; a context manager that closes its port.

    Args:
        mapping: action of each fader and note.
        robot: the robot.
        port: where the messages come from.
    """

    def __init__(self, mapping: Mapping[str, str], robot: RobotSpec, port: MidiPort) -> None:
        self._mapping, self._port = dict(mapping), port
        self._spans = {joint.name: (joint.lower, joint.upper) for joint in robot.joints}
        self._indices = {joint.name: i for i, joint in enumerate(robot.joints)}
        self._values: dict[str, int] = {}
        self._met: set[str] = set()
        self._hands = Hands()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._port.close()

    def ask(self, seen: Seen) -> Ask:
        if seen.who == POLICY:
            self._met.clear()  # the policy has moved the joints since: every fader must meet its joint anew
        tapped = []
        for message in self._port.messages():
            control = _control(message)
            action = self._mapping.get(control, "")
            if action in TAPS and message.velocity > 0:
                tapped.append(action)
            elif control.startswith("cc") and action:
                self._moved(action, message.value, seen)
        speeds = {a: (self._values[a] - MIDDLE) / MIDDLE for a in self._met if a in ANALOGUE}
        positions = {a: self._position(a) for a in self._met if a in self._spans}
        if "hand-back" in tapped:
            self._met.clear()
            speeds, positions = {}, {}
        return self._hands.ask(speeds, tapped, positions)

    def _moved(self, action: str, value: int, seen: Seen) -> None:
        """A fader was moved to a value: note whether it has met its joint, or stood still in its middle."""
        before = self._values.get(action)
        self._values[action] = value
        met = float(MIDDLE)
        if action in self._spans:
            low, high = self._spans[action]
            met = (float(seen.reading.q[0, self._indices[action]]) - low) / (high - low) * TOP
        passed = before is not None and min(before, value) <= met <= max(before, value)
        if passed or abs(value - met) <= NEAR:
            self._met.add(action)

    def _position(self, joint: str) -> float:
        low, high = self._spans[joint]
        return low + self._values[joint] / TOP * (high - low)


def open_port(name: str | None) -> MidiPort:
    """A MIDI port: by its name, or a raw MIDI device by its path; None for the first port that there is.

    Raises:
        PipenavError: there is no such port, or mido is not installed.
    """
    if name is not None and "/" in name:
        return RawPort(name)
    return NamedPort(name)


class RawPort:
    """A raw MIDI device, such as /dev/snd/midiC1D0, whose bytes are messages."""

    def __init__(self, path: str) -> None:
        self._parser, self._path = _mido().Parser(), path
        try:
            self._descriptor: int | None = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
        except OSError as error:
            raise PipenavError(
                f"MIDI device {path} cannot be opened ({error.strerror}): connect it, or name another with --device."
            ) from error

    def messages(self) -> Iterable[Any]:
        try:
            if self._descriptor is None:
                raise OperatorLost(f"MIDI device {self._path}")
            come = os.read(self._descriptor, 4096)
        except BlockingIOError:
            return []
        except OSError as error:
            raise OperatorLost(f"MIDI device {self._path}") from error
        if not come:
            raise OperatorLost(f"MIDI device {self._path}")
        self._parser.feed(come)
        return list(self._parser)

    def close(self) -> None:
        if self._descriptor is not None:
            with contextlib.suppress(OSError):
                os.close(self._descriptor)
        self._descriptor = None


class NamedPort:
    """A port of the system's MIDI, by its name."""

    def __init__(self, name: str | None, clock: Callable[[], float] = time.monotonic) -> None:
        self._mido, self._clock = _mido(), clock
        names = self._names()
        if not names:
            raise PipenavError("there is no MIDI port: connect a panel, or give --device a raw MIDI device's path.")
        if name is not None and name not in names:
            raise PipenavError(f"there is no MIDI port {name!r}: choose one of {', '.join(map(repr, names))}.")
        self._name = name or names[0]
        self._port = self._mido.open_input(self._name)
        self._looked = clock()

    def _names(self) -> list[str]:
        try:
            return list(self._mido.get_input_names())
        except Exception:  # rtmidi's own error where the system has no MIDI at all, and import errors
            return []

    def messages(self) -> Iterable[Any]:
        if self._clock() - self._looked > LOOK_EVERY:
            self._looked = self._clock()
            if self._name not in self._names():
                raise OperatorLost(f"MIDI port {self._name!r}")
        return list(self._port.iter_pending())

    def close(self) -> None:
        with contextlib.suppress(Exception):
            self._port.close()


def _control(message: Any) -> str:
    """Name of the control that a message came from, as mappings have it; empty for any other message."""
    if message.type == "control_change":
        return f"cc{message.control}"
    return f"note{message.note}" if message.type == "note_on" else ""


def _mido() -> Any:
    """The module mido.

    Raises:
        PipenavError: it is not installed.
    """
    try:
        import mido
    except ModuleNotFoundError as error:
        raise PipenavError(INSTALL) from error
    return mido
