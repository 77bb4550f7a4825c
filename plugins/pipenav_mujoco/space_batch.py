"""The batch of models that robots in space run on: one model for each route, all of one layout."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import mujoco
import mujoco.batch
import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends import CONTROL_PERIOD, PARKED
from pipenav.pipes import PipeRoute
from pipenav.robots import RobotSpec
from pipenav_mujoco.box_tree import split_well
from pipenav_mujoco.leg_boxes import LegBoxes
from pipenav_mujoco.model import Contact, compiled
from pipenav_mujoco.space_model import space_spec
from pipenav_mujoco.space_walls import WALL_GROUP, Layout, leg_name

SEEN = np.array([group == WALL_GROUP for group in range(mujoco.mjNGROUP)], np.uint8)
"""Flags of the geom groups that beams meet."""


class SpaceSettings(NamedTuple):
    """Settings of every model, and the number of threads that step robots; see the backend's `Options`.

    Attributes:
        timestep: physics step [s].
        contact: parameters of contacts.
        gravity: gravity along -z that overrules what `incline` asks for [m/s^2]; None for none.
        threads: number of threads, 0 for every core.
    """

    timestep: float
    contact: Contact
    gravity: float | None
    threads: int

    @property
    def substeps(self) -> int:
        return round(CONTROL_PERIOD / self.timestep)


class Views:
    """Live views of a batch's state, and where the robot's parts lie in it.

    Attributes:
        batch: the batch.
        qpos, qvel, time, warm, ctrl, pull: fields of its state; `pull` holds the forces on bodies, (n, bodies, 6).
        asked: efforts of the actuators, (n, actuators).
        joints, speeds, roll, wheels: places of the joints in qpos and in qvel, of the roll joint, and of the wheels.
        moving: bodies that move.
    """

    def __init__(self, robot: RobotSpec, model: Any, n: int, threads: int) -> None:
        assert robot.roll is not None
        self.batch = batch = mujoco.batch.Batch(model, n, threads, persistent=True)  # as sleep asks for
        self.qpos, self.qvel, self.time = batch.bind("qpos"), batch.bind("qvel"), batch.bind("time")
        self.warm, self.ctrl = batch.bind("qacc_warmstart"), batch.bind("ctrl")
        self.pull, self.asked = batch.bind("xfrc_applied"), batch.bind("actuator_force")
        self.joints = np.array([model.joint(joint.name).qposadr[0] for joint in robot.joints])
        self.speeds = np.array([model.joint(joint.name).dofadr[0] for joint in robot.joints])
        self.roll = model.joint(robot.roll.joint.name).qposadr[0]
        self.wheels = np.array([model.joint(wheel.name).dofadr[0] for wheel in robot.wheels])
        self.moving = np.flatnonzero(model.body_weldid != 0)

    @property
    def own(self) -> list[Floats]:
        """Fields of the state that depend on the robot alone, whatever its walls."""
        return [self.qpos, self.qvel, self.time, self.warm, self.ctrl]


class SpaceBatch:
    """The models of n robots, each in its route, and their batch.

    A route that needs a larger layout than those before makes all models anew; the robots stay where they are. Until a
    robot gets its route it is parked. Walls of legs that a robot cannot reach within a control period are left out of
    its collisions, which alters nothing but the time that it takes.
    """

    def __init__(self, robot: RobotSpec, n: int, settings: SpaceSettings) -> None:
        self._robot, self._n, self._settings = robot, n, settings
        self._layout: Layout | None = None
        self._views: Views | None = None
        self._routes: list[PipeRoute] = []
        self._layout_of = lru_cache(maxsize=max(64, n))(Layout.of)
        self._compiled = lru_cache(maxsize=max(64, n))(self._compile)
        self._among = lru_cache(maxsize=max(512, 8 * n))(self._among_legs)
        self._models: list[Any] = []
        self._first_leg = 0
        self._boxes: LegBoxes | None = None
        self._reached = np.zeros((n, 0), bool)
        self._record: dict[Any, Any] = {}

    def _compile(self, route: PipeRoute, layout: Layout) -> Any:
        settings = self._settings
        spec = space_spec(self._robot, route, layout, settings.timestep, settings.contact)
        model = compiled(spec, self._robot)
        for leg in range(len(route.straights)):
            split_well(model, model.body(leg_name(leg)).id)
        parked = slice(model.body(leg_name(len(route.straights))).id, model.nbody)
        model.body_contype[parked] = model.body_conaffinity[parked] = 0  # they have served: the trees have their sizes
        return model

    def _among_legs(self, route: PipeRoute, layout: Layout, legs: tuple[bool, ...]) -> Any:
        """Model of a route in which the robot meets the walls of some legs alone."""
        model = copy.copy(self._compiled(route, layout))
        far = np.flatnonzero(~np.array(legs)) + model.body(leg_name(0)).id
        model.body_contype[far] = model.body_conaffinity[far] = 0
        return model

    @property
    def views(self) -> Views:
        """The state, once a robot has a route."""
        assert self._views is not None
        return self._views

    @property
    def masses(self) -> Floats:
        """Masses of the bodies that move, (bodies,) [kg]."""
        return np.asarray(self.views.batch.model.body_mass[self.views.moving])

    @property
    def rear_share(self) -> float:
        """Share of the first link that lies behind its centre of mass."""
        first = self.views.moving[0]
        return float(self.views.batch.model.body_ipos[first, 0] / self._robot.links[0].length)

    def put(self, indices: Ints, routes: Sequence[PipeRoute]) -> None:
        """Give some robots the models of their routes, with all of their state zero."""
        if not routes:
            return
        if not self._routes:
            self._routes = [routes[0]] * self._n
        for i, route in zip(indices, routes, strict=True):
            self._routes[i] = route
        before = self._layout
        for route in dict.fromkeys(routes):
            needed = self._layout_of(route)
            self._layout = needed if self._layout is None else self._layout.union(needed)
        assert self._layout is not None
        walled = indices
        if self._layout != before:
            self._open(self._compiled(routes[0], self._layout))
            walled = np.arange(self._n)
        self._take(walled)
        self._place_walls(walled)
        for values in self.views.own:
            values[indices] = 0.0

    def _place_walls(self, indices: Ints) -> None:
        """Set the models of all robots, and let MuJoCo place the walls of some, which it does at a reset alone."""
        batch = self.views.batch
        batch.set_models(self._models)
        state = batch.state[indices]
        batch.reset(indices, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        batch.state[indices] = state

    def _take(self, indices: Ints) -> None:
        """Take the models of some robots' routes, with all of their legs."""
        assert self._layout is not None and self._boxes is not None
        models = [self._compiled(self._routes[i], self._layout) for i in indices]
        for i, model in zip(indices, models, strict=True):
            self._models[i] = model
        boxes = LegBoxes.of(models, self._first_leg, self._layout.legs)
        for values, of_models in zip(self._boxes, boxes, strict=True):
            values[indices] = of_models
        self._reached[indices] = True

    def _open(self, model: Any) -> None:
        """Open a batch for models of a new layout, and take the state over from the one before."""
        robot, settings, before = self._robot, self._settings, self._views
        assert self._layout is not None
        self._first_leg, legs = model.body(leg_name(0)).id, self._layout.legs
        self._models = [model] * self._n
        self._boxes = LegBoxes.of(self._models, self._first_leg, legs)
        self._reached = np.ones((self._n, legs), bool)
        self._views = views = Views(robot, model, self._n, settings.threads)
        self._record = {"sensordata": np.zeros((self._n, settings.substeps, model.nsensordata))}
        if before is None:
            views.qpos[:, 2] = PARKED
            return
        for values, values_before in zip(views.own, before.own, strict=True):
            values[:] = values_before
        views.pull[:, views.moving] = before.pull[:, before.moving]

    def come_near(self, points: Floats) -> None:
        """Let robots at these points (n, p, 3) meet the legs that they can reach in the next control period."""
        assert self._boxes is not None and self._layout is not None
        reached = self._boxes.within_reach(points)
        changed = np.flatnonzero((reached != self._reached).any(axis=1))
        for i in changed:
            self._models[i] = self._among(self._routes[i], self._layout, tuple(reached[i].tolist()))
        if len(changed):
            self.views.batch.set_models(self._models)
        self._reached = reached

    def step(self) -> Floats:
        """Advance all robots by a control period; return the sensors of every physics step, (n, substeps, sensors)."""
        self.views.batch.rollout(self._settings.substeps, record=("sensordata",), out=self._record)
        return np.asarray(self._record["sensordata"])

    def repeat(self, indices: Ints, states: Floats) -> None:
        """Advance some robots anew among all walls, from the states (k, size) that they were in."""
        self._take(indices)
        batch = self.views.batch
        batch.set_models(self._models)
        batch.state[indices] = states
        record = batch.rollout(self._settings.substeps, record=("sensordata",), ids=indices)
        self._record["sensordata"][indices] = record["sensordata"]

    def distances(self, origins: Floats, directions: Floats, indices: Ints) -> Floats:
        """Distances from points (k, 1, 3) along unit vectors (k, beams, 3) to the walls of k robots, inf for none.

        Returns:
            (k, beams) [m].
        """
        met, _ = self.views.batch.ray(origins, directions, geomgroup=SEEN, ids=indices)
        return np.where(met < 0, np.inf, met)

    def model(self, i: int) -> Any:
        """Model of a robot in its route, as a copy."""
        return self.views.batch.get_model(i)

    def close(self) -> None:
        """Release the batch and all models."""
        self._views, self._routes = None, []
        self._compiled.cache_clear()
        self._among.cache_clear()
