"""How an episode of the traverse task goes and ends, and what it is worth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Reading, Truth
from pipenav.backends.spatial import SpaceTruth
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome, decide
from pipenav.tasks.traverse.config import TraverseConfig, TraverseReward

AT_STOP = 0.01
"""A joint is at its stop within this share of its travel."""


class Facts(NamedTuple):
    """What the reward of one control step depends on, (n,) each.

    Attributes:
        progress: what the body's middle gained along the pipe [m].
        force: the step's peak contact force [N].
        penetration: the step's deepest overlap [m].
        passed: whether the tail is through.
        failed: whether the step ended the episode as a failure, being stuck among them; running out of time is none.
    """

    progress: Floats
    force: Floats
    penetration: Floats
    passed: Flags
    failed: Flags


class Judged(NamedTuple):
    """What one control step brought.

    Attributes:
        facts: what the reward depends on.
        outcome: an `Outcome` for each robot, (n,).
    """

    facts: Facts
    outcome: NDArray[np.int8]


def reward(config: TraverseReward, facts: Facts) -> Floats:
    """The sum of the terms, (n,)."""
    total = config.progress * facts.progress + config.passed * facts.passed + config.step
    total = total + config.force * facts.force + config.penetration * 1e3 * facts.penetration
    return np.asarray(np.where(facts.failed, config.failed, total))


class OutcomeTracker:
    """Follows n episodes and says how they end."""

    def __init__(self, robot: RobotSpec, config: TraverseConfig, n: int) -> None:
        self._robot, self._config = robot, config
        self._radii = np.array([wheel.radius for wheel in robot.wheels])
        self._middle, self._furthest = np.zeros(n), np.zeros(n)
        self._waited, self._rolled = np.zeros(n, int), np.zeros(n)

    def start(self, indices: Ints, along: Floats) -> None:
        """Some robots begin anew, their way points at `along` (k, points)."""
        self._middle[indices] = self._furthest[indices] = along.mean(axis=1)
        self._waited[indices], self._rolled[indices] = 0, 0.0

    def excuse(self, indices: Flags) -> None:
        """Count it as no delay that some robots, (n,), did not come on."""
        self._waited[indices], self._rolled[indices] = 0, 0.0

    def step(
        self,
        steps: Ints,
        limit: Ints,
        along: Floats,
        end: Floats,
        reading: Reading,
        truth: Truth | SpaceTruth,
    ) -> Judged:
        """Facts and outcome of one control step.

        Args:
            steps: control steps of each episode, (n,).
            limit: how many it may take, (n,).
            along: where the way points are along the pipe, the rear end's first, (n, points) [m].
            end: where the last corner ends, (n,) [m].
            reading: what the sensors give.
            truth: what the simulator knows.
        """
        config = self._config
        middle = along.mean(axis=1)
        progress, self._middle = middle - self._middle, middle
        advanced = middle >= self._furthest + config.advance
        self._furthest = np.where(advanced, middle, self._furthest)
        self._waited = np.where(advanced, 0, self._waited + 1)
        rims = np.abs(reading.wheel_speeds * self._radii).mean(axis=1) if len(self._radii) else 0.0
        self._rolled = np.where(advanced, 0.0, self._rolled + CONTROL_PERIOD * rims)

        sank = truth.penetration > config.max_penetration
        back = middle < self._furthest - config.slide_back * self._robot.length
        passed = (along[:, 0] >= end + config.through) & ~sank
        stuck = (self._waited >= config.patience) & ~passed
        holds = {Outcome.TIMEOUT: steps >= limit, Outcome.REACHED: passed}
        holds |= {reason: stuck & seen for reason, seen in self._why_stuck(along, reading).items()}
        outcome = decide(len(sank), holds | {Outcome.SLID_BACK: back, Outcome.PENETRATION: sank})
        facts = Facts(progress, truth.contact_force, truth.penetration, passed, sank | back | stuck)
        return Judged(facts, outcome)

    def _why_stuck(self, along: Floats, reading: Reading) -> dict[Outcome, Flags]:
        """Reasons why a robot does not come on, if it does not, each (n,)."""
        robot = self._robot
        spare = AT_STOP * (robot.upper - robot.lower)
        at_stop = np.asarray(((reading.q <= robot.lower + spare) | (reading.q >= robot.upper - spare)).any(axis=1))
        folded = along[:, -1] < along[:, along.shape[1] // 2]
        slips = self._rolled >= self._config.spin
        return {Outcome.JAM: ~slips, Outcome.SLIP: slips, Outcome.LIMIT: at_stop, Outcome.FOLD: folded}
