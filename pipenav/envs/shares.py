"""Shares of a training's robots, which take turns: one moves in a thread while the others are attended to.

Observations, rewards, resets and the policy need one core, physics needs all. With two shares there is always physics
to do: the first share's robots move while the second one's get their next actions, and the other way round. Each share
is a batch of its own with a simulator of its own, and whoever steps them does so in a fixed order, so that nothing
depends on how long a thread takes.
"""

from __future__ import annotations

from concurrent.futures import Executor, Future, wait
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Flags, Floats, Ints
from pipenav.envs.spaces import Float32s
from pipenav.tasks.batch import StepResult, TrainingBatch
from pipenav.tasks.outcome import Outcome


class Ended(NamedTuple):
    """Episodes that ended in a control step, k of them.

    Attributes:
        robots: robots that they are of, numbered within their share or their environment, (k,).
        outcome: an `Outcome` for each, (k,).
        steps: control steps that each took, (k,).
        reward: sum of each one's rewards, (k,).
        observation: last observation of each, (k, size).
        cut_off: whether the time limit alone ended each, (k,).
    """

    robots: Ints
    outcome: NDArray[np.int8]
    steps: Ints
    reward: Floats
    observation: Float32s
    cut_off: Flags


class ShareStep(NamedTuple):
    """A control step of a share's n robots.

    Attributes:
        observation: observations that the next actions answer, of new episodes where one ended, (n, size).
        reward: rewards, (n,).
        done: whether each robot's episode ended, (n,).
        ended: the episodes that did.
        result: result of the step before any robot started anew.
    """

    observation: Float32s
    reward: Float32s
    done: Flags
    ended: Ended
    result: StepResult


class RobotShare:
    """A share of an environment's robots.

    Args:
        batch: its robots.
        first: number of its first robot in the environment.
        threads: threads in which the robots move; None: they move while they are sent.

    Attributes:
        batch: its robots.
        rows: rows of its robots in the environment's arrays.
    """

    def __init__(self, batch: TrainingBatch, first: int = 0, threads: Executor | None = None) -> None:
        self.batch, self.rows = batch, slice(first, first + batch.n)
        self._threads = threads
        self._rewards = np.zeros(batch.n)
        self._moving: Future[None] | None = None

    @property
    def moving(self) -> bool:
        """Whether a control step has begun that was not received yet."""
        return self._moving is not None

    def reset(self) -> Float32s:
        """Give up a control step that has begun, start all episodes anew, and return their observations, (n, size)."""
        self._give_up()
        self._rewards[:] = 0.0
        return self.batch.reset().astype(np.float32)

    def _give_up(self) -> None:
        """Wait until the robots stand still, whatever became of the control step that they began."""
        if self._moving is not None:
            wait([self._moving])
        self._moving = None

    def send(self, actions: Floats | Float32s) -> None:
        """Begin a control step.

        Args:
            actions: canonical actions in [-1, 1], (n, action_size).
        """
        move = self.batch.begin(np.asarray(actions, np.float64))
        if self._threads is not None:
            self._moving = self._threads.submit(move)
        else:
            move()
            self._moving = Future()
            self._moving.set_result(None)

    def receive(self) -> ShareStep:
        """End the control step that has begun; robots whose episodes ended start anew.

        Raises:
            ValueError: none has begun.
        """
        if self._moving is None:
            raise ValueError("no control step has begun")
        self._moving.result()
        self._moving = None
        result = self.batch.end()
        observation = result.observation.astype(np.float32)
        self._rewards += result.reward
        done = result.outcome != Outcome.RUNNING.value
        indices = np.flatnonzero(done)
        steps, rewards = self.batch.steps[indices], self._rewards[indices]
        ended = Ended(indices, result.outcome[indices], steps, rewards, observation[indices], result.cut_off[indices])
        if len(indices):
            self._rewards[indices] = 0.0
            observation = self.batch.reset(indices).astype(np.float32)
        return ShareStep(observation, result.reward.astype(np.float32), done, ended, result)

    def close(self) -> None:
        """Release the simulator, once the robots stand still."""
        self._give_up()
        self.batch.close()


def joined(shares: list[RobotShare], ended: list[Ended]) -> Ended:
    """Episodes that ended in a control step of all shares, with robots numbered as in the environment."""
    moved = [part._replace(robots=part.robots + share.rows.start) for share, part in zip(shares, ended, strict=True)]
    return Ended(*(np.concatenate(columns) for columns in zip(*moved, strict=True)))
