"""The fused update: gradients of autograd, weights of Stable-Baselines3's own PPO, and an optimiser that loads."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from helpers.shares import env_of
from helpers.tiny_training import tiny
from hypothesis import given, settings
from hypothesis import strategies as st
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.logger import Logger
from torch import nn

from pipenav.errors import PipenavError
from pipenav.learning.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from pipenav.learning.learner import Learner
from pipenav.learning.perceptron import FlatParameters, Perceptron, Workspace
from pipenav.learning.train import new_model
from pipenav.learning.update import Minibatch

N = 16


def learner(seed: int = 0, **more: Any) -> Learner:
    """A learner with a made-up rollout, in which the policy has moved on from what drew the actions."""
    with closing(env_of([N])) as env:
        model = new_model(tiny(seed=seed, **more), env)
    model.set_logger(Logger(folder=None, output_formats=[]))
    model._current_progress_remaining = 1.0
    rng, buffer = np.random.default_rng(seed), model.rollout_buffer
    for values in (buffer.observations, buffer.actions, buffer.advantages, buffer.returns):
        values[:] = rng.normal(size=values.shape)
    buffer.log_probs[:] = rng.normal(-5.0, 0.5, buffer.log_probs.shape)
    buffer.full = True
    return model


def weights(model: PPO) -> np.ndarray:
    return nn.utils.parameters_to_vector(model.policy.parameters()).detach().numpy().copy()


def loss(model: PPO, batch: Minibatch, clip: float) -> torch.Tensor:
    """The loss of a minibatch by its definition, for autograd."""
    observations, actions, old, advantages, returns = map(torch.from_numpy, batch)
    values, log_probs, _ = model.policy.evaluate_actions(observations, actions)
    ratio = torch.exp(log_probs - old)
    surrogate = torch.minimum(advantages * ratio, advantages * ratio.clamp(1 - clip, 1 + clip))
    return -surrogate.mean() + model.vf_coef * nn.functional.mse_loss(values.flatten(), returns)


@given(st.integers(0, 1000), st.sampled_from([(8,), (16, 8), (8, 8, 8)]), st.sampled_from([(4,), (8, 16)]))
@settings(max_examples=15, deadline=None)
def test_gradients_are_those_of_autograd(seed: int, policy: Any, value: Any) -> None:
    model = learner(seed, **{"network.policy": policy, "network.value": value})
    update = model._update
    batch = next(model.rollout_buffer.minibatches(64, 1))
    with torch.no_grad():
        update.gradients(batch, 0.2)
    ours = update.flat.gradients.clone()
    loss(model, batch, 0.2).backward()
    autograd = torch.cat([parameter.grad.flatten() for parameter in update.flat.parameters])  # type: ignore[union-attr]
    torch.testing.assert_close(ours, autograd, rtol=1e-4, atol=1e-5 * float(autograd.abs().max()))


@given(st.integers(0, 1000))
@settings(max_examples=5, deadline=None)
def test_an_update_gives_the_weights_of_the_plain_one(seed: int) -> None:
    ours, plain = learner(seed), learner(seed)
    before = weights(ours)
    buffer = RolloutBuffer(
        plain.n_steps, plain.observation_space, plain.action_space, n_envs=N, gamma=plain.gamma, device="cpu"
    )
    for name in ("observations", "actions", "log_probs", "advantages", "returns"):
        getattr(buffer, name)[:] = getattr(plain.rollout_buffer, name)
    buffer.full, plain.rollout_buffer = True, buffer
    for model, train in ((ours, Learner.train), (plain, PPO.train)):
        np.random.seed(seed)  # noqa: NPY002  # Stable-Baselines3 shuffles by it
        train(model)
    moved = np.abs(weights(ours) - before)
    assert moved.max() > 1e-3
    np.testing.assert_allclose(weights(ours), weights(plain), atol=0.02 * moved.max())


def test_an_optimiser_that_was_saved_goes_on_to_the_bit(tmp_path: Path) -> None:
    model, other = learner(1), learner(2)
    model.train()
    other.train()
    save_checkpoint(tmp_path / "resume", model, Checkpoint())
    load_checkpoint(tmp_path / "resume", other)
    fresh = learner(3)
    load_checkpoint(tmp_path / "resume", fresh)
    for one in (model, other, fresh):
        for name in ("observations", "actions", "log_probs", "advantages", "returns"):
            getattr(one.rollout_buffer, name)[:] = getattr(model.rollout_buffer, name)
        np.random.seed(1)  # noqa: NPY002
        one.train()
    assert np.array_equal(weights(other), weights(model))
    assert np.array_equal(weights(fresh), weights(model))


def test_networks_of_another_kind_are_refused() -> None:
    modules = [nn.Linear(2, 3), nn.ReLU(), nn.Linear(3, 1)]
    flat = FlatParameters(list(nn.Sequential(*modules).parameters()))
    with pytest.raises(PipenavError, match="only fully connected tanh networks"):
        Perceptron(modules, flat, Workspace())
