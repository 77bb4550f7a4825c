"""The terminal's keyboard, on a pseudo-terminal."""

from __future__ import annotations

import contextlib
import os
import pty
import termios
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipenav.backends.messages import Reading
from pipenav.driving.ask import NOTHING, OperatorLost, Seen
from pipenav.driving.keyboard import FIRST, NAMES, REPEATED, Keyboard, keys
from pipenav.errors import PipenavError

SEEN = Seen(0, Reading(np.zeros((1, 4)), np.zeros((1, 4)), np.zeros((1, 10)), np.zeros(1)))
MAPPING = {"q": "theta1+", "w": "theta1-", "up": "tip-forward", "a": "step-a", "p": "hand-back", "space": "stop"}


@contextmanager
def terminal() -> Iterator[tuple[int, int]]:
    ours, theirs = pty.openpty()
    try:
        yield ours, theirs
    finally:
        for descriptor in (ours, theirs):
            with contextlib.suppress(OSError):
                os.close(descriptor)


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def test_a_key_is_held_until_its_repetitions_stay_away() -> None:
    clock = Clock()
    with terminal() as (ours, theirs), Keyboard(MAPPING, theirs, clock) as keyboard:
        os.write(ours, b"q")
        assert keyboard.ask(SEEN).joints == {"theta1": 1.0}
        clock.now += FIRST - 0.01
        assert keyboard.ask(SEEN).active
        os.write(ours, b"q")
        assert keyboard.ask(SEEN).active
        clock.now += REPEATED + 0.01
        assert keyboard.ask(SEEN) == NOTHING


def test_two_keys_against_each_other_move_nothing() -> None:
    with terminal() as (ours, theirs), Keyboard(MAPPING, theirs, Clock()) as keyboard:
        os.write(ours, b"qw")
        assert keyboard.ask(SEEN).joints == {}


def test_arrow_keys_steer_and_steps_go_on_until_they_are_handed_back() -> None:
    clock = Clock()
    with terminal() as (ours, theirs), Keyboard(MAPPING, theirs, clock) as keyboard:
        os.write(ours, b"\x1b[A")
        assert keyboard.ask(SEEN).tip == (1.0, 0.0)
        clock.now += 10
        os.write(ours, b"a")
        first = keyboard.ask(SEEN)
        assert (first.step, first.active) == ("a", True)
        clock.now += 10
        assert keyboard.ask(SEEN).active
        os.write(ours, b"p")
        assert not keyboard.ask(SEEN).active


@pytest.mark.parametrize("ending", [None, RuntimeError("ours"), SystemExit(3), KeyboardInterrupt()])
def test_the_terminal_is_as_before_whatever_ends_it(ending: BaseException | None) -> None:
    with terminal() as (_, theirs):
        before = termios.tcgetattr(theirs)
        try:
            with Keyboard(MAPPING, theirs):
                assert termios.tcgetattr(theirs) != before
                if ending is not None:
                    raise ending
        except BaseException as raised:
            assert raised is ending
        assert termios.tcgetattr(theirs) == before


def test_what_is_no_terminal_is_refused() -> None:
    read, write = os.pipe()
    try:
        with pytest.raises(PipenavError, match="stdin is none"):
            Keyboard(MAPPING, read)
    finally:
        os.close(read)
        os.close(write)


def test_a_terminal_that_is_closed_is_lost() -> None:
    with terminal() as (ours, theirs), Keyboard(MAPPING, theirs) as keyboard:
        os.close(ours)
        with pytest.raises(OperatorLost, match="the terminal is gone"):
            keyboard.ask(SEEN)


@given(st.lists(st.sampled_from(sorted(set(NAMES) - {b"\x1b"})), max_size=8))
def test_keys_come_out_in_the_order_in_which_they_went_in(pressed: list[bytes]) -> None:
    assert keys(b"".join(pressed)) == [NAMES[key] for key in pressed]


@given(st.binary(max_size=200))
def test_no_bytes_are_too_strange(come: bytes) -> None:
    assert all(isinstance(key, str) for key in keys(come))
