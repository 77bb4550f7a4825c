"""Progress, outcome and reward of the traverse task."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Reading, Truth
from pipenav.backends.spatial import SpaceTruth
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.batch import Assessment
from pipenav.tasks.outcome import Outcome, strongest_outcome
from pipenav.tasks.traverse.config import TraverseConfig, TraverseReward

AT_STOP = 0.01
"""Share of a joint's travel within which it counts as at its stop."""


class StepFacts(NamedTuple):
    """Quantities that the reward of one control step depends on, (n,) each.

    Attributes:
        progress: distance along the pipe that the body's middle gained [m].
        force: peak contact force of the step [N].
        penetration: deepest overlap with the wall in the step [m].
        passed: whether the tail is through.
        failed: whether the step ended the episode as a failure; being stuck is a failure, running out of time is not.
    """

    progress: Floats
    force: Floats
    penetration: Floats
    passed: Flags
    failed: Flags


class Whereabouts(NamedTuple):
    """Places of n robots: of rear end, joints and tip, m points of each.

    Attributes:
        distances: distances along the pipe, (n, m) [m].
        in_branch: flags of the points in a branch that the route does not take, (n, m).
    """

    distances: Floats
    in_branch: Flags


def reward(config: TraverseReward, facts: StepFacts) -> Floats:
    """Sum of the reward's terms, (n,)."""
    total = config.progress * facts.progress + config.passed * facts.passed + config.step
    total = total + config.force * facts.force + config.penetration * 1e3 * facts.penetration
    return np.asarray(np.where(facts.failed, config.failed, total))


class OutcomeTracker:
    """Follows n episodes and decides how they end.

    Args:
        robot: the robot.
        config: limits of an episode.
        n: number of episodes.
    """

    def __init__(self, robot: RobotSpec, config: TraverseConfig, n: int) -> None:
        self._robot, self._config = robot, config
        self._radii = np.array([wheel.radius for wheel in robot.wheels])
        self._middle, self._furthest = np.zeros(n), np.zeros(n)
        self._waited, self._rolled = np.zeros(n, int), np.zeros(n)
        self._patience = np.zeros(n)

    def start(self, indices: Ints, distances: Floats, slowness: Floats) -> None:
        """Begin anew with some robots.

        Args:
            indices: which robots, (k,).
            distances: distances of their points along the pipe, (k, points) [m].
            slowness: factor on the patience with each, (k,).
        """
        self._patience[indices] = self._config.patience * slowness
        self._middle[indices] = self._furthest[indices] = distances.mean(axis=1)
        self._waited[indices], self._rolled[indices] = 0, 0.0

    def reset_patience(self, busy: Flags) -> None:
        """Count the steps without an advance from 0 again, for robots that are busy with something else.

        Args:
            busy: flags of the robots that are, (n,).
        """
        self._waited[busy], self._rolled[busy] = 0, 0.0

    def step(
        self,
        steps: Ints,
        limit: Floats,
        places: Whereabouts,
        end: Floats,
        reading: Reading,
        truth: Truth | SpaceTruth,
    ) -> Assessment[StepFacts]:
        """Facts and outcome of one control step.

        Args:
            steps: control steps of each episode, (n,).
            limit: largest number of control steps of each episode, (n,).
            places: where rear ends, joints and tips are.
            end: distance at which the last corner ends, (n,) [m].
            reading: readings of the sensors.
            truth: quantities that only the simulator knows.
        """
        config, distances = self._config, places.distances
        middle = distances.mean(axis=1)
        progress, self._middle = middle - self._middle, middle
        advanced = middle >= self._furthest + config.advance
        self._furthest = np.where(advanced, middle, self._furthest)
        self._waited = np.where(advanced, 0, self._waited + 1)
        rims = np.abs(reading.wheel_speeds * self._radii).mean(axis=1) if len(self._radii) else 0.0
        self._rolled = np.where(advanced, 0.0, self._rolled + CONTROL_PERIOD * rims)

        sank = truth.penetration > config.max_penetration
        back = middle < self._furthest - config.slide_back * self._robot.length
        passed = (distances[:, 0] >= end + config.through) & ~sank
        stuck = (self._waited >= self._patience) & ~passed
        holds = {Outcome.TIMEOUT: steps >= limit, Outcome.REACHED: passed}
        holds |= {reason: stuck & seen for reason, seen in self._why_stuck(distances, reading).items()}
        astray = places.in_branch[:, distances.shape[1] // 2] | (stuck & places.in_branch[:, -1])
        holds |= {Outcome.SLID_BACK: back, Outcome.WRONG_EXIT: astray, Outcome.PENETRATION: sank}
        outcome = strongest_outcome(len(sank), holds)
        failed = sank | back | stuck | astray
        facts = StepFacts(progress, truth.contact_force, truth.penetration, passed & ~failed, failed)
        return Assessment(facts, outcome)

    def _why_stuck(self, distances: Floats, reading: Reading) -> dict[Outcome, Flags]:
        """Reasons why a robot that is stuck does not advance, (n,) each."""
        robot = self._robot
        spare = AT_STOP * (robot.upper - robot.lower)
        at_stop = np.asarray(((reading.q <= robot.lower + spare) | (reading.q >= robot.upper - spare)).any(axis=1))
        folded = distances[:, -1] < distances[:, distances.shape[1] // 2]
        slips = self._rolled >= self._config.spin
        return {Outcome.JAM: ~slips, Outcome.SLIP: slips, Outcome.LIMIT: at_stop, Outcome.FOLD: folded}
