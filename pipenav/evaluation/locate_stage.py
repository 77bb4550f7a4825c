"""Approach I as a stage of a passage: n robots look for a target; success is a target that is `well_placed`."""

from __future__ import annotations

import numpy as np

from pipenav.arrays import Floats, Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Command, Reading
from pipenav.evaluation.stage import Stage, StageStep
from pipenav.locating.locator import LocateConfig, Locator, Told, require_arm
from pipenav.pipes.corner import PipeCorner
from pipenav.robots import frames
from pipenav.robots.bend_reach import Bends, reach_along
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome, strongest_outcome
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes, at_limit
from pipenav.tasks.task import EpisodeSource


class LocateStage(Stage):
    """The robots look for a target; finding one inside the second leg, or as far as the arm can reach, is success.

    Args:
        robot: a slide followed by hinges, with the fan that the locator wants (`robot_for`).
        locator: the behaviour of n robots.
        task: settings that say when an episode fails: its steps, penetration and limit margin.
        simulator: a simulator with n robots.
        source: source of episodes, whose targets are not looked at.

    Attributes:
        target: found targets in the canonical frame, as `ReachEpisodes.target`, (n, 2) [m]; NaN before one is found.
        beam: beam on which the target lies, or the nearest one, from right to left from 0, (n,); -1 before.
        reading: the last readings of the robots' sensors; the next step decides on them.

    Raises:
        PipenavError: a robot of other joints.
    """

    def __init__(
        self,
        robot: RobotSpec,
        locator: Locator,
        task: ReachConfig,
        simulator: Simulator,
        source: EpisodeSource[ReachEpisodes],
    ) -> None:
        require_arm(robot)
        self.robot, self.n = robot, locator.n
        self._locator, self._task, self._simulator, self._source = locator, task, simulator, source
        n = self.n
        self._steps = np.zeros(n, int)
        self._pipes: list[PipeCorner | None] = [None] * n
        self._base, self._turn_sign = np.zeros(n), np.ones(n)
        self.target, self.beam = np.full((n, 2), np.nan), np.full(n, -1)
        q, qd = np.zeros((2, n, len(robot.joints)))
        self.reading = Reading(q, qd, np.zeros((n, robot.laser.beams)), np.zeros(n))

    @property
    def steps(self) -> Ints:
        return self._steps

    def start(self, indices: Ints) -> None:
        episodes = self._source(indices)
        reading = self._simulator.reset(indices, episodes.pipes, episodes.q, episodes.base)
        for i, pipe in zip(indices, episodes.pipes, strict=True):
            self._pipes[i] = pipe
        self._steps[indices], self._base[indices], self._turn_sign[indices] = 0, episodes.base, episodes.turn_sign
        self.target[indices], self.beam[indices] = np.nan, -1
        self.reading.put(indices, reading)
        self._locator.start(indices, reading, Told.of(episodes.pipes))

    def step(self) -> StageStep:
        decision = self._locator.act(self.reading)
        self.target = frames.robot_to_canonical(decision.target, self._turn_sign)
        self.beam = decision.beam
        self._simulator.step(Command("position", decision.set_points))
        self._steps += 1
        self.reading, truth = self._simulator.read(), self._simulator.truth()
        well = np.array([done and self._well_placed(i, decision.target[i]) for i, done in enumerate(decision.done)])
        holds = {
            Outcome.TIMEOUT: self._steps >= self._task.max_steps,
            Outcome.REACHED: well,
            Outcome.MISPLACED: decision.done & ~well,
            Outcome.LIMIT: at_limit(self.robot, self._task, self.reading.q),
            Outcome.PENETRATION: truth.penetration > self._task.max_penetration,
        }
        outcome = strongest_outcome(self.n, holds)
        return StageStep(outcome, self.reading.ranges.min(axis=1), truth, self.reading.q)

    def target_of(self, index: int) -> Floats:
        return np.asarray(self.target[index])

    def close(self) -> None:
        self._simulator.close()

    def _well_placed(self, index: int, target: Floats) -> bool:
        pipe = self._pipes[index]
        base = float(self._base[index])
        return pipe is not None and well_placed(self.robot, pipe, base, frames.robot_to_pipe(target, base))


def well_placed(robot: RobotSpec, pipe: PipeCorner, base: float, point: Floats) -> bool:
    """Whether a point (2,) of the pipe's frame is a target that a search may find.

    It lies inside the second leg. In a swept bend whose end the arm cannot pass by the depth that is wanted, it may lie
    before that end: up to that depth short of the reach, as elsewhere it may be up to that depth short.

    Args:
        robot: the robot.
        pipe: the pipe.
        base: x of the robot's frame in the pipe's frame [m].
        point: the point.
    """
    if inside_second_leg(pipe, point):
        return True
    if not pipe.bend_radius or not pipe.contains(point):
        return False
    bend = Bends(*np.array([[pipe.radius], [pipe.bend_radius], [abs(pipe.heading_change)]]))
    start = np.array([-pipe.inner_edge])
    reach = reach_along(robot, bend, base - start)
    seen = frames.pipe_to_robot(point[None] * [1.0, pipe.turn_sign], start)  # the bend's own frame, a left turn's
    return bool(bend.distance(seen)[0] > min(bend.end[0], reach[0] - LocateConfig().depth))


def inside_second_leg(pipe: PipeCorner, point: Floats) -> bool:
    """Whether a point (2,) of the pipe's frame lies inside the pipe and past the end of the inner wall's bend.

    In a tee or a cross it must not lie beside the second leg, in another pipe that leads the same way.
    """
    distance, aside = pipe.along_second_leg(point).tolist()
    beside = bool(pipe.branches) and abs(aside) > pipe.radius
    return distance > pipe.inner_edge and not beside and bool(pipe.contains(point))
