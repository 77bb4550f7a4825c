"""A simulator without physics, for tests and examples of everything that is built on backends."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import CONTROL_PERIOD, BackendOptions, Simulator
from pipenav.backends.messages import Command, Reading, Truth
from pipenav.backends.refusals import TooManyWalls
from pipenav.pipes.pipe import Pipe
from pipenav.robots import kinematics, laser
from pipenav.robots.robot import RobotSpec


class KinematicOptions(BackendOptions):
    """Settings of the simulator without physics."""

    speed_share: float = Field(1.0, gt=0, le=1, description="share of the no-load speed that joints reach at full duty")


class KinematicBackend(Simulator):
    """Joints follow the command at once, up to their speed limit; walls are seen and never felt. Deterministic."""

    Options = KinematicOptions

    def __init__(self, robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int = 4) -> None:
        assert isinstance(options, KinematicOptions)
        self._robot = robot
        self._reach = options.speed_share * robot.speed_limits * CONTROL_PERIOD  # farthest in one step, (joints,)
        self._q = np.zeros((n, len(robot.joints)))
        self._qd = np.zeros_like(self._q)
        self._time, self._base = np.zeros(n), np.zeros(n)
        self._segments = np.full((n, wall_segments, 2, 2), np.inf)

    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:
        slots = self._segments.shape[1]
        for i, pipe in zip(indices, pipes, strict=True):
            count = len(pipe.segments)
            if count > slots:
                raise TooManyWalls(pipe, slots)
            self._segments[i] = pipe.segments[-1]  # repeated in the slots that are left over
            self._segments[i, :count] = pipe.segments
        self._q[indices], self._qd[indices], self._time[indices], self._base[indices] = q, 0.0, 0.0, base
        return self.read().part(indices)

    def step(self, command: Command) -> None:
        if command.control == "torque":
            change = np.clip(command.values, -1.0, 1.0) * self._reach
        else:
            change = np.clip(command.values - self._q, -self._reach, self._reach)
        before, self._q = self._q, np.clip(self._q + change, self._robot.lower, self._robot.upper)
        self._qd = (self._q - before) / CONTROL_PERIOD
        self._time += CONTROL_PERIOD

    def read(self) -> Reading:
        tip = self._tip()
        beams = tip[:, 2:] + self._robot.laser.angles
        ranges = laser.measure(self._robot.laser, laser.cast(tip[:, :2], beams, self._segments))
        return Reading(self._q.copy(), self._qd.copy(), ranges, self._time.copy())

    def truth(self) -> Truth:
        n = len(self._q)
        return Truth(self._tip(), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((n, len(self._robot.links), 2)))

    def close(self) -> None:
        pass

    def _tip(self) -> Floats:
        pose = kinematics.forward(self._robot, self._q)
        return np.concatenate([pose.tip + np.stack([self._base, 0 * self._base], 1), pose.headings[:, -1:]], axis=1)
