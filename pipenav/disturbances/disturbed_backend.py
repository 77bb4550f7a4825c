"""A simulator whose robots differ from their description, whose commands come late and whose laser errs.

It wraps another simulator. That one changes friction, masses and motors (`Simulator.vary`); late commands and bad
readings are made here, in the same way for every simulator.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Simulator, Variation
from pipenav.backends.messages import Command, Reading
from pipenav.backends.refusals import CannotVary
from pipenav.backends.wrapper import WrappedSimulator
from pipenav.disturbances.disturbance import MAX_LATENCY, Disturbance
from pipenav.pipes.pipe import Pipe
from pipenav.robots import laser
from pipenav.robots.robot import RobotSpec


def disturbed(simulator: Simulator, robot: RobotSpec, n: int, disturbance: Disturbance, seed: int) -> Simulator:
    """Put a simulator under a disturbance; the simulator itself where the disturbance does nothing.

    Raises:
        CannotVary: the robots are to differ from their description, and the simulator cannot make them do so.
    """
    return DisturbedSimulator(simulator, robot, n, disturbance, seed) if disturbance.acts else simulator


class DisturbedSimulator(WrappedSimulator):
    """n robots of another simulator under a disturbance.

    The disturbances of an episode depend on the seed, on the start pose and on the pipe alone, because every robot
    draws from a generator of its own that is seeded by these. They depend neither on the number of robots nor on the
    others' motion. Each stage of a passage is an episode of its own.

    Before a late command arrives, a robot holds its start position, or its duty is zero.

    It draws the variation of its robots itself, and so cannot be varied.

    Args:
        inner: the simulator that is disturbed.
        robot: the robot.
        n: number of robots.
        disturbance: ranges from which each episode draws.
        seed: seed of all episodes.
    """

    def __init__(self, inner: Simulator, robot: RobotSpec, n: int, disturbance: Disturbance, seed: int) -> None:
        super().__init__(inner)
        self._robot, self._disturbance, self._seed = robot, disturbance, seed
        if disturbance.varies_robots and not inner.can_vary:
            raise CannotVary(inner)
        actuators, beams = len(robot.driven_actuators), robot.laser.beams
        self._generators = [np.random.default_rng(seed) for _ in range(n)]
        self._latency, self._age = np.zeros(n, int), np.zeros(n, int)
        self._commands = np.zeros((n, MAX_LATENCY + 1, actuators))  # the latest first
        self._start = np.zeros((n, actuators))  # set-points that hold the start pose, wheels standing
        self._noise, self._dropouts, self._missing = np.zeros(n), np.zeros(n), np.zeros((n, beams), bool)
        self._ranges = np.zeros((n, beams))

    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:
        d, spans = self._disturbance, []
        for row, i in enumerate(indices):
            rng = self._generators[i] = _generator(self._seed, pipes[row], q[row], base[row])
            spans.append(_variation(self._robot, d, rng))
            self._latency[i] = rng.integers(*d.latency, endpoint=True)
            self._noise[i], self._dropouts[i] = rng.uniform(*d.noise), rng.uniform(*d.dropouts)
            self._missing[i] = rng.random(self._robot.laser.beams) < rng.uniform(*d.missing)
        if d.varies_robots:
            self._inner.vary(indices, Variation(*map(np.array, zip(*spans, strict=True))))
        reading = self._inner.reset(indices, pipes, q, base)
        self._start[indices, : reading.q.shape[1]], self._age[indices] = reading.q, 0
        self._ranges[indices] = self._seen(indices, reading.ranges)
        return reading._replace(ranges=self._ranges[indices])

    def step(self, command: Command) -> None:
        self._commands = np.concatenate([command.values[:, None], self._commands[:, :-1]], axis=1)
        arrived = self._commands[np.arange(len(self._age)), self._latency]
        idle = self._start if command.control == "position" else np.zeros_like(self._start)
        waiting = (self._age < self._latency)[:, None]
        self._inner.step(Command(command.control, np.where(waiting, idle, arrived)))
        self._age += 1
        self._ranges = self._seen(np.arange(len(self._age)), self._inner.read().ranges)

    def read(self) -> Reading:
        return self._inner.read()._replace(ranges=self._ranges.copy())

    def _seen(self, indices: Ints, ranges: Floats) -> Floats:
        """Disturbed readings of some robots for the true ones (k, beams): noise, then missing beams, then dropouts."""
        sensor = self._robot.laser
        drawn = [
            (self._generators[i].normal(size=sensor.beams), self._generators[i].random(sensor.beams)) for i in indices
        ]
        normal, uniform = (np.array(column) for column in zip(*drawn, strict=True))
        noisy = laser.measure(sensor, ranges + self._noise[indices, None] * normal)
        seen = np.where(ranges < sensor.range_max, noisy, ranges)
        seen = np.where(self._missing[indices], sensor.range_max, seen)
        return np.where(uniform < self._dropouts[indices, None], sensor.range_min, seen)


def _generator(seed: int, pipe: Pipe, q: Floats, base: float) -> np.random.Generator:
    """Generator of random numbers for one episode."""
    corners = np.stack([pipe.interior_angles, pipe.turn_signs], axis=1)
    start = np.array([pipe.diameter, *corners.ravel(), base, *q], float)
    return np.random.default_rng([seed, *start.view(np.uint32).tolist()])


def _variation(robot: RobotSpec, d: Disturbance, rng: np.random.Generator) -> Variation:
    """Variation of one robot: arrays without the robots' axis."""
    links, actuators = len(robot.links), len(robot.driven_actuators)
    friction = np.asarray(rng.uniform(*d.friction))
    return Variation(
        friction, rng.uniform(*d.mass, links), rng.uniform(*d.strength, actuators), rng.uniform(*d.gain, actuators)
    )
