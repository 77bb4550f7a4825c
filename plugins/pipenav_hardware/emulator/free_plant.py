"""Shafts on their own, without an arm."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pipenav.arrays import Floats
from pipenav_hardware.emulator.plant import NOLOAD_SPEED, SLOPE, Plant, ServoCommand, Shaft
from pipenav_hardware.table import COUNT, DIRECTION, SPEED_UNIT

TURN = 2 * np.pi / COUNT
"""Length of a whole turn [counts]; the servo measures the first 1023 of them."""


class _Pull(NamedTuple):
    """Position to which a motor pulls its shaft [counts], and its largest speed [counts/s]."""

    goal: float
    fastest: float


class FreePlant(Plant):
    """Shafts that nothing holds but their own stops; a stuck shaft withstands its motor."""

    def __init__(self, count: int, seed: int = 0) -> None:
        self._position = np.full(count, 511.5)
        self._commands = [ServoCommand(512, 0, 0.0)] * count
        self._speed, self._load, self._now = np.zeros(count), np.zeros(count), 0.0
        self.stuck: set[int] = set()
        self._rng = np.random.default_rng(seed)

    def place(self, positions: Sequence[float]) -> None:
        """Turn the shafts by hand."""
        self._position[:] = positions

    def command(self, now: float, commands: Sequence[ServoCommand]) -> None:
        self._advance(now)
        self._commands = list(commands)

    def shafts(self, now: float) -> list[Shaft]:
        self._advance(now)
        seen = [self._reading(i) for i in range(len(self._position))]
        return [Shaft(p, float(v), float(f)) for p, v, f in zip(seen, self._speed, self._load, strict=True)]

    def distances(self, now: float, angles: Floats) -> Floats:  # noqa: ARG002  # the same at any time
        """A room: walls 0.2 m to the sides, 0.4 m ahead."""
        return np.asarray(
            np.minimum(0.2 / np.maximum(np.abs(np.sin(angles)), 1e-9), 0.4 / np.maximum(np.cos(angles), 1e-9))
        )

    def _advance(self, now: float) -> None:
        """Move the shafts until now."""
        dt, self._now = max(now - self._now, 0.0) if self._now else 0.0, now
        for i, command in enumerate(self._commands):
            pull = _pull(command, self._position[i])
            error, most = pull.goal - self._position[i], pull.fastest * dt
            moved = 0.0 if i in self.stuck or not command.torque_share else float(np.clip(error, -most, most))
            self._position[i] += moved
            self._speed[i] = moved * COUNT / dt if dt else 0.0
            self._load[i] = np.clip((pull.goal - self._position[i]) / SLOPE, -1, 1) * command.torque_share
            if not command.wheel:
                self._position[i] = np.clip(self._position[i], 0, 1023)

    def _reading(self, i: int) -> float:
        """Position that a servo reads [counts]: in the 60 deg that it cannot measure, anything."""
        around = float(self._position[i] % TURN)
        return around if around <= 1023 else float(self._rng.integers(0, 1024))


def _pull(command: ServoCommand, position: float) -> _Pull:
    """The pull of a motor whose shaft is at a position [counts]."""
    if command.wheel:
        output = (command.speed & (DIRECTION - 1)) / 1023
        return _Pull(position + (-1e6 if command.speed & DIRECTION else 1e6), output * NOLOAD_SPEED / COUNT)
    asked = command.speed * SPEED_UNIT if command.speed else NOLOAD_SPEED  # 0: no speed control at all
    return _Pull(command.goal_counts, min(asked, NOLOAD_SPEED * max(command.torque_share, 1e-9)) / COUNT)
