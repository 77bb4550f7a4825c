"""The traverse task in space: n robots, each in a route of its own, that roll before corners in other planes.

A policy of the plane takes a robot through each corner. Between corners its `Pilot` drives, and the policy's actions
are ignored.
"""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.spatial import SpaceBackend, SpaceReading, SpaceTruth
from pipenav.pipes.centre_lines import CentreLines
from pipenav.pipes.route import PipeRoute, as_route
from pipenav.robots.robot import BASE, RobotSpec
from pipenav.tasks.batch import StepResult, TaskBatch
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.rolling.clamp import check_robot
from pipenav.tasks.rolling.manoeuvre import FRONT
from pipenav.tasks.rolling.pilot import Mode, Pilot
from pipenav.tasks.task import EpisodeSource
from pipenav.tasks.traverse import observation
from pipenav.tasks.traverse.batch import ANYWHERE
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import GRAVITY, TraverseEpisodes
from pipenav.tasks.traverse.outcome import OutcomeTracker, reward

LIMIT_FACTOR = 2
"""Factor on the time limit of the plane: straights are longer, and rolling takes 10 to 20 s."""


class RollingBatch(TaskBatch):
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
        self._pilots: dict[int, Pilot] = {}
        self._routes: dict[int, PipeRoute] = {}
        self._lines = CentreLines.of([ANYWHERE] * n, 3)
        self.steps = np.zeros(n, int)
        self._tracker = OutcomeTracker(robot, config, n)
        self._action, self._end, self._limit = np.zeros((n, len(robot.driven_actuators))), np.zeros(n), np.zeros(n, int)

    @property
    def pipes(self) -> list[PipeRoute]:
        """Route of each robot, once all have one."""
        return [self._routes[i] for i in range(self.n)]

    @property
    def q(self) -> Floats:
        """Configurations, (n, coordinates): NaN for the base, whose pose leaves the plane, then the joint positions."""
        return np.concatenate([np.full((self.n, len(BASE)), np.nan), self._backend.read().body.q], axis=1)

    @property
    def doing(self) -> list[str]:
        """Description of who drives each robot, in words."""
        return [self._pilots[i].doing for i in range(self.n)]

    def truth(self) -> SpaceTruth:
        """Quantities that only the simulator knows, such as where the robots are."""
        return self._backend.truth()

    def reset(self, indices: Ints | None = None) -> Floats:
        indices = np.arange(self.n) if indices is None else np.asarray(indices, np.intp)
        episodes = self._source(indices)
        routes = [as_route(pipe) for pipe in episodes.pipes]
        planes = np.array([route.corners[0].roll for route in routes])
        weight = 0.0 if self.config.inclination_deg is None else GRAVITY  # a policy of a level plane feels none
        self._backend.incline(indices, np.tile([0.0, 0.0, -weight], (len(indices), 1)))
        reading = self._backend.reset(indices, routes, episodes.q, episodes.base, planes)
        self._lines = self._lines.put(indices, CentreLines.of(routes, 3))
        for i, route, q in zip(indices, routes, reading.body.q, strict=True):
            self._routes[i] = route
            self._pilots[i] = Pilot(self.robot, route, q + self.config.start_press * np.sign(q))
            self._end[i] = route.distances[-2] + route.inner_edges[-1]
            self._limit[i] = LIMIT_FACTOR * self.config.max_steps * len(route.corners)
        self.steps[indices], self._action[indices] = 0, 0.0
        self._tracker.start(indices, self._distances()[indices])
        return self._observe(self._backend.read())

    def step(self, action: Floats) -> StepResult:
        reading, pilots = self._backend.read(), [self._pilots[i] for i in range(self.n)]
        held = np.array([pilot.set_points for pilot in pilots])
        wanted = observation.to_command(self.robot, self.config, action, reading.body.q, held, self._turn_sign).values
        commands = [pilot.command(reading.row(i), wanted[i]) for i, pilot in enumerate(pilots)]
        policy_drives = np.array([pilot.mode is Mode.CORNER for pilot in pilots])
        self._action = np.where(policy_drives[:, None], np.clip(action, -1.0, 1.0), 0.0)
        set_points, rolls = (np.array(column) for column in zip(*commands, strict=True))
        self._backend.step(set_points, rolls)
        self.steps += 1
        reading, truth = self._backend.read(), self._backend.truth()
        for i, pilot in enumerate(pilots):
            pilot.sense(reading.row(i))
        self._tracker.reset_patience(np.array([pilot.mode in (Mode.ROLL, Mode.BACK_OUT) for pilot in pilots]))
        facts, outcome = self._tracker.step(self.steps, self._limit, self._distances(), self._end, reading.body, truth)
        gained, min_range = reward(self.config.reward, facts), reading.body.ranges.min(axis=1)
        cut_off = (outcome != Outcome.RUNNING) & ~facts.passed & ~facts.failed
        return StepResult(self._observe(reading), gained, outcome, min_range, truth, cut_off)

    def close(self) -> None:
        self._backend.close()

    @property
    def _turn_sign(self) -> Floats:
        return np.array([self._pilots[i].turn_sign for i in range(self.n)])

    def _observe(self, reading: SpaceReading) -> Floats:
        alone = np.zeros((self.n, 2))  # the policy takes every corner as if it had no neighbours
        down = None if self.config.inclination_deg is None else reading.down[:, FRONT, :2]
        seen = observation.observe(self.robot, reading.body, self._action, self._turn_sign, alone, down)
        return np.asarray(seen / self._scale)

    def _distances(self) -> Floats:
        """Distances of rear ends, joints and tips along the pipe, (n, links + 1) [m]."""
        return self._lines.distance(self._backend.truth().points)
