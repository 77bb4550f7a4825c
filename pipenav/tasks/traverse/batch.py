"""The traverse task on n robots of one backend at once: the core that every adapter wraps."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Command, Reading, Truth
from pipenav.backends.refusals import CannotIncline, CannotPull
from pipenav.pipes.centre_lines import CentreLines
from pipenav.pipes.corner import PipeCorner
from pipenav.pipes.pipe import Pipe
from pipenav.robots import frames, kinematics
from pipenav.robots.inertial import GRADES
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.batch import StepResult, TrainingBatch
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.task import EpisodeSource
from pipenav.tasks.traverse import observation
from pipenav.tasks.traverse.branches import Branches
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import GRAVITY, TraverseEpisodes, check_robot
from pipenav.tasks.traverse.outcome import OutcomeTracker, Whereabouts, reward
from pipenav.tasks.traverse.pace import slowness
from pipenav.tasks.traverse.sensors import Motion, Sensors
from pipenav.tasks.traverse.tether import Tethers

ANYWHERE = PipeCorner.of(100, 90)
"""Pipe of a robot before its first reset, only to give the arrays their shapes."""


class TraverseBatch(TrainingBatch):
    """n episodes of the traverse task.

    Raises:
        PipenavError: the robot hangs on a mount, pipes are not level and the simulator cannot incline them, or a tether
            pulls and the simulator cannot let it.
    """

    def __init__(
        self,
        robot: RobotSpec,
        config: TraverseConfig,
        simulator: Simulator,
        n: int,
        source: EpisodeSource[TraverseEpisodes],
    ) -> None:
        check_robot(robot)
        if config.inclination_deg is not None and not simulator.can_incline:
            raise CannotIncline(simulator)
        if config.tether is not None and not simulator.can_pull:
            raise CannotPull(simulator)
        self.robot, self.config, self.n = robot, config, n
        self._simulator, self._source = simulator, source
        self._scale = np.concatenate([part.scale for part in observation.layout(robot, config)])
        self._pipes: list[Pipe | None] = [None] * n
        self.steps, self._ages = np.zeros(n, int), np.zeros(n, int)
        self._turn_signs, self._base = np.ones((n, 3)), np.zeros(n)
        self._lines, self._branches = CentreLines.of([ANYWHERE] * n), Branches.of([ANYWHERE] * n)
        self._corner = np.zeros(n, np.intp)
        self._gravity = np.zeros((n, 2))
        self._tracker = OutcomeTracker(robot, config, n)
        self._action, self._q = np.zeros((n, len(robot.driven_actuators))), np.zeros((n, robot.coordinates))
        self._set_points = self._start = np.zeros((n, len(robot.joints)))
        self._limit = np.zeros(n)
        self._tethers = None if config.tether is None else Tethers(config.tether, n)
        grade = GRADES[config.sensors]
        self._sensors = None if grade is None else Sensors(grade, n, 1, len(robot.wheels))
        self._feels = grade is not None or config.inclination_deg is not None
        self._heading, self._down = np.zeros(n), np.zeros((n, 2))
        self._observation = np.zeros((n, len(self._scale)))
        self._ranges = np.zeros((n, robot.laser.beams))
        self._felt: Reading

    @property
    def ranges(self) -> Floats:
        """Laser readings in the robot's own frame, from right to left, (n, beams) [m]."""
        return self._ranges.copy()

    @property
    def pipes(self) -> list[Pipe | None]:
        return self._pipes

    @property
    def q(self) -> Floats:
        """Configurations in the robot's own frame, (n, coordinates)."""
        return self._q.copy()

    @property
    def points(self) -> Floats:
        """Rear end, joints and tip in the pipe's frame, (n, links + 1, 2) [m]; policies do not see them."""
        return frames.robot_to_pipe(kinematics.waypoints(self.robot, self._q), self._base[:, None])

    @property
    def set_points(self) -> Floats:
        """Set-points of the joints in the last control step, in the robot's own frame, (n, joints) [rad]."""
        return self._set_points.copy()

    @property
    def distances(self) -> Floats:
        """Distances of `points` along the pipe, 0 at the first corner, (n, links + 1) [m]."""
        return self._lines.distance(self.points)

    def reset(self, indices: Ints | None = None) -> Floats:
        indices = np.arange(self.n) if indices is None else np.asarray(indices, np.intp)
        episodes = self._source(indices)
        if self.config.inclination_deg is not None:
            self._simulator.incline(indices, episodes.gravity)
        reading = self._simulator.reset(indices, episodes.pipes, episodes.q, episodes.base)
        for i, pipe in zip(indices, episodes.pipes, strict=True):
            self._pipes[i] = pipe
        self.steps[indices], self._ages[indices] = self._ages[indices], 0
        self._base[indices], self._q[indices], self._action[indices] = episodes.base, episodes.q, 0.0
        self._gravity[indices], self._ranges[indices] = episodes.gravity, reading.ranges
        self._set_points[indices] = reading.q + episodes.press
        self._lines, self._corner[indices] = self._lines.put(indices, CentreLines.of(episodes.pipes)), 0
        self._branches = self._branches.put(indices, Branches.of(episodes.pipes))
        self._turn_signs[indices] = self._lines.turn_signs(self._corner)[indices]
        self._feel_at_rest(indices, episodes.sensor_seeds)
        distances, slower = self.distances[indices], slowness(self.robot, self.config, episodes)
        self._limit[indices] = self.config.max_steps * slower * self._lines.corners[indices]
        self._tracker.start(indices, distances, slower)
        if self._tethers is not None:
            self._tethers.start(indices, episodes.cable, distances[:, 0])
        self._observation = self._observation.copy()
        self._observation[indices] = self._observe(reading, indices)
        return self._observation

    def stagger(self, rng: np.random.Generator) -> None:
        self._ages = rng.integers(0, self.config.max_steps // 2, self.n)

    def begin(self, action: Floats) -> Callable[[], None]:
        joints, command = self._q[:, -self._set_points.shape[1] :], self._command(action)
        self._start = joints if self.config.set_points == "measured" else self._set_points
        self._set_points = command.values[:, : joints.shape[1]].copy()
        self._action = np.clip(action, -1.0, 1.0)
        if self._tethers is not None:
            self._simulator.pull(self._tethers.forces(self._lines, self.points[:, 0]))
        return partial(self._simulator.step, command)

    def carried_out(self, rows: Ints, told: Floats) -> Floats:
        joints = self._set_points.shape[1]
        q, start, signs = self._q[rows, -joints:], self._start[rows], self._turn_signs[rows, 0]
        acted = observation.of_command(self.robot, self.config, told, q, start, signs)
        self._action[rows], self._set_points[rows] = acted, told[:, :joints]
        return acted

    def end(self) -> StepResult:
        self.steps += 1
        reading, truth = self._simulator.read(), self._simulator.truth()
        self._q, self._ranges = self._configuration(reading, truth), reading.ranges.copy()
        points, every, last = self.points, np.arange(self.n), self._lines.corners - 1
        end = self._lines.end[every, last]
        places = Whereabouts(self._lines.distance(points), self._branches.contain(points, self._lines))
        facts, outcome = self._tracker.step(self.steps, self._limit, places, end, reading, truth)
        self._enter_corners(places.distances.mean(axis=1))
        self._felt = self._feel(reading)
        self._observation = self._observe(self._felt, every)
        gained = reward(self.config.reward, facts)
        cut_off = (outcome != Outcome.RUNNING) & ~facts.passed & ~facts.failed
        return StepResult(self._observation, gained, outcome, reading.ranges.min(axis=1), truth, cut_off)

    def close(self) -> None:
        self._simulator.close()

    def _command(self, action: Floats) -> Command:
        """Command for canonical actions, (n, action_size)."""
        joints = self._q[:, -self._set_points.shape[1] :]
        return observation.to_command(self.robot, self.config, action, joints, self._set_points, self._turn_signs[:, 0])

    def _configuration(self, reading: Reading, truth: Truth) -> Floats:
        """Configurations, (n, coordinates), from the joints and from the tip that the simulator knows."""
        tip = truth.tip.copy()
        tip[:, 0] -= self._base
        return kinematics.configuration(self.robot, reading.q, tip)

    def _observe(self, reading: Reading, indices: Ints) -> Floats:
        """Scaled observations of some robots, (k, size), from the readings of their sensors."""
        straight_on = self._lines.straight_on(self._corner)[indices] if self.config.exit_told else None
        route = observation.RouteAhead(self._turn_signs[indices, 0], self._turn_signs[indices, 1:], straight_on)
        down = None if self.config.inclination_deg is None else self._down[indices]
        observed = observation.observe(self.robot, reading, self._action[indices], route, down)
        return np.asarray(observed / self._scale)

    def _feel_at_rest(self, indices: Ints, seeds: Ints) -> None:
        """Let the sensors of some robots begin anew, with seeds of their errors, (k,)."""
        if not self._feels:
            return
        motion = self._motion()
        self._down[indices] = motion.down[indices, 0, :2]
        if self._sensors is not None:
            self._down[indices] = self._sensors.start(indices, seeds, motion.rows(indices)).down[:, 0, :2]

    def _feel(self, reading: Reading) -> Reading:
        """Feel where down is after a control period; the reading with what encoders make of the wheels' speeds."""
        if not self._feels:
            return reading
        motion = self._motion()
        if self._sensors is None:
            self._down = motion.down[:, 0, :2]
            return reading
        assert reading.wheel_speeds is not None
        sensed = self._sensors.sense(motion, reading.wheel_speeds)
        self._down = sensed.down[:, 0, :2]
        return reading._replace(wheel_speeds=sensed.wheel_speeds)

    def _motion(self) -> Motion:
        """Motion of the links with the accelerometers since this was last asked."""
        link = observation.accelerometer(self.robot)
        heading = kinematics.forward(self.robot, self._q).headings[:, link]
        cos, sin, zero = np.cos(heading), np.sin(heading), np.zeros(self.n)
        axes = np.stack([cos, -sin, zero, sin, cos, zero, zero, zero, zero + 1], axis=1).reshape(-1, 1, 3, 3)
        x, y = self._gravity.T / GRAVITY
        down = np.stack([x * cos + y * sin, y * cos - x * sin, zero], axis=1)[:, None]
        turned = np.stack([zero, zero, heading - self._heading], axis=1)[:, None]
        self._heading = heading
        centre = np.pad(self.points[:, link : link + 2].mean(axis=1), [(0, 0), (0, 1)])
        return Motion(down, turned, centre, axes)

    def _enter_corners(self, middle: Floats) -> None:
        """Find the corner that each robot is in: the first one that its middle has not passed, never an earlier one.

        With the corner the turn sign may change; observations and actions are mirrored from then on.

        Args:
            middle: distance of each robot's middle along the pipe, (n,) [m].
        """
        passed = (middle[:, None] >= self._lines.end) & (self._lines.turn_sign != 0)
        self._corner = np.maximum(self._corner, np.minimum(passed.sum(axis=1), self._lines.corners - 1))
        before, self._turn_signs = self._turn_signs[:, 0], self._lines.turn_signs(self._corner)
        self._action = observation.mirror_action(self.robot, self._action, self._turn_signs[:, 0] * before)
