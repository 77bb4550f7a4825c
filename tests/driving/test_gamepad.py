"""A gamepad, made of software inside SDL, which pygame itself cannot tell from a real one."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipenav.backends.messages import Reading
from pipenav.driving.ask import OperatorLost, Seen
from pipenav.driving.gamepad import DEAD, Gamepad
from pipenav.errors import PipenavError

SEEN = Seen(0, Reading(np.zeros((1, 4)), np.zeros((1, 4)), np.zeros((1, 10)), np.zeros(1)))
MAPPING = {"axis1-": "tip-along", "axis0-": "tip-left", "axis3": "theta1", "button0": "hand-back", "button1": "stop"}


class Stick:
    """A virtual gamepad of four axes and nine buttons."""

    def __init__(self, sdl: Any) -> None:
        self._sdl = sdl
        self._number = sdl.SDL_JoystickAttachVirtual(1, 4, 9, 0)
        assert self._number >= 0
        sdl.SDL_JoystickOpen.restype = ctypes.c_void_p
        self._handle = ctypes.c_void_p(sdl.SDL_JoystickOpen(self._number))

    def axis(self, number: int, share: float) -> None:
        self._sdl.SDL_JoystickSetVirtualAxis(self._handle, number, ctypes.c_int16(round(share * 32767)))

    def button(self, number: int, down: bool) -> None:
        self._sdl.SDL_JoystickSetVirtualButton(self._handle, number, int(down))

    def unplug(self) -> None:
        self._sdl.SDL_JoystickDetachVirtual(self._number)


@pytest.fixture
def stick(monkeypatch: pytest.MonkeyPatch) -> Iterator[Stick]:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    pygame = pytest.importorskip("pygame")
    libraries = list((Path(pygame.__file__).parent.parent / "pygame_ce.libs").glob("libSDL2-2*"))
    if not libraries:
        pytest.skip("pygame-ce is not from a wheel, which brings its own SDL")
    pygame.display.init()
    pygame.joystick.init()
    made = Stick(ctypes.CDLL(str(libraries[0])))
    try:
        yield made
    finally:
        made.unplug()
        pygame.joystick.quit()
        pygame.display.quit()


@pytest.mark.parametrize("share", [-1.0, -0.5, 0.25, 1.0])
def test_sticks_steer_as_far_as_they_are_pushed(stick: Stick, share: float) -> None:
    with Gamepad(MAPPING) as pad:
        stick.axis(1, -share)
        asked = pad.ask(SEEN)
        assert asked.tip == pytest.approx((share, 0.0), abs=1e-3)
        stick.axis(1, 0.0)
        stick.axis(3, share)
        assert pad.ask(SEEN).joints == pytest.approx({"theta1": share}, abs=1e-3)


def test_a_stick_near_its_middle_says_nothing(stick: Stick) -> None:
    with Gamepad(MAPPING) as pad:
        stick.axis(3, 0.9 * DEAD)
        assert not pad.ask(SEEN).active


def test_a_button_that_stays_down_is_tapped_once(stick: Stick) -> None:
    with Gamepad(MAPPING) as pad:
        stick.button(1, True)
        assert pad.ask(SEEN).stop
        assert not pad.ask(SEEN).stop


def test_a_gamepad_that_is_unplugged_is_lost(stick: Stick) -> None:
    with Gamepad(MAPPING) as pad:
        stick.unplug()
        with pytest.raises(OperatorLost, match="the gamepad is gone"):
            pad.ask(SEEN)


def test_no_gamepad_and_no_gamepad_of_that_name_are_refused(stick: Stick) -> None:
    with pytest.raises(PipenavError, match="no gamepad 'another'"):
        Gamepad(MAPPING, "another")
    stick.unplug()
    with pytest.raises(PipenavError, match="there is no gamepad"):
        Gamepad(MAPPING)
