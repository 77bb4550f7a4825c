"""n robots in space on MuJoCo: a model for each route, whose walls are meshes of its own; stepped in threads."""

from __future__ import annotations

import copy
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import Any, NamedTuple

import mujoco
import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends import CONTROL_PERIOD, HALVES, Reading, SpaceBackend, SpaceReading, SpaceTruth, Windows, strongest
from pipenav.pipes import PipeRoute, about_x
from pipenav.robots import BASE, RobotSpec, laser
from pipenav_mujoco.model import Contact, compiled
from pipenav_mujoco.space_model import FRONT, WALL_GROUP, space_spec
from pipenav_mujoco.viewer import ASLANT, Marks, MujocoViewer

SEEN = np.array([group == WALL_GROUP for group in range(mujoco.mjNGROUP)], np.uint8)
"""Flags of the geom groups that beams meet."""


CLEAR = [0.7, 0.72, 0.75, 0.25]
"""Colour of walls in the viewer: red, green, blue, opacity."""


class SpaceSettings(NamedTuple):
    """Settings of every model, and the number of threads that step robots; see the backend's `Options`."""

    timestep: float
    contact: Contact
    gravity: float
    threads: int

    @property
    def substeps(self) -> int:
        return round(CONTROL_PERIOD / self.timestep)


class MujocoSpace(SpaceBackend):
    """Simulator of n robots in routes in space, see `pipenav.backends.SpaceBackend`."""

    def __init__(self, robot: RobotSpec, n: int, settings: SpaceSettings) -> None:
        self._robot, self._settings = robot, settings
        self._worlds: list[_World | None] = [None] * n
        self._pool = ThreadPoolExecutor(settings.threads or os.cpu_count())
        self._compiled = lru_cache(maxsize=max(64, n))(self._compile)
        self._windows = Windows(settings.substeps, settings.timestep)

    def _compile(self, route: PipeRoute) -> Any:
        settings = self._settings
        return compiled(
            space_spec(self._robot, route, settings.timestep, settings.contact, settings.gravity), self._robot
        )

    def reset(self, indices: Ints, routes: Sequence[PipeRoute], q: Floats, base: Floats, plane: Floats) -> SpaceReading:
        for robot, route, *start in zip(indices, routes, q, base, plane, strict=True):
            world = _World(self._robot, self._compiled(route), self._settings, self._windows)
            world.put(*start)
            self._worlds[robot] = world
        return _readings([world for robot in indices if (world := self._worlds[robot])])

    def step(self, set_points: Floats, roll: Floats) -> None:
        commands = np.concatenate([set_points, roll[:, None]], axis=1)
        list(self._pool.map(lambda world, command: world.step(command), self._placed(), commands))

    def read(self) -> SpaceReading:
        return _readings(self._placed())

    def truth(self) -> SpaceTruth:
        return SpaceTruth(*map(np.array, zip(*(world.truth() for world in self._placed()), strict=True)))

    def open_viewer(self) -> MujocoViewer:
        """Open MuJoCo's own viewer on the first robot, in a route whose walls can be seen through."""
        return self._placed()[0].open_viewer()

    def _placed(self) -> list[_World]:
        return [world for world in self._worlds if world is not None]

    def close(self) -> None:
        self._pool.shutdown()
        self._worlds = []


