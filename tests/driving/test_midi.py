"""MIDI faders, as bytes on the wire."""

from __future__ import annotations

import contextlib
import os
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipenav.backends.messages import Reading
from pipenav.driving.ask import PERSON, POLICY, OperatorLost, Seen
from pipenav.driving.midi import NEAR, TOP, Faders, open_port
from pipenav.errors import PipenavError
from pipenav.robots.robot import load_robot

pytest.importorskip("mido")

ROBOT = load_robot("basic")
MAPPING = {"cc0": "l", "cc1": "theta1", "note36": "hand-back", "note37": "stop"}


@contextmanager
def panel() -> Iterator[tuple[int, Faders]]:
    """A panel's wire, and the faders at its other end."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    with Faders(MAPPING, ROBOT, open_port(os.ttyname(theirs))) as faders:
        os.close(theirs)
        try:
            yield ours, faders
        finally:
            with contextlib.suppress(OSError):
                os.close(ours)


def seen(theta1: float, who: str = PERSON) -> Seen:
    q = np.array([[0.0, theta1, 0.0, 0.0]])
    return Seen(0, Reading(q, np.zeros((1, 4)), np.zeros((1, 10)), np.zeros(1)), who=who)


def counts(theta1: float) -> float:
    joint = ROBOT.joints[1]
    return (theta1 - joint.lower) / (joint.upper - joint.lower) * TOP


@settings(max_examples=40, deadline=None)
@given(theta1=st.floats(-2.3, 2.3), values=st.lists(st.integers(0, 127), min_size=1, max_size=12))
def test_a_fader_moves_nothing_until_it_has_met_its_joint(theta1: float, values: list[int]) -> None:
    joint, met, before = ROBOT.joints[1], False, None
    with panel() as (wire, faders):
        for value in values:
            os.write(wire, bytes([0xB0, 1, value]))
            asked = faders.ask(seen(theta1))
            at = counts(theta1)
            met = met or abs(value - at) <= NEAR
            met = met or (before is not None and min(before, value) <= at <= max(before, value))
            before = value
            expected = {"theta1": joint.lower + value / TOP * (joint.upper - joint.lower)} if met else {}
            assert asked.positions == pytest.approx(expected)
            assert asked.active == met


def test_after_a_policy_has_driven_every_fader_must_meet_its_joint_anew() -> None:
    with panel() as (wire, faders):
        os.write(wire, bytes([0xB0, 1, round(counts(0.0))]))
        assert faders.ask(seen(0.0)).active
        assert not faders.ask(seen(1.0, POLICY)).active


def test_a_message_may_come_in_pieces_and_notes_are_tapped() -> None:
    with panel() as (wire, faders):
        os.write(wire, bytes([0x90, 37]))
        assert not faders.ask(seen(0.0)).stop
        os.write(wire, bytes([100]))
        assert faders.ask(seen(0.0)).stop
        os.write(wire, bytes([0x90, 37, 0]))  # the note ends
        assert not faders.ask(seen(0.0)).stop


@given(noise=st.binary(max_size=64))
@settings(max_examples=40, deadline=None)
def test_no_bytes_are_too_strange(noise: bytes) -> None:
    with panel() as (wire, faders):
        os.write(wire, noise)
        faders.ask(seen(0.0))


def test_a_panel_that_vanishes_is_lost() -> None:
    with panel() as (wire, faders):
        os.close(wire)
        with pytest.raises(OperatorLost, match="is gone"):
            faders.ask(seen(0.0))


def test_a_device_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PipenavError, match="cannot be opened"):
        open_port(str(tmp_path / "none"))
