"""The traverse task in space: n robots, each in a route of its own, that roll before corners in other planes.

The policy takes a robot through each corner. Between corners its `Pilot` drives, and the policy's actions are ignored.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipenav.arrays import Flags, Floats, Ints
from pipenav.backends.simulators import load_spatial
from pipenav.backends.spatial import HALVES, SpaceBackend, SpaceReading, SpaceTruth
from pipenav.errors import PipenavError
from pipenav.pipes.centre_lines import CentreLines
from pipenav.pipes.route import PipeRoute, as_route
from pipenav.robots.inertial import GRADES
from pipenav.robots.robot import BASE, RobotSpec
from pipenav.tasks.batch import StepResult, TrainingBatch
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.rolling.clamp import HALF, check_robot
from pipenav.tasks.rolling.manoeuvre import FRONT
from pipenav.tasks.rolling.pilot import Pilot
from pipenav.tasks.task import EpisodeSource
from pipenav.tasks.traverse import observation
from pipenav.tasks.traverse.batch import ANYWHERE
from pipenav.tasks.traverse.branches import Branches
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import TraverseEpisodes
from pipenav.tasks.traverse.outcome import OutcomeTracker, Whereabouts, reward
from pipenav.tasks.traverse.pace import slowness
from pipenav.tasks.traverse.sensors import Motion, Sensed, Sensors
from pipenav.tasks.traverse.tether import Tethers

LIMIT_FACTOR = 2
"""Factor on the time limit of the plane: straights are longer, and rolling takes 10 to 20 s."""


def check_in_space(robot: RobotSpec, backend: str, disturbed_by: str | None = None) -> None:
    """Refuse what cannot be done in routes that leave the plane.

    Args:
        robot: the robot.
        backend: name of a simulator.
        disturbed_by: option or setting that disturbs the robots, None where none does.

    Raises:
        PipenavError: a robot that cannot roll, a backend of the plane alone, or a disturbance.
    """
    check_robot(robot)
    load_spatial(backend)
    if disturbed_by is not None:
        raise PipenavError(f"{disturbed_by} disturbs robots in a plane: choose routes without rolls, or leave it out.")


class RollingBatch(TrainingBatch):
    """n episodes of the traverse task in space; the first reset must start all of them.

    Raises:
        PipenavError: the robot cannot roll.
    """

    def __init__(
        self,
        robot: RobotSpec,
        config: TraverseConfig,
        backend: SpaceBackend,
        n: int,
        source: EpisodeSource[TraverseEpisodes],
    ) -> None:
        check_robot(robot)
        self.robot, self.config, self.n = robot, config, n
        self._backend, self._source = backend, source
        self._scale = np.concatenate([part.scale for part in observation.layout(robot, config)])
        self._pilot = Pilot(robot, n)
        self._routes: list[PipeRoute | None] = [None] * n
        self._lines, self._branches = CentreLines.of([ANYWHERE] * n, 3), Branches.of([ANYWHERE] * n)
        self.steps, self._ages = np.zeros(n, int), np.zeros(n, int)
        self._driven = np.ones(n, bool)
        self._tracker = OutcomeTracker(robot, config, n)
        self._action, self._end, self._limit = np.zeros((n, len(robot.driven_actuators))), np.zeros(n), np.zeros(n)
        self._tethers = None if config.tether is None else Tethers(config.tether, n)
        grade = GRADES[config.sensors]
        self._sensors = None if grade is None else Sensors(grade, n, HALVES, len(robot.wheels))
        self._seen: SpaceReading | None = None
        self._before = np.zeros((n, 2 * HALF))  # joint positions that the last actions count from

    @property
    def pipes(self) -> list[PipeRoute | None]:
        return self._routes

    @property
    def q(self) -> Floats:
        """Configurations, (n, coordinates): NaN for the base, whose pose leaves the plane, then the joint positions."""
        return np.concatenate([np.full((self.n, len(BASE)), np.nan), self._backend.read().body.q], axis=1)

    @property
    def doing(self) -> list[str]:
        """Description of who drives each robot, in words."""
        return self._pilot.doing

    @property
    def driven(self) -> Flags:
        return self._driven

    def truth(self) -> SpaceTruth:
        """Quantities that only the simulator knows, such as where the robots are."""
        return self._backend.truth()

    def reset(self, indices: Ints | None = None) -> Floats:
        indices = np.arange(self.n) if indices is None else np.asarray(indices, np.intp)
        episodes = self._source(indices)
        routes = [as_route(pipe) for pipe in episodes.pipes]
        planes = np.array([route.corners[0].roll for route in routes])
        self._backend.incline(indices, episodes.gravity_in_space)
        reading = self._backend.reset(indices, routes, episodes.q, episodes.base, planes)
        self._start_sensors(indices, episodes.sensor_seeds)
        self._lines = self._lines.put(indices, CentreLines.of(routes, 3))
        self._branches = self._branches.put(indices, Branches.of(routes))
        q = reading.body.q
        self._pilot.start(indices, routes, q + episodes.press)
        for i, route in zip(indices, routes, strict=True):
            self._routes[i] = route
            self._end[i] = route.distances[-2] + route.inner_edges[-1]
            self._limit[i] = LIMIT_FACTOR * self.config.max_steps * len(route.corners)
        self.steps[indices], self._ages[indices] = self._ages[indices], 0
        self._action[indices] = 0.0
        distances = self._distances(self._backend.truth())[indices]
        slower = slowness(self.robot, self.config, episodes)
        self._limit[indices] *= slower
        self._tracker.start(indices, distances, slower)
        if self._tethers is not None:
            self._tethers.start(indices, episodes.cable, distances[:, 0])
        return self._observe(self._read())

    def stagger(self, rng: np.random.Generator) -> None:
        self._ages = rng.integers(0, self.config.max_steps // 2, self.n)

    def begin(self, action: Floats) -> Callable[[], None]:
        reading, pilot = self._read(), self._pilot
        joints, turn_sign = reading.body.q, pilot.turn_sign
        self._before = joints if self.config.set_points == "measured" else pilot.set_points
        wanted = observation.to_command(self.robot, self.config, action, joints, pilot.set_points, turn_sign)
        self._driven = pilot.policy_drives
        if self._tethers is not None:
            self._backend.pull(self._tethers.forces(self._lines, self._backend.truth().points[:, 0]))
        self._action = np.where(self._driven[:, None], np.clip(action, -1.0, 1.0), 0.0)
        return self._backend.begin(*pilot.command(reading, wanted.values))

    def carried_out(self, rows: Ints, told: Floats) -> Floats:
        pilot, joints = self._pilot, 2 * HALF
        before, signs = self._before[rows], pilot.turn_sign[rows]
        acted = observation.of_command(self.robot, self.config, told, before, before, signs)
        self._action[rows] = acted
        pilot.set_points[rows] = told[:, :joints]
        return acted

    def end(self) -> StepResult:
        pilot, turn_sign = self._pilot, self._pilot.turn_sign
        self.steps += 1
        truth = self._backend.truth()
        body, reading = (read := self._backend.read()).body, self._sense(read, truth)
        pilot.sense(reading)
        self._action = observation.mirror_action(self.robot, self._action, pilot.turn_sign * turn_sign)
        self._tracker.reset_patience(pilot.busy)
        places = Whereabouts(self._distances(truth), self._branches.contain(truth.points, self._lines))
        facts, outcome = self._tracker.step(self.steps, self._limit, places, self._end, body, truth)
        gained, min_range = reward(self.config.reward, facts), body.ranges.min(axis=1)
        cut_off = (outcome != Outcome.RUNNING) & ~facts.passed & ~facts.failed
        return StepResult(self._observe(reading), gained, outcome, min_range, truth, cut_off)

    def close(self) -> None:
        self._backend.close()

    def _read(self) -> SpaceReading:
        """Readings of the robots' own sensors after the last control period or reset."""
        return self._backend.read() if self._seen is None else self._seen

    def _start_sensors(self, indices: Ints, seeds: Ints) -> None:
        """Begin anew with the sensors of some robots that were put at rest."""
        if self._sensors is None:
            return
        reading = self._backend.read()
        started = self._sensors.start(indices, seeds, _motion(reading, self._backend.truth()).rows(indices))
        before = reading if self._seen is None else self._seen
        assert before.body.wheel_speeds is not None
        sensed = Sensed(before.down, before.turned, before.body.wheel_speeds)
        for column, rows in zip(sensed, started, strict=True):
            column[indices] = rows
        self._seen = _as_sensed(reading, sensed)

    def _sense(self, reading: SpaceReading, truth: SpaceTruth) -> SpaceReading:
        """Readings with the errors of the sensors' grade, for the true ones of a control period."""
        if self._sensors is None:
            return reading
        assert reading.body.wheel_speeds is not None
        self._seen = _as_sensed(reading, self._sensors.sense(_motion(reading, truth), reading.body.wheel_speeds))
        return self._seen

    def _observe(self, reading: SpaceReading) -> Floats:
        down = None if self.config.inclination_deg is None else reading.down[:, FRONT, :2]
        pilot, told = self._pilot, self.config.exit_told
        route = observation.RouteAhead(pilot.turn_sign, pilot.neighbours, pilot.straight_on if told else None)
        seen = observation.observe(self.robot, reading.body, self._action, route, down)
        return np.asarray(seen / self._scale)

    def _distances(self, truth: SpaceTruth) -> Floats:
        """Distances of rear ends, joints and tips along the pipe, (n, links + 1) [m]."""
        return self._lines.distance(truth.points)


def _motion(reading: SpaceReading, truth: SpaceTruth) -> Motion:
    """Motion of the halves of the divided link, whose middle has the sensors."""
    ends = truth.points[:, HALF : HALF + 2]
    forward = ends[:, 1] - ends[:, 0]
    x = np.broadcast_to((forward / np.linalg.norm(forward, axis=1, keepdims=True))[:, None], truth.normals.shape)
    axes = np.stack([x, np.cross(truth.normals, x), truth.normals], axis=3)
    return Motion(reading.down, reading.turned, ends.mean(axis=1), axes)


def _as_sensed(reading: SpaceReading, sensed: Sensed) -> SpaceReading:
    """A reading with what the sensors make of it."""
    body = reading.body._replace(wheel_speeds=sensed.wheel_speeds)
    return reading._replace(body=body, down=sensed.down, turned=sensed.turned)
