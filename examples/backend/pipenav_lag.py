"""A simulator without physics: joint speeds follow the command with a lag, walls are seen and never felt."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from pipenav.arrays import Floats, Ints
from pipenav.backends import CONTROL_PERIOD, BackendOptions, Command, Reading, Simulator, TooManyWalls, Truth
from pipenav.errors import PipenavError
from pipenav.pipes import Pipe
from pipenav.robots import RobotSpec, frames, kinematics, laser


class LagOptions(BackendOptions):
    """Settings of this backend, which `pipenav backends lag` lists."""

    time_constant: float = Field(0.05, gt=0, le=10, description="time constant of a change of speed [s]")


class LagBackend(Simulator):
    """n robots on mounts, each joint with a speed that approaches the commanded one exponentially."""

    Options = LagOptions

    def __init__(self, robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int = 4) -> None:
        assert isinstance(options, LagOptions)
        if robot.free:
            raise PipenavError(f"backend 'lag' knows no wheels: choose another robot than {robot.name!r}.")
        self._robot, self._slots = robot, wall_segments
        self._share = 1.0 - np.exp(-CONTROL_PERIOD / options.time_constant)  # of a change of speed, in one step
        self._q = np.zeros((n, len(robot.joints)))  # joint positions [rad or m]
        self._qd = np.zeros_like(self._q)
        self._time, self._base = np.zeros(n), np.zeros(n)
        self._segments = np.full((n, wall_segments, 2, 2), np.inf)

    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:
        for i, pipe in zip(indices, pipes, strict=True):
            count = len(pipe.segments)
            if count > self._slots:
                raise TooManyWalls(pipe, self._slots)
            self._segments[i] = pipe.segments[-1]  # also in the slots that are left over
            self._segments[i, :count] = pipe.segments
        self._q[indices], self._qd[indices], self._time[indices], self._base[indices] = q, 0.0, 0.0, base
        return self.read().part(indices)

    def step(self, command: Command) -> None:
        limit = self._robot.speed_limits
        error = command.values - self._q
        wanted = command.values * limit if command.control == "torque" else error / CONTROL_PERIOD
        speed = self._qd + self._share * (np.clip(wanted, -limit, limit) - self._qd)
        before, self._q = self._q, np.clip(self._q + speed * CONTROL_PERIOD, self._robot.lower, self._robot.upper)
        self._qd = (self._q - before) / CONTROL_PERIOD
        self._time += CONTROL_PERIOD

    def read(self) -> Reading:
        tip = self._tip()
        beams = tip[:, 2:] + self._robot.laser.angles  # (n, beams)
        ranges = laser.measure(self._robot.laser, laser.cast(tip[:, :2], beams, self._segments))
        return Reading(self._q.copy(), self._qd.copy(), ranges, self._time.copy())

    def truth(self) -> Truth:
        n = len(self._q)
        return Truth(self._tip(), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((n, len(self._robot.links), 2)))

    def close(self) -> None:
        pass

    def _tip(self) -> Floats:
        """Tip position and heading in the pipe's frame, (n, 3) [m, m, rad]."""
        pose = kinematics.forward(self._robot, self._q)
        return np.concatenate([frames.robot_to_pipe(pose.tip, self._base), pose.headings[:, -1:]], axis=1)
