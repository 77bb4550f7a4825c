"""A gamepad as a device, by pygame-ce."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from types import TracebackType
from typing import Any, Self

from pipenav.driving.ask import Ask, OperatorLost, Seen
from pipenav.driving.hands import Hands
from pipenav.driving.mapping import TAPS
from pipenav.errors import PipenavError

DEAD = 0.12
"""Share of a stick's travel in its middle that says nothing: worn sticks rest off their middle."""

INSTALL = "a gamepad needs the extra 'drive': pip install 'pipenav[drive]'."
"""Message where pygame is missing."""


class Gamepad:
    """Sticks and buttons of a gamepad; a context manager that lets go of it.

    Args:
        mapping: action of each axis and button.
        name: name of the gamepad, or its number from 0; None for the first one.

    Raises:
        PipenavError: pygame is not installed, there is no such gamepad, or it lacks a control of the mapping.
    """

    def __init__(self, mapping: Mapping[str, str], name: str | None = None) -> None:
        os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # sticks without a window
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
        try:
            import pygame
        except ModuleNotFoundError as error:
            raise PipenavError(INSTALL) from error
        self._pygame: Any = pygame
        pygame.display.init()
        pygame.joystick.init()
        self._stick = self._found(name)
        self._mapping = {control: action for control, action in mapping.items() if self._has(control)}
        self._hands, self._down = Hands(), set[str]()

    def _found(self, name: str | None) -> Any:
        """The gamepad, opened.

        Raises:
            PipenavError: there is none, or none of that name.
        """
        joystick = self._pygame.joystick
        sticks = [joystick.Joystick(i) for i in range(joystick.get_count())]
        if not sticks:
            raise PipenavError("there is no gamepad: connect one, or choose --input keyboard.")
        if name is None:
            return sticks[0]
        for i, stick in enumerate(sticks):
            if name in (stick.get_name(), str(i)):
                return stick
        names = ", ".join(repr(stick.get_name()) for stick in sticks)
        raise PipenavError(f"there is no gamepad {name!r}: choose one of {names}.")

    def _has(self, control: str) -> bool:
        """Whether the gamepad has a control: the shipped mapping is for large ones."""
        number = int(control.strip("-").removeprefix("axis").removeprefix("button"))
        count = self._stick.get_numaxes() if control.startswith("axis") else self._stick.get_numbuttons()
        return bool(number < count)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with contextlib.suppress(Exception):
            self._stick.quit()
        self._pygame.joystick.quit()
        self._pygame.display.quit()

    def ask(self, seen: Seen) -> Ask:  # noqa: ARG002  # the signature of an operator
        for event in self._pygame.event.get():
            gone = event.type == self._pygame.JOYDEVICEREMOVED
            if gone and event.instance_id == self._stick.get_instance_id():
                raise OperatorLost("the gamepad")
        held: dict[str, float] = {}
        tapped = []
        down = set()
        for control, action in self._mapping.items():
            number = int(control.strip("-").removeprefix("axis").removeprefix("button"))
            if control.startswith("axis"):
                share = float(self._stick.get_axis(number))
                share = 0.0 if abs(share) < DEAD else share
                held[action] = -share if control.endswith("-") else share
            elif self._stick.get_button(number):
                down.add(action)
                if action in TAPS and action not in self._down:
                    tapped.append(action)
                elif action not in TAPS:
                    held[action] = 1.0
        self._down = down
        return self._hands.ask(held, tapped, {})
