"""The learner's rollouts: what Stable-Baselines3 would have kept, whatever the threads do."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from helpers.shares import Dawdling, env_of
from helpers.tiny_training import tiny, weights
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

from pipenav.learning.learner import Learner
from pipenav.learning.train import new_model, train
from pipenav.learning.training_folder import TrainingFolder

N = 16
KEPT = ("observations", "actions", "rewards", "episode_starts", "values", "advantages", "returns")


class Nothing(BaseCallback):  # type: ignore[misc]  # Stable-Baselines3 is imported untyped
    """Counts episodes, and nothing else."""

    def __init__(self) -> None:
        super().__init__()
        self.ended = 0

    def _on_step(self) -> bool:
        self.ended += len(self.locals["ended"].robots) if "ended" in self.locals else 0
        return True


class Replay:
    """A policy's answers with the actions of a rollout that another one kept."""

    def __init__(self, model: PPO, actions: np.ndarray) -> None:
        self._model, self._actions = model, iter(actions)

    def __call__(self, observation: torch.Tensor) -> Any:
        values = self._model.policy.predict_values(observation)
        return torch.from_numpy(next(self._actions)), values, torch.zeros(len(observation))


def collected(model: Learner, callback: BaseCallback) -> Learner:
    """The model after a rollout."""
    model._setup_learn(1, callback)
    assert model.collect_rollouts(model.env, callback, model.rollout_buffer, model.n_steps)
    return model


@pytest.mark.parametrize("sizes", [[N], [9, 7]], ids=str)
def test_a_rollout_is_what_the_plain_learner_would_keep(sizes: Sequence[int]) -> None:
    with closing(env_of(sizes)) as env, closing(env_of([N])) as same:
        callback = Nothing()
        ours = collected(new_model(tiny(), env), callback)
        assert callback.ended > N
        plain = PPO("MlpPolicy", same, n_steps=ours.n_steps, gamma=ours.gamma, gae_lambda=ours.gae_lambda, device="cpu")
        actions = ours.rollout_buffer.actions.copy()
        plain.policy = ours.policy
        plain.policy.forward = Replay(plain, actions)
        _, counting = plain._setup_learn(1, Nothing())
        plain.collect_rollouts(plain.env, counting, plain.rollout_buffer, plain.n_steps)
        for name in KEPT:
            np.testing.assert_allclose(
                getattr(ours.rollout_buffer, name), getattr(plain.rollout_buffer, name), atol=1e-4, err_msg=name
            )
        observations = torch.from_numpy(ours.rollout_buffer.observations.reshape(-1, *ours.observation_space.shape))
        _, log_probs, _ = ours.policy.evaluate_actions(observations, torch.from_numpy(actions.reshape(-1, 4)))
        kept = ours.rollout_buffer.log_probs.ravel()
        np.testing.assert_allclose(kept, log_probs.detach().numpy(), atol=1e-3)


def learned(sizes: Sequence[int], delays: Any = lambda: 0.0) -> np.ndarray:
    with closing(env_of(sizes, simulator=lambda n: Dawdling(n, delays))) as env:
        model = new_model(tiny(), env).learn(4 * N * 16)
        return np.concatenate([parameter.detach().numpy().ravel() for parameter in model.policy.parameters()])


def test_the_time_that_a_step_takes_changes_no_weight() -> None:
    pause = np.random.default_rng(0)
    assert np.array_equal(learned([8, 8], lambda: pause.uniform(0, 2e-3)), learned([8, 8]))


@pytest.mark.slow
def test_the_number_of_threads_changes_no_weight(tmp_path: Path) -> None:
    paths = []
    for threads in (1, 2, 3):
        config = tiny(options={"threads": threads})
        folder = TrainingFolder.create(tmp_path / f"run-{threads}", config, "pipenav train")
        train(config, folder)
        paths.append(weights(folder.last))
    assert paths[0] == paths[1] == paths[2]
    again = PPO.load(folder.last, device="cpu")
    assert type(again) is PPO
