"""The batch of models that robots in space run on: one model for each route, all of one layout."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import mujoco
import mujoco.batch
import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends import CONTROL_PERIOD, PARKED
from pipenav.pipes import PipeRoute
from pipenav.robots import RobotSpec, space_kinematics
from pipenav_mujoco.model import Contact, compiled
from pipenav_mujoco.near_pairs import NearPairs, Parts, Walls
from pipenav_mujoco.space_model import FRONT, space_spec
from pipenav_mujoco.space_walls import WALL_GROUP, Layout, hand_to_world
from pipenav_mujoco.ways import RECENT, Expected, Way

SEEN = np.array([group == WALL_GROUP for group in range(mujoco.mjNGROUP)], np.uint8)
"""Flags of the geom groups that beams meet."""

RECORDED = ("sensordata", "xpos", "site_xpos")
"""Fields that are recorded of each physics step: sensors, and places of bodies and sites where it began."""

PAIRS = 1.35
"""Pairs that models have room for at first, as a multiple of the pieces of wall: enough for nearly every route."""


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


class _Models(NamedTuple):
    """Model of a route, which robots copy, and its walls."""

    model: Any
    walls: Walls


class SpaceBatch:
    """The models of n robots, each in its route, and their batch.

    A route that needs a larger layout than those before makes all models anew; the robots stay where they are. Until a
    robot gets its route it is parked. Each robot's model lists the pairs of geoms that can touch within a control
    period; where a robot passed so far from its expected way that others could have touched, it goes the period again
    in halves. So the lists alter nothing but the time that a step takes.
    """

    def __init__(self, robot: RobotSpec, n: int, settings: SpaceSettings) -> None:
        self._robot, self._n, self._settings = robot, n, settings
        self._layout: Layout | None = None
        self._views: Views | None = None
        self._routes: list[PipeRoute] = []
        self._layout_of = lru_cache(maxsize=max(64, n))(Layout.of)
        self._compiled = lru_cache(maxsize=max(64, n))(self._compile)
        self._models: list[Any] = []
        self._pairs: NearPairs | None = None
        self._expected = Expected(n, len(robot.links) + 1, len(robot.joints))
        self._record: dict[Any, Any] = {}
        self._way, self._state = Way.resting(np.zeros((n, len(robot.links) + 1, 3))), np.zeros((n, 0))

    def _compile(self, route: PipeRoute, layout: Layout) -> _Models:
        settings = self._settings
        spec = space_spec(self._robot, route, layout, settings.timestep, settings.contact)
        model = compiled(spec, self._robot)
        walls = Walls.of(model)
        hand_to_world(model)
        model.body_contype[:] = model.body_conaffinity[:] = 0  # listed pairs meet, no others
        return _Models(model, walls)

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
        needed = self._layout or self._layout_of(routes[0])
        for route in dict.fromkeys(routes):
            needed = needed.union(self._layout_of(route))
        needed = needed.with_pairs(PAIRS * needed.pieces)
        walled = indices
        if needed != self._layout:
            self._open(needed)
            walled = np.arange(self._n)
        self._take(walled)
        for values in self.views.own:
            values[indices] = 0.0
        self._expected.forget(indices)

    def _take(self, indices: Ints) -> None:
        """Take copies of the models of some robots' routes, and let MuJoCo place their walls, which a reset alone does.

        The state stays as it is.
        """
        assert self._layout is not None and self._pairs is not None
        made = [self._compiled(self._routes[i], self._layout) for i in indices]
        for i, of_route in zip(indices, made, strict=True):
            self._models[i] = copy.copy(of_route.model)
        self._pairs.take(self._models, indices, [of_route.walls for of_route in made])
        batch = self.views.batch
        batch.set_models(self._models)
        state = batch.state[indices]
        batch.reset(indices, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        batch.state[indices] = state

    def _open(self, layout: Layout) -> None:
        """Open a batch for models of a new layout, and take the state over from the one before."""
        self._layout = layout
        robot, settings, before = self._robot, self._settings, self._views
        assert robot.roll is not None
        model, walls = self._compiled(self._routes[0], layout)
        self._models = [model] * self._n
        self._pairs = NearPairs(Parts.of(robot, model, robot.roll.link + FRONT), self._n, len(walls.geom))
        self._views = views = Views(robot, model, self._n, settings.threads)
        links = [model.body(link.name).id for link in robot.links]
        self._links, self._tip = links, model.site("tip").id
        shapes = {"sensordata": (model.nsensordata,), "xpos": (model.nbody, 3), "site_xpos": (model.nsite, 3)}
        for name, shape in shapes.items():
            if (row := (settings.substeps, *shape)) != self._record.get(name, np.zeros(0)).shape[1:]:
                self._record[name] = np.zeros((self._n, *row))
        if before is None:
            views.qpos[:, 2] = PARKED
            return
        for values, values_before in zip(views.own, before.own, strict=True):
            values[:] = values_before
        views.pull[:, views.moving] = before.pull[:, before.moving]

    def pose(self, indices: Ints | slice) -> space_kinematics.SpacePose:
        """Poses of some robots now."""
        views = self.views
        qpos = views.qpos[indices]
        return space_kinematics.forward(self._robot, qpos[:, :7], qpos[:, views.joints], qpos[:, views.roll])

    def begin(self, points: Floats) -> None:
        """Begin a control period of all robots.

        Args:
            points: rear ends, joints and tips of all robots, (n, links + 1, 3) [m].
        """
        self._way = self._expected.ways(points, self.views.ctrl[:, : len(self._robot.joints)])
        self._find(np.arange(self._n), self._way, self._expected.steady)
        self._state = self.views.batch.state.copy()

    def move(self) -> None:
        """Advance all robots by the control period that has begun; it may be called in another thread."""
        self.views.batch.rollout(self._settings.substeps, record=RECORDED, out=self._record)

    def end(self) -> Floats:
        """End a control period: robots that strayed go it again.

        Returns:
            The sensors of every physics step, (n, substeps, sensors).
        """
        way, substeps = self._way, self._settings.substeps
        strayed = way.strayed(self._tracks(self._record))
        again = np.flatnonzero(~(strayed <= way.slack))
        if len(again):
            self._repeat(again, self._state[again], 0, substeps)
        late = substeps - substeps // RECENT
        places = {name: values[:, late : late + 1] for name, values in self._record.items()}
        self._expected.learn(way, strayed, self._tracks(places)[..., 0].transpose(2, 0, 1))
        return np.asarray(self._record["sensordata"])

    def _find(self, indices: Ints, way: Way, steady: Flags | None = None) -> None:
        """List the pairs of some robots on their ways, with room for all of them."""
        assert self._layout is not None and self._pairs is not None
        most = self._pairs.find(indices, way, steady)
        if most > self._layout.pairs:
            self._open(self._layout.with_pairs(1.5 * most))
            self._take(np.arange(self._n))
            self._find(indices, way)

    def _tracks(self, record: dict[Any, Any]) -> Floats:
        """Points of k robots whenever contacts were computed, (links + 1, 3, k, substeps) [m]."""
        tracks = np.empty((len(self._links) + 1, 3, *record["xpos"].shape[:2]))
        for track, link in zip(tracks[:-1], self._links, strict=True):
            track[:] = record["xpos"][:, :, link].transpose(2, 0, 1)
        tracks[-1] = record["site_xpos"][:, :, self._tip].transpose(2, 0, 1)
        return tracks

    def _repeat(self, indices: Ints, states: Floats, first: int, count: int) -> None:
        """Advance some robots anew from the states (k, size) before a physics step, by two halves of `count` steps.

        In a single physics step no point strays: contacts are computed where it begins.
        """
        for begin, steps in ((first, count // 2), (first + count // 2, count - count // 2)):
            if begin > first:
                states = self.views.batch.state[indices]
            self.views.batch.state[indices] = states
            way = Way.resting(self.pose(indices).points)
            self._find(indices, way)  # which opens another batch where models have no room
            record = self.views.batch.rollout(steps, record=RECORDED, ids=indices)
            for name, values in record.items():
                self._record[name][indices, begin : begin + steps] = values
            far = ~(way.strayed(self._tracks(record)) <= way.slack)
            if steps > 1 and far.any():
                self._repeat(indices[far], states[far], begin, steps)

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
