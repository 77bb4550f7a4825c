"""A simulator in space without physics, for tests of the laws of robots in space."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import CONTROL_PERIOD
from pipenav.backends.messages import Reading
from pipenav.backends.spatial import HALVES, SpaceBackend, SpaceReading, SpaceTruth
from pipenav.pipes.route import PipeRoute
from pipenav.robots import space_kinematics
from pipenav.robots.robot import BASE, RobotSpec


class KinematicSpace(SpaceBackend):
    """Joints follow the command at once, up to their speed limit; the first link stays, and walls do nothing."""

    def __init__(self, robot: RobotSpec, n: int) -> None:
        self._robot = robot
        self._q, self._roll, self._base = np.zeros((n, len(robot.joints))), np.zeros(n), np.zeros((n, 7))
        self._base[:, 3] = 1.0
        self._qd, self._wheels = np.zeros_like(self._q), np.zeros((n, len(robot.wheels)))
        self._gravity, self._time = np.zeros((n, 3)), np.zeros(n)

    def incline(self, indices: Ints, gravity: Floats) -> None:
        self._gravity[indices] = gravity

    def pull(self, forces: Floats) -> None:
        """Nothing moves by forces here."""

    def reset(
        self,
        indices: Ints,
        routes: Sequence[PipeRoute],  # noqa: ARG002  # walls do nothing here
        q: Floats,
        base: Floats,
        plane: Floats,
    ) -> SpaceReading:
        for values in (self._qd, self._wheels, self._roll, self._time):
            values[indices] = 0.0
        self._q[indices] = q[:, len(BASE) :]
        self._base[indices] = space_kinematics.placed(q, base, plane)
        return self._reading(indices)

    def step(self, set_points: Floats, roll: Floats) -> None:
        joints = self._q.shape[1]
        reach = self._robot.speed_limits * CONTROL_PERIOD
        before = self._q
        self._q = np.clip(before + np.clip(set_points[:, :joints] - before, -reach, reach), *self._travel)
        self._qd, self._wheels = (self._q - before) / CONTROL_PERIOD, set_points[:, joints:].copy()
        self._roll, self._time = roll.copy(), self._time + CONTROL_PERIOD

    @property
    def _travel(self) -> tuple[Floats, Floats]:
        return self._robot.lower, self._robot.upper

    def read(self) -> SpaceReading:
        return self._reading(np.arange(len(self._q)))

    def _reading(self, indices: Ints) -> SpaceReading:
        k, beams, actuators = len(indices), self._robot.laser.beams, len(self._robot.driven_actuators)
        near, loads = np.full((k, beams), self._robot.laser.range_min), np.zeros((k, actuators))
        motion = self._q[indices], self._qd[indices], near, self._time[indices], self._wheels[indices], loads
        weight = self._gravity[indices]
        down = weight / np.maximum(np.linalg.norm(weight, axis=1, keepdims=True), 1e-9)
        in_halves = (down[:, None, None] @ self._pose().halves[indices])[:, :, 0]
        return SpaceReading(Reading(*motion), self._roll[indices], in_halves, np.zeros((k, HALVES, 3)))

    def _pose(self) -> space_kinematics.SpacePose:
        return space_kinematics.forward(self._robot, self._base, self._q, self._roll)

    def truth(self) -> SpaceTruth:
        n, links, pose = len(self._q), len(self._robot.links), self._pose()
        force, depth, share = np.zeros((3, n))
        return SpaceTruth(pose.points, pose.halves[..., 2], force, depth, share, np.zeros((n, links, 3)))

    def close(self) -> None:
        pass
