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

from pipenav.learning.rollouts import SPREAD_GUARD, Decision, DrivenRollouts

STEPS, ROBOTS, BATCH = 6, 4, 8
SPACE = spaces.Box(-1.0, 1.0, (2,), np.float32)
KEYS: dict[str, Any] = {"device": "cpu", "gae_lambda": 0.9, "gamma": 0.99}
SHARES = (slice(0, 1), slice(1, ROBOTS))


class Filled:
    """The same made-up rollout in our buffer, share by share, and in Stable-Baselines3's own."""

    def __init__(self, driven: np.ndarray, seed: int) -> None:
        model = SimpleNamespace(n_steps=STEPS, n_envs=ROBOTS, observation_space=SPACE, action_space=SPACE, **KEYS)
        self.ours = DrivenRollouts(cast(Any, model))
        self.plain = RolloutBuffer(STEPS, SPACE, SPACE, n_envs=ROBOTS, **KEYS)
        rng = np.random.default_rng(seed)
        for row in range(STEPS):
            values, log_probs = rng.normal(size=(2, ROBOTS)).astype(np.float32)
            observed, acted = rng.normal(size=(2, ROBOTS, 2)).astype(np.float32)
            reward, starts = rng.normal(size=ROBOTS).astype(np.float32), rng.random(ROBOTS) < 0.2
            self.plain.add(observed, acted, reward, starts, torch.tensor(values), torch.tensor(log_probs))
            self.ours.episode_starts[row], self.ours.values[row] = starts, values
            for rows in SHARES:
                share = SimpleNamespace(rows=rows, batch=SimpleNamespace(driven=driven[row, rows]))
                decision = Decision(observed[rows], acted[rows], log_probs[rows])
                self.ours.put(row, cast(Any, share), decision, cast(Any, SimpleNamespace(reward=reward[rows])))
        for buffer in (self.ours, self.plain):
            buffer.compute_returns_and_advantage(torch.zeros(ROBOTS), np.zeros(ROBOTS))


@given(arrays.arrays(bool, (STEPS, ROBOTS)), st.integers(0, 1000))
def test_steps_of_others_teach_the_critic_but_not_the_actor(driven: np.ndarray, seed: int) -> None:
    filled = Filled(driven, seed)
    flags = filled.plain.swap_and_flatten(driven[:, :, None])[:, 0]
    np.random.seed(seed)  # noqa: NPY002
    orders = [np.random.permutation(STEPS * ROBOTS) for _ in range(2)]  # noqa: NPY002
    np.random.seed(seed)  # noqa: NPY002  # Stable-Baselines3 shuffles by it
    mine = list(filled.ours.minibatches(BATCH, epochs=2))
    np.random.seed(seed)  # noqa: NPY002
    theirs = [samples for _ in range(2) for samples in filled.plain.get(BATCH)]
    for ours, plain, chosen in zip(mine, theirs, np.concatenate(orders).reshape(-1, BATCH), strict=True):
        for name in ("observations", "actions", "returns"):
            assert np.array_equal(getattr(ours, name), getattr(plain, name).numpy())
        assert np.array_equal(ours.log_probs, plain.old_log_prob.numpy())
        counted, advantages = flags[chosen], plain.advantages.numpy().astype(float)
        assert not ours.advantages[~counted].any()
        if counted.any():
            apart = np.where(counted, advantages - advantages[counted].mean(), 0.0)
            np.testing.assert_allclose(ours.advantages, apart / (apart.std(ddof=1) + SPREAD_GUARD), atol=0.02)