class _World:
    """A robot in its route."""

    def __init__(self, robot: RobotSpec, model: Any, settings: SpaceSettings, windows: Windows) -> None:
        assert robot.roll is not None
        self._robot, self._model, self._settings, self._windows = robot, model, settings, windows
        self._data = mujoco.MjData(model)
        joints = [model.joint(joint.name) for joint in (*robot.joints, robot.roll.joint)]
        self._q = np.array([joint.qposadr[0] for joint in joints])
        self._v = np.array([joint.dofadr[0] for joint in joints])
        self._wheels = np.array([model.joint(wheel.name).dofadr[0] for wheel in robot.wheels])
        links = [link.name for link in robot.links]
        self._links = np.array([model.body(name).id for name in links])
        self._halves = [model.body(name).id for name in (robot.roll.link, robot.roll.link + FRONT)]
        self._divided = links.index(robot.roll.link)
        self._bearing = [i for i, link in enumerate(robot.links) if link.wheel]
        self._effort = robot.effort_limits
        self._record = np.zeros((settings.substeps, model.nsensordata))
        self._turned = np.zeros((HALVES, 3))
        self._ranges = np.zeros(robot.laser.beams)
        self._loads = np.zeros(len(robot.driven_actuators))
        self._forces, self._depth, self._share = np.zeros((len(links), 3)), 0.0, 0.0

    def put(self, q: Floats, base: float, plane: float) -> None:
        """Put the robot at rest, its frame turned about the first leg's axis."""
        x, y, heading = q[: len(BASE)]
        turn = about_x(plane)
        self._data.qpos[:3] = turn @ np.array([x, y, 0.0]) + np.array([base, 0.0, 0.0])
        about_z, about_axis = np.array([np.cos(heading / 2), 0, 0, np.sin(heading / 2)]), np.zeros(4)
        about_axis[:2] = np.cos(plane / 2), np.sin(plane / 2)
        mujoco.mju_mulQuat(self._data.qpos[3:7], about_axis, about_z)
        self._data.qpos[self._q[:-1]] = q[len(BASE) :]
        mujoco.mj_forward(self._model, self._data)
        self._scan()

    def step(self, command: Floats) -> None:
        model, data = self._model, self._data
        data.ctrl[:] = command
        for row in self._record:
            mujoco.mj_step(model, data)
            row[:] = data.sensordata
        mujoco.mj_kinematics(model, data)
        self._loads = data.actuator_force[:-1] / self._effort
        self._scan()
        rates = self._record[:, : 3 * HALVES].reshape(-1, HALVES, 3)
        self._turned = rates.sum(axis=0) * self._settings.timestep
        distance = self._record[:, -1]
        known = np.isfinite(data.qpos).all() and np.isfinite(distance).all()
        self._depth = float(max(-distance.min(), 0.0)) if known else np.inf
        self._share = float((distance < 0).mean())
        means = self._windows.means(self._record[None, :, 3 * HALVES : -1]).reshape(1, self._windows.count, -1, 3)
        links = len(self._links)
        forces = means[:, :, :links].copy()
        forces[:, :, self._divided] += means[:, :, links]
        forces[:, :, self._bearing] += means[:, :, links + 1 :]  # a wheel's force is its link's
        self._forces = -strongest(forces)[0]  # the sensors give what the link does to the wall

    def open_viewer(self) -> MujocoViewer:
        model, data = copy.copy(self._model), self._data
        walls = model.geom_bodyid == 0
        model.geom_matid[walls], model.geom_rgba[walls] = -1, CLEAR
        return MujocoViewer(model, {"qpos": data.qpos, "qvel": data.qvel, "ctrl": data.ctrl}, self._marks, ASLANT)

    def _marks(self) -> Marks:
        data = self._data
        tip = data.site("tip").xpos.copy()
        ends = tip + self._ranges[:, None] * self._beams()
        return Marks(tip, ends, data.xipos[self._links].copy(), self._forces, 0.0)

    def _beams(self) -> Floats:
        """Directions of the laser beams, (beams, 3)."""
        axes, angles = self._data.site("tip").xmat.reshape(3, 3), self._robot.laser.angles
        return np.asarray(np.stack([np.cos(angles), np.sin(angles)], axis=1) @ axes[:, :2].T)

    def _scan(self) -> None:
        data, tip = self._data, self._data.site("tip")
        beams = self._beams()
        geom = np.zeros(1, np.int32)
        met = [mujoco.mj_ray(self._model, data, tip.xpos, beam, SEEN, 1, -1, geom, None) for beam in beams]
        distances = np.array(met)
        self._ranges = laser.measure(self._robot.laser, np.where(distances < 0, np.inf, distances))

    def _axes(self) -> Floats:
        """Axes of the halves of the divided link in the columns, (halves, 3, 3)."""
        return np.asarray(self._data.xmat[self._halves].reshape(HALVES, 3, 3))

    def reading(self) -> SpaceReading:
        """Reading of this robot: arrays without the robots' axis."""
        data, weight = self._data, self._model.opt.gravity
        down = weight / max(np.linalg.norm(weight), 1e-9)
        q, qd, wheels = data.qpos[self._q], data.qvel[self._v[:-1]], data.qvel[self._wheels].copy()
        body = Reading(q[:-1], qd, self._ranges, np.array(data.time), wheels, self._loads)
        return SpaceReading(body, q[-1], down @ self._axes(), self._turned)

    def truth(self) -> SpaceTruth:
        """Truth about this robot: arrays without the robots' axis."""
        data = self._data
        points = np.concatenate([data.xpos[self._links], data.site("tip").xpos[None]])
        force = np.linalg.norm(self._forces, axis=1).max()
        depth, share = np.array(self._depth), np.array(self._share)
        return SpaceTruth(points, self._axes()[:, :, 2], force, depth, share, self._forces)


def _readings(worlds: list[_World]) -> SpaceReading:
    """Readings of robots, stacked along a new first axis."""
    bodies, *others = zip(*(world.reading() for world in worlds), strict=True)
    body = Reading(*map(np.array, zip(*bodies, strict=True)))
    return SpaceReading(body, *map(np.array, others))
