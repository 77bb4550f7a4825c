"""Rollouts in which the policy does not always drive: only what it did itself teaches it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import torch
from gymnasium import spaces
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from stable_baselines3.common.buffers import RolloutBuffer

from pipenav.learning.rollouts import DrivenRollouts

STEPS, ROBOTS, BATCH = 6, 4, 8
SPACE = spaces.Box(-1.0, 1.0, (2,), np.float32)
KEYS = {"device": "cpu", "gae_lambda": 0.9, "gamma": 0.99}


def filled(buffer: Any, driven: np.ndarray, batch: Any, seed: int) -> Any:
    """The buffer with a made-up rollout in it."""
    rng = np.random.default_rng(seed)
    for row in driven:
        batch.driven = row
        values, log_probs = torch.tensor(rng.normal(size=(2, ROBOTS)), dtype=torch.float32)
        observed, acted = rng.normal(size=(2, ROBOTS, 2))
        buffer.add(observed, acted, rng.normal(size=ROBOTS), rng.random(ROBOTS) < 0.2, values, log_probs)
    buffer.compute_returns_and_advantage(torch.zeros(ROBOTS), np.zeros(ROBOTS))
    return buffer


def minibatches(buffer: Any, seed: int) -> list[Any]:
    np.random.seed(seed)  # noqa: NPY002  # Stable-Baselines3 shuffles by it
    return list(buffer.get(BATCH))


@given(arrays.arrays(bool, (STEPS, ROBOTS)), st.integers(0, 1000))
def test_steps_of_others_teach_the_critic_but_not_the_actor(driven: np.ndarray, seed: int) -> None:
    batch = SimpleNamespace(n=ROBOTS, driven=np.ones(ROBOTS, bool))
    model = SimpleNamespace(n_steps=STEPS, observation_space=SPACE, action_space=SPACE, **KEYS)
    ours = filled(DrivenRollouts(cast(Any, batch), cast(Any, model)), driven, batch, seed)
    plain = filled(RolloutBuffer(STEPS, SPACE, SPACE, n_envs=ROBOTS, **KEYS), driven, batch, seed)
    flags = plain.swap_and_flatten(driven[:, :, None])[:, 0]
    np.random.seed(seed)  # noqa: NPY002
    order = np.random.permutation(STEPS * ROBOTS)  # noqa: NPY002
    for k, (mine, theirs) in enumerate(zip(minibatches(ours, seed), minibatches(plain, seed), strict=True)):
        counted = torch.tensor(flags[order[k * BATCH : (k + 1) * BATCH]])
        assert torch.equal(mine.returns, theirs.returns)
        assert torch.equal(mine.advantages[counted], theirs.advantages[counted])
        if 0 < int(counted.sum()) < len(counted):  # PPO subtracts the mean
            np.testing.assert_allclose((mine.advantages - mine.advantages.mean())[~counted], 0.0, atol=1e-5)
        elif not counted.any():
            assert not mine.advantages.any()
