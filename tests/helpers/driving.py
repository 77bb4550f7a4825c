"""Hands for tests of driving, and what the telemetry of an episode says about its commands."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipenav.deployment.telemetry import read_telemetry
from pipenav.driving.ask import NOTHING, PERSON, Ask, Seen
from pipenav.driving.slew import SlewLimits
from pipenav.driving.space_door import roll_limits
from pipenav.robots.robot import RobotSpec

CALM = 5
"""Least control steps between a hand-back and the next take-over."""


class RandomHands:
    """Takes over at random moments, moves something at random for a while, and hands back.

    Args:
        robot: the robot.
        seed: seed of all that is random.
        strength: largest speed that is asked for, as a share of the fastest.
        roll: whether the roll joint is moved too.
    """

    def __init__(self, robot: RobotSpec, seed: int, strength: float = 1.0, roll: bool = False) -> None:
        self._robot, self._rng, self._strength, self._rolls = robot, np.random.default_rng(seed), strength, roll
        self._left, self._wish = -CALM, NOTHING

    def ask(self, seen: Seen) -> Ask:  # noqa: ARG002  # the signature of an operator
        rng = self._rng
        self._left -= 1
        if self._left > 0:
            return self._wish
        if self._left <= -CALM and rng.random() < 0.2:
            self._left = int(rng.integers(1, 12))
            names = [joint.name for joint in self._robot.joints]
            s = self._strength
            moved = rng.choice(names, size=2, replace=False)
            joints = {str(name): float(rng.uniform(-s, s)) for name in moved}
            if self._rolls:
                assert self._robot.roll is not None
                joints[self._robot.roll.joint.name] = float(rng.uniform(-s, s))
            wheels = float(rng.uniform(-s, s)) if self._robot.wheels else 0.0
            self._wish = Ask(active=True, joints=joints, wheels=wheels)
            if not self._robot.free and rng.random() < 0.5:
                self._wish = Ask(active=True, tip=(float(rng.uniform(-s, s)), float(rng.uniform(-s, s))))
            return self._wish
        return NOTHING


class Changes(NamedTuple):
    """Changes of driver in an episode, and how far the commands went.

    Attributes:
        count: number of take-overs and of hand-backs, (2,).
        jump: largest change of a command, in the limit of a step.
        break_: largest change of a joint's commanded speed when the driver changes and while a person drives, in its
            limit.
    """

    count: tuple[int, int]
    jump: float
    break_: float


def changes(path: Path, robot: RobotSpec) -> Changes:
    """Changes of driver in an episode's telemetry."""
    ticks = [tick for tick in read_telemetry(path).ticks if tick.get("command")]
    limits, joints = SlewLimits.of(robot), len(robot.joints)
    commands = np.array([tick["command"] for tick in ticks])
    by_hand = np.array([tick["stage"] == PERSON for tick in ticks])
    steps = np.diff(commands, axis=0)
    step, change = limits.step, limits.change[:joints]
    if "roll_command" in ticks[0]:
        turning, turned = roll_limits(robot), np.diff([[tick["roll_command"]] for tick in ticks], axis=0)
        step, change = np.append(step, turning.step), np.append(change, turning.change)
        steps = np.concatenate([steps, turned], axis=1)
    changed = by_hand[1:] != by_hand[:-1]
    took, gave = int((changed & by_hand[1:]).sum() + by_hand[0]), int((changed & ~by_hand[1:]).sum())
    paces = np.concatenate([steps[:, :joints], steps[:, len(limits.step) :]], axis=1)
    broken = np.abs(np.diff(paces, axis=0)) / change
    watched = (changed | by_hand[1:])[1:]
    return Changes(
        (took, gave),
        float((np.abs(steps) / step).max(initial=0.0)),
        float(broken[watched].max(initial=0.0)),
    )
