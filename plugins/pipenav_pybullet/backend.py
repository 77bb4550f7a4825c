"""n robots on PyBullet: the backend, which distributes the work to processes and keeps their answers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from pydantic import Field, field_validator

from pipenav.arrays import Floats, Ints
from pipenav.backends import (
    CONTROL_PERIOD,
    BackendOptions,
    Command,
    Reading,
    Simulator,
    TooManyWalls,
    Truth,
    Variation,
    Windows,
    physics_steps,
    strongest,
)
from pipenav.pipes import Pipe
from pipenav.robots import RobotSpec, kinematics, laser
from pipenav_pybullet.crew import Crew
from pipenav_pybullet.world import Motion, Setting, shares


class PybulletOptions(BackendOptions):
    """Settings of the PyBullet backend."""

    timestep: float = Field(
        0.0025, ge=1e-4, le=0.0025, description="physics step [s]; must divide the control period; motors need it short"
    )
    processes: int = Field(0, ge=0, le=1024, description="processes that share the robots; 0 uses every core")
    solver_iterations: int = Field(
        50, ge=1, le=1000, description="iterations of the constraint solver in a physics step"
    )
    contact_erp: float = Field(0.2, ge=0, le=1, description="share of an overlap that a physics step undoes")

    @field_validator("timestep")
    @classmethod
    def _divides_the_control_period(cls, timestep: float) -> float:
        physics_steps(timestep)
        return timestep


class PybulletBackend(Simulator):
    """Simulator of n robots in the plane, see `pipenav.backends.Simulator`."""

    Options = PybulletOptions
    can_vary = can_pull = True

    def __init__(self, robot: RobotSpec, n: int, options: BackendOptions, wall_segments: int = 4) -> None:
        assert isinstance(options, PybulletOptions)
        self._robot, self._n, self._slots = robot, n, wall_segments
        substeps = physics_steps(options.timestep)
        setting = Setting(options.timestep, options.solver_iterations, options.contact_erp)
        self._windows = Windows(substeps, options.timestep)
        self._crew = Crew(robot, n, setting, options.processes)
        self._configuration = np.zeros((n, robot.coordinates))
        self._speeds, self._loads = np.zeros((2, n, len(robot.driven_actuators)))
        self._distances = np.full((n, robot.laser.beams), np.inf)
        self._base, self._time = np.zeros(n), np.zeros(n)
        self._depth, self._contact_share = np.zeros(n), np.zeros(n)
        self._link_forces = np.zeros((n, len(robot.links), 2))

    def reset(self, indices: Ints, pipes: Sequence[Pipe], q: Floats, base: Floats) -> Reading:
        for pipe in pipes:
            if len(pipe.segments) > self._slots:
                raise TooManyWalls(pipe, self._slots)
        bounds = self._crew.bounds
        orders = [
            (indices[rows] - first, [pipes[row] for row in rows], q[rows], base[rows]) if len(rows) else None
            for first, rows in zip(bounds, shares(indices, bounds), strict=False)
        ]
        answers = self._crew.ask("reset", orders)
        self._distances[indices] = np.concatenate([*answers, np.empty((0, self._robot.laser.beams))])
        self._configuration[indices], self._speeds[indices], self._loads[indices] = q, 0.0, 0.0
        self._base[indices], self._time[indices] = base, 0.0
        self._depth[indices], self._contact_share[indices], self._link_forces[indices] = 0.0, 0.0, 0.0
        return self.read().part(indices)

    def vary(self, indices: Ints, variation: Variation) -> None:
        bounds = self._crew.bounds
        orders = [
            (indices[rows] - first, variation.part(rows)) if len(rows) else None
            for first, rows in zip(bounds, shares(indices, bounds), strict=False)
        ]
        self._crew.ask("vary", orders)

    def pull(self, forces: Floats) -> None:
        self._crew.ask("pull", [(forces[first:last],) for first, last in pairwise(self._crew.bounds)])

    def step(self, command: Command) -> None:
        orders = [(command.control, command.values[first:last]) for first, last in pairwise(self._crew.bounds)]
        motions = self._crew.ask("step", orders)
        whole = Motion(*(np.concatenate(column) for column in zip(*motions, strict=True)))
        self._configuration, self._speeds, self._loads = whole.configuration, whole.speeds, whole.loads
        self._distances, self._depth, self._contact_share = whole.distances, whole.depth, whole.contact_share
        forces = whole.forces
        means = self._windows.means(forces.reshape(*forces.shape[:2], -1))
        self._link_forces = strongest(means.reshape(self._n, -1, *forces.shape[2:]))
        self._time = self._time + CONTROL_PERIOD

    def read(self) -> Reading:
        ranges = laser.measure(self._robot.laser, self._distances)
        joints = len(self._robot.joints)
        q, qd, wheels = self._configuration[:, -joints:], self._speeds[:, :joints], self._speeds[:, joints:]
        rolling = wheels.copy() if self._robot.wheels else None
        return Reading(q.copy(), qd.copy(), ranges, self._time.copy(), rolling, self._loads.copy())

    def truth(self) -> Truth:
        pose = kinematics.forward(self._robot, self._configuration)
        tip = np.concatenate([pose.tip, pose.headings[:, -1:]], axis=1)
        tip[:, 0] += self._base
        force = np.sqrt((self._link_forces**2).sum(axis=2)).max(axis=1)
        return Truth(tip, force, self._depth.copy(), self._contact_share.copy(), self._link_forces.copy())

    def close(self) -> None:
        self._crew.close()
