"""Rollouts, share by share, in which the policy does not drive at every step, and the minibatches made of them.

In space a robot's pilot drives between corners, and the policy's actions do nothing. Those steps stay in the rollout:
their rewards are what earlier actions led to, and the critic must know what they are worth, since a rollout may end
among them. Only the actor does not learn from them. That is sound: an action that nobody follows changes neither the
reward nor the next state, so its true advantage is 0, and so is its part of the policy's gradient (the policy gradient
theorem asks for nothing else). An estimated advantage would be 0 only on average: pure noise, in more than half of all
steps.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer

from pipenav.envs.shares import RobotShare, ShareStep
from pipenav.learning.update import Minibatch

SPREAD_GUARD = 1e-8
"""Number that keeps normalised advantages finite, as in Stable-Baselines3."""


class Decision(NamedTuple):
    """Actions of a share's n robots.

    Attributes:
        observation: observations that they answer, (n, size).
        actions: actions as they were drawn, not bounded, (n, actions).
        log_probs: logarithms of the probabilities with which they were drawn, (n,).
    """

    observation: np.ndarray
    actions: np.ndarray
    log_probs: np.ndarray


class DrivenRollouts(RolloutBuffer):  # type: ignore[misc]  # Stable-Baselines3 is imported untyped
    """The learner's rollouts, which know whose actions counted.

    Attributes:
        driven: whether each action counted, (steps, n).
    """

    def __init__(self, model: PPO) -> None:
        self.driven = np.ones((model.n_steps, model.n_envs), bool)
        super().__init__(
            model.n_steps,
            model.observation_space,
            model.action_space,
            device=model.device,
            gae_lambda=model.gae_lambda,
            gamma=model.gamma,
            n_envs=model.n_envs,
        )

    def put(self, row: int, share: RobotShare, decision: Decision, step: ShareStep) -> None:
        """Keep a control step of a share's robots, all but the values of its observations.

        Args:
            row: number of the step in the rollout.
            share: the share.
            decision: actions of the step.
            step: what they led to.
        """
        at = row, share.rows
        self.observations[at], self.actions[at], self.log_probs[at] = decision
        self.rewards[at], self.driven[at] = step.reward, share.batch.driven

    def minibatches(self, size: int, epochs: int) -> Iterator[Minibatch]:
        """Samples of each gradient step of an update, every epoch in another order.

        Args:
            size: samples in a minibatch; it divides all samples.
            epochs: passes over the rollout.
        """
        columns = self.observations, self.actions, self.log_probs, self.advantages, self.returns, self.driven
        flat = [column.swapaxes(0, 1).reshape(-1, *column.shape[2:]) for column in columns]
        for _ in range(epochs):
            # Stable-Baselines3 seeds this generator, and shuffles by it.
            order = np.random.permutation(len(flat[0]))  # noqa: NPY002
            for chosen in np.split(order, range(size, len(order), size)):
                observations, actions, log_probs, advantages, returns, driven = (column[chosen] for column in flat)
                yield Minibatch(observations, actions, log_probs, normalised(advantages, driven), returns)


def normalised(advantages: np.ndarray, driven: np.ndarray) -> np.ndarray:
    """Advantages of a minibatch with mean 0 and standard deviation 1; 0 where the step was not driven, (n,).

    Args:
        advantages: estimated advantages, (n,).
        driven: whether each action counted, (n,).
    """
    n, counted = len(advantages), int(np.count_nonzero(driven))
    apart = (advantages - (advantages @ driven) / np.float32(max(counted, 1))) * driven
    spread = np.sqrt(apart @ apart / np.float32(max(n - 1, 1)))
    return np.asarray(apart / (spread + np.float32(SPREAD_GUARD)))
