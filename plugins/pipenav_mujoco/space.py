"""n robots in space on MuJoCo, each in the walls of its own route; beams once a control step."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends import HALVES, Reading, SpaceBackend, SpaceReading, SpaceTruth, Windows, strongest
from pipenav.pipes import PipeRoute
from pipenav.robots import BASE, RobotSpec, laser, space_kinematics
from pipenav_mujoco.space_batch import SpaceBatch, SpaceSettings
from pipenav_mujoco.space_walls import WALL_GROUP
from pipenav_mujoco.viewer import ASLANT, Marks, MujocoViewer

CLEAR = [0.7, 0.72, 0.75, 0.25]
"""Colour of walls in the viewer: red, green, blue, opacity."""

MAX_POSITION = 1e10
"""Coordinate up to which a robot's place is known [m]; MuJoCo stops a simulation beyond it (mjMAXVAL)."""


class MujocoSpace(SpaceBackend):
    """Simulator of n robots in routes in space, see `pipenav.backends.SpaceBackend`."""

    def __init__(self, robot: RobotSpec, n: int, settings: SpaceSettings) -> None:
        assert robot.roll is not None
        self._robot, self._n, self._settings = robot, n, settings
        self._batch = SpaceBatch(robot, n, settings)
        links = [link.name for link in robot.links]
        self._divided = links.index(robot.roll.link)
        self._bearing = [i for i, link in enumerate(robot.links) if link.wheel]
        self._windows = Windows(settings.substeps, settings.timestep)
        self._gravity, self._turned = np.zeros((n, 3)), np.zeros((n, HALVES, 3))
        self._loads, self._ranges = np.zeros((n, len(robot.driven_actuators))), np.zeros((n, robot.laser.beams))
        self._depth, self._contact_share, self._link_forces = np.zeros(n), np.zeros(n), np.zeros((n, len(links), 3))
        self._pose: space_kinematics.SpacePose | None = None
        self._moved = False

    def incline(self, indices: Ints, gravity: Floats) -> None:
        self._gravity[indices] = gravity

    def reset(self, indices: Ints, routes: Sequence[PipeRoute], q: Floats, base: Floats, plane: Floats) -> SpaceReading:
        self._sense()
        self._batch.put(indices, routes)
        for values in (self._loads, self._turned, self._depth, self._contact_share, self._link_forces):
            values[indices] = 0.0
        views = self._batch.views
        views.qpos[indices, :7] = space_kinematics.placed(q, base, plane)
        views.qpos[np.ix_(indices, views.joints)] = q[:, len(BASE) :]
        if self._settings.gravity is not None:
            self._gravity[indices] = 0.0, 0.0, -self._settings.gravity
        views.pull[indices] = 0.0
        views.pull[np.ix_(indices, views.moving, np.arange(3))] = self._weights(indices)
        self._pose = None
        self._scan(indices)
        return self._reading(indices)

    def _weights(self, indices: Ints) -> Floats:
        """Weights of the moving bodies of some robots, (k, bodies, 3) [N]."""
        return np.asarray(self._batch.masses[:, None] * self._gravity[indices][:, None])

    def pull(self, forces: Floats) -> None:
        rear, front = self._own_pose().points[:, :2].swapaxes(0, 1)
        views, every = self._batch.views, np.arange(self._n)
        first, weight = views.moving[0], self._weights(every)[:, 0]
        arm = (rear - front) * self._batch.rear_share
        views.pull[:, first, :3] = weight + forces
        views.pull[:, first, 3:] = np.cross(arm, forces)

    def begin(self, set_points: Floats, roll: Floats) -> Callable[[], None]:
        self._sense()
        views = self._batch.views
        views.ctrl[:, :-1], views.ctrl[:, -1] = set_points, roll
        self._batch.begin(self._own_pose().points)
        return self._move

    def _move(self) -> None:
        self._batch.move()
        self._moved = True

    def step(self, set_points: Floats, roll: Floats) -> None:
        self.begin(set_points, roll)()

    def _sense(self) -> None:
        """End the last control period, where that is not done yet, and compute what its sensors come to.

        A step leaves it to whoever reads first, since robots may move in a thread beside the rest.
        """
        if not self._moved:
            return
        self._moved, self._pose = False, None
        sensors = self._batch.end()  # (n, substeps, gyroscopes + 3 per link, half, wheel + 1)
        views = self._batch.views  # which are others where models grew
        self._loads = views.asked[:, :-1] / self._robot.effort_limits
        self._scan(np.arange(self._n))
        self._turned = sensors[:, :, : 3 * HALVES].sum(axis=1).reshape(-1, HALVES, 3) * self._settings.timestep
        distance = np.ascontiguousarray(sensors[:, :, -1].T)  # of the deepest contact, 0 where there is none
        known = (np.abs(views.qpos) < MAX_POSITION).all(axis=1) & np.isfinite(distance).all(axis=0)
        self._depth = np.where(known, np.maximum(-distance.min(axis=0), 0.0), np.inf)
        self._contact_share = (distance < 0).mean(axis=0)
        means = self._windows.means(sensors)[..., 3 * HALVES : -1].reshape(self._n, self._windows.count, -1, 3)
        links = len(self._robot.links)
        forces = means[:, :, :links].copy()
        forces[:, :, self._divided] += means[:, :, links]
        forces[:, :, self._bearing] += means[:, :, links + 1 :]  # a wheel's force is its link's
        self._link_forces = -strongest(forces)  # the sensors give what the link does to the wall

    def _own_pose(self) -> space_kinematics.SpacePose:
        """Pose of all robots now, computed once after each step."""
        self._sense()
        if self._pose is None:
            self._pose = self._batch.pose(slice(None))
        return self._pose

    def _beams(self) -> Floats:
        """Directions of all laser beams, (n, beams, 3)."""
        angles, axes = self._robot.laser.angles, self._own_pose().tip
        return np.asarray(np.stack([np.cos(angles), np.sin(angles)], axis=1) @ axes[:, :, :2].swapaxes(1, 2))

    def _scan(self, indices: Ints) -> None:
        """Let the lasers of some robots read."""
        origins, beams = self._own_pose().points[indices, -1:], self._beams()[indices]
        self._ranges[indices] = laser.measure(self._robot.laser, self._batch.distances(origins, beams, indices))

    def read(self) -> SpaceReading:
        self._sense()
        return self._reading(np.arange(self._n))

    def _reading(self, indices: Ints) -> SpaceReading:
        views = self._batch.views
        q, qd = views.qpos[np.ix_(indices, views.joints)], views.qvel[np.ix_(indices, views.speeds)]
        wheels, time = views.qvel[np.ix_(indices, views.wheels)], views.time[indices].copy()
        body = Reading(q, qd, self._ranges[indices], time, wheels, self._loads[indices])
        weight = self._gravity[indices]
        down = weight / np.maximum(np.linalg.norm(weight, axis=1, keepdims=True), 1e-9)
        in_halves = (down[:, None, None] @ self._own_pose().halves[indices])[:, :, 0]
        return SpaceReading(body, views.qpos[indices, views.roll], in_halves, self._turned[indices])

    def truth(self) -> SpaceTruth:
        self._sense()
        pose, forces = self._own_pose(), self._link_forces
        largest = np.sqrt((forces**2).sum(axis=2)).max(axis=1)
        contact = largest, self._depth.copy(), self._contact_share.copy(), forces.copy()
        return SpaceTruth(pose.points.copy(), pose.halves[..., 2].copy(), *contact)

    def open_viewer(self) -> MujocoViewer:
        """Open MuJoCo's own viewer on the first robot, in a route whose walls can be seen through."""
        model, views = self._batch.model(0), self._batch.views
        walls = model.geom_group == WALL_GROUP
        model.geom_matid[walls], model.geom_rgba[walls] = -1, CLEAR
        return MujocoViewer(
            model, {name: getattr(views, name)[0] for name in ("qpos", "qvel", "ctrl")}, self._marks, ASLANT
        )

    def _marks(self) -> Marks:
        points = self._own_pose().points[0]
        ends = points[-1] + self._ranges[0, :, None] * self._beams()[0]
        return Marks(points[-1], ends, (points[:-1] + points[1:]) / 2, self._link_forces[0], 0.0)

    def close(self) -> None:
        self._batch.close()
