"""Rollouts in which the policy does not drive at every step.

In space a robot's pilot drives between corners, and the policy's actions do nothing. Those steps stay in the rollout:
their rewards are what earlier actions led to, and the critic must know what they are worth, since a rollout may end
among them. Only the actor does not learn from them. That is sound: an action that nobody follows changes neither the
reward nor the next state, so its true advantage is 0, and so is its part of the policy's gradient (the policy gradient
theorem asks for nothing else). An estimated advantage would be 0 only on average: pure noise, in more than half of all
steps.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer, RolloutBufferSamples

from pipenav.tasks.batch import TrainingBatch


class DrivenRollouts(RolloutBuffer):  # type: ignore[misc]  # Stable-Baselines3 is imported untyped
    """The learner's rollouts; where all steps are driven, the same as Stable-Baselines3's own.

    Args:
        batch: the robots, which say after each step whose actions counted.
        model: the learner.
    """

    def __init__(self, batch: TrainingBatch, model: PPO) -> None:
        self._batch = batch
        self._driven = np.ones((model.n_steps, batch.n, 1), bool)
        super().__init__(
            model.n_steps,
            model.observation_space,
            model.action_space,
            device=model.device,
            gae_lambda=model.gae_lambda,
            gamma=model.gamma,
            n_envs=batch.n,
        )

    def add(self, *args: Any, **kwargs: Any) -> None:
        self._driven[self.pos, :, 0] = self._batch.driven
        super().add(*args, **kwargs)

    def _get_samples(self, batch_inds: np.ndarray, env: Any = None) -> RolloutBufferSamples:
        """Samples of a minibatch; steps that were not driven get the mean advantage, which PPO's norm makes 0."""
        samples = super()._get_samples(batch_inds, env)
        driven = self.to_torch(self.swap_and_flatten(self._driven)[batch_inds, 0])
        counted = samples.advantages[driven]
        mean = counted.mean() if len(counted) else samples.advantages.new_zeros(())
        return samples._replace(advantages=samples.advantages.where(driven, mean))
