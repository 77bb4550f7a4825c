"""An arm on the emulator's process, for tests that drive one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from pipenav_hardware import servo_search
from pipenav_hardware.backend import HardwareBackend
from pipenav_hardware.emulator import byte_log
from pipenav_hardware.emulator.client import Emulator
from pipenav_hardware.emulator.faults import ONCE

from helpers.waiting import wait_until
from pipenav.arrays import Floats
from pipenav.backends.messages import Command
from pipenav.backends.registry import open_backend
from pipenav.robots.robot import load_robot

ROBOT = load_robot("basic")
PATIENCE = 4.0
"""Factor on the driver's time limits: tests run on busy machines, where an idle one keeps the true limits."""

CLOSE = 0.01
"""Largest distance of a joint from its target that counts as reached [rad or m]."""


def few_ids(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have a search for a missing servo ask for few ids at every speed: for all of them it takes most of a minute."""
    monkeypatch.setattr(servo_search, "ALL_IDS", range(12))


@contextmanager
def driver(emulator: Emulator, **options: Any) -> Iterator[HardwareBackend]:
    """The driver of an emulated arm, with wide time limits."""
    settings = {"arm": str(emulator.arm_path), "patience": PATIENCE, "allow_slow_bus": True} | options
    arm = open_backend("hardware", ROBOT, 1, settings)
    assert isinstance(arm, HardwareBackend)
    try:
        yield arm
    finally:
        arm.close()


def switch_on(arm: HardwareBackend) -> Floats:
    """Switch torque on where the arm is, and say where that is."""
    start = arm.read().q
    arm.reset(np.array([0]), [], start, np.zeros(1))
    return start


def tick(arm: HardwareBackend, target: Floats, count: int = 1) -> None:
    """Drive the arm towards a target for some ticks."""
    for _ in range(count):
        arm.read()
        if arm.complete:
            arm.send(Command("position", target))
        else:
            arm.hold()
        arm.wait()


def reach(arm: HardwareBackend, target: Floats, within: int = 60) -> None:
    """Drive the arm until it has reached a target, in at most so many ticks."""
    for _ in range(within):
        tick(arm, target)
        if arm.complete and np.abs(arm.read().q - target).max() < CLOSE:
            return
    raise AssertionError(f"the arm is not at its target after {within} ticks")


def strike(emulator: Emulator, **order: Any) -> None:
    """Order a fault and wait until it has struck."""

    def struck() -> int:
        return sum(record.get("event") == "fault" for record in byte_log.records(emulator.log_path))

    before = struck()
    emulator.order(**order)
    if order["fault"] in ONCE:
        wait_until(lambda: struck() > before, f"{order} strikes")
