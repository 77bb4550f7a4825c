"""The rear half's passage as a stage of an evaluation (approach II)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pipenav.arrays import Ints
from pipenav.backends.backend import CONTROL_PERIOD, Simulator
from pipenav.backends.messages import Command
from pipenav.evaluation.stage import Stage, StageStep
from pipenav.motions.follower import Follower
from pipenav.motions.trajectory import Motion
from pipenav.robots.outline import foremost
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.outcome import Outcome, strongest_outcome
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import at_limit

MotionSource = Callable[[Ints], Sequence[Motion]]
"""Called with the robots that start anew; returns the next rear motion of each."""


class RearStage(Stage):
    """The rear half leaves the corner: its motion is sent, row by row, to the position controllers, see `Follower`.

    Every robot starts at rest in its motion's first row, the mirrored final pose of the stage reach, and holds the
    last row. REACHED: the whole arm is out of the corner; TIMEOUT: it is not within the follower's patience. Joint
    limits and overlap end an episode as in the reach task.
    """

    def __init__(
        self, robot: RobotSpec, backend: Simulator, n: int, source: MotionSource, config: ReachConfig | None = None
    ) -> None:
        self.robot, self.n = robot, n
        self._backend, self._source, self._config = backend, source, config or ReachConfig()
        self._steps = np.zeros(n, np.intp)
        self._motions: list[Motion] = []
        self._follower, self._q = Follower(robot, n, CONTROL_PERIOD), np.zeros((n, len(robot.joints)))

    @property
    def steps(self) -> Ints:
        return self._steps.copy()

    def start(self, indices: Ints) -> None:
        motions = self._source(indices)
        if not self._motions:
            self._motions = [motions[0]] * self.n
        for index, motion in zip(indices, motions, strict=True):
            self._motions[index] = motion
        first, base = np.array([motion.q[0] for motion in motions]), np.array([motion.base for motion in motions])
        reading = self._backend.reset(indices, [motion.pipe for motion in motions], first, base)
        self._follower.start(indices, [motion.q for motion in motions])
        self._steps[indices], self._q[indices] = 0, reading.q

    def step(self) -> StageStep:
        self._steps += 1
        set_points = self._follower.act(self._q)
        self._backend.step(Command("position", np.clip(set_points, self.robot.lower, self.robot.upper)))
        reading, truth = self._backend.read(), self._backend.truth()
        self._q = reading.q
        edges = np.array([motion.base + motion.pipe.inner_edge for motion in self._motions])
        holds = {
            Outcome.TIMEOUT: self._steps >= self._follower.patience,
            Outcome.REACHED: foremost(self.robot, reading.q) + edges <= 0,
            Outcome.LIMIT: at_limit(self.robot, self._config, reading.q),
            Outcome.PENETRATION: truth.penetration > self._config.max_penetration,
        }
        outcome = strongest_outcome(self.n, holds)
        return StageStep(outcome, reading.ranges.min(axis=1), truth, reading.q)

    def close(self) -> None:
        self._backend.close()
