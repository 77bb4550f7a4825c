"""An arm on the emulator's process, for tests that drive one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from pipenav_hardware.backend import HardwareBackend
from pipenav_hardware.emulator.client import Emulator

from pipenav.backends.messages import Command
from pipenav.backends.registry import open_backend
from pipenav.robots.robot import load_robot

ROBOT = load_robot("basic")
PATIENCE = 4.0
"""Tests run on busy machines: their clocks' limits are wider, except where a limit is what is tested."""


@contextmanager
def driver(emulator: Emulator, **options: Any) -> Iterator[HardwareBackend]:
    settings = {"arm": str(emulator.arm_path), "patience": PATIENCE} | options
    machine = open_backend("hardware", ROBOT, 1, settings)
    assert isinstance(machine, HardwareBackend)
    try:
        yield machine
    finally:
        machine.close()


def switch_on(machine: HardwareBackend) -> np.ndarray:
    start = machine.read().q
    machine.reset(np.array([0]), [], start, np.zeros(1))
    return start


def tick(machine: HardwareBackend, target: np.ndarray, count: int = 1) -> None:
    for _ in range(count):
        machine.read()
        if machine.complete:
            machine.send(Command("position", target))
        else:
            machine.hold()
        machine.wait()
