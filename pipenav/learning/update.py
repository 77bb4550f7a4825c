"""PPO's update with its loss, gradient and optimiser fused: the numbers of Stable-Baselines3's, in less time.

Losses are those of Schulman et al., Proximal Policy Optimization Algorithms (2017), eq 7 and 9, without an entropy
term; advantages are normalised in each minibatch and the gradient's norm is bounded, as in Stable-Baselines3. The
optimiser is Adam (Kingma and Ba, 2015, algorithm 1), as PyTorch has it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3 import PPO

from pipenav.learning.perceptron import FlatParameters, Perceptron, Workspace

Array32 = NDArray[np.float32]

NORM_GUARD = 1e-6
"""Number that keeps the factor on a gradient finite, as in PyTorch's `clip_grad_norm_`."""


class Minibatch(NamedTuple):
    """Samples of a gradient step, n of them.

    Attributes:
        observations, actions: observations (n, size) and the actions that answered them, (n, actions).
        log_probs: logarithms of the probabilities with which these actions were drawn, (n,).
        advantages: their advantages, normalised over the minibatch, (n,).
        returns: returns that the critic is to predict, (n,).
    """

    observations: Array32
    actions: Array32
    log_probs: Array32
    advantages: Array32
    returns: Array32


class StepLosses(NamedTuple):
    """Losses of one gradient step, under the names that they have in TensorBoard."""

    policy_gradient_loss: float
    value_loss: float
    approx_kl: float
    clip_fraction: float


class FusedUpdate:
    """Networks and optimiser of a learner, and their gradient steps.

    Matrices are multiplied by PyTorch; all else is quicker in numpy, on the same memory.

    Attributes:
        actor: network of the means of actions.
        critic: network of values.
        flat: their parameters.
    """

    def __init__(self, model: PPO) -> None:
        policy = model.policy
        self._optimizer, self._log_std = policy.optimizer, policy.log_std.detach()
        self._value_weight, self._max_norm = model.vf_coef, model.max_grad_norm
        self.flat = FlatParameters([p for p in policy.parameters() if p.requires_grad])
        extractor, workspace = policy.mlp_extractor, Workspace()
        self.actor = Perceptron([*extractor.policy_net, policy.action_net], self.flat, workspace)
        self.critic = Perceptron([*extractor.value_net, policy.value_net], self.flat, workspace)
        self._moments = torch.zeros_like(self.flat.values), torch.zeros_like(self.flat.values)
        self._steps = torch.tensor(0.0)

    def run(self, minibatches: Iterable[Minibatch], clip: float) -> list[StepLosses]:
        """Make a gradient step with each minibatch.

        Numbers that leave the finite ones make weights that are not finite: whoever calls this looks at those.

        Args:
            minibatches: samples of each step.
            clip: clip range of the probability ratio.
        """
        self._adopt_optimizer()
        losses = []
        with torch.no_grad(), np.errstate(all="ignore"):
            for minibatch in minibatches:
                losses.append(self.gradients(minibatch, clip))
                self._step()
        return losses

    def _step(self) -> None:
        """Move the weights against the gradients, by Adam."""
        group, (first, second) = self._optimizer.param_groups[0], (moment.numpy() for moment in self._moments)
        beta1, beta2 = group["betas"]
        gradients = self.flat.gradients.numpy()
        norm = math.sqrt(np.dot(gradients, gradients))
        gradients *= np.float32(min(self._max_norm / (norm + NORM_GUARD), 1.0))
        steps = self._steps.add_(1.0).item()
        first *= np.float32(beta1)
        first += np.float32(1.0 - beta1) * gradients
        second *= np.float32(beta2)
        gradients *= gradients
        gradients *= np.float32(1.0 - beta2)
        second += gradients
        scale = np.sqrt(second)
        scale *= np.float32(1.0 / math.sqrt(1.0 - beta2**steps))
        scale += np.float32(group["eps"])
        np.divide(first, scale, out=scale)
        scale *= np.float32(group["lr"] / (1.0 - beta1**steps))
        values = self.flat.values.numpy()
        values -= scale

    def gradients(self, batch: Minibatch, clip: float) -> StepLosses:
        """Compute the gradient of a minibatch's loss, and leave it with the parameters.

        Args:
            batch: the samples.
            clip: clip range of the probability ratio.
        """
        observations = torch.from_numpy(batch.observations)
        layers = self.actor.activations(observations)
        n, advantages, log_std = len(batch.returns), batch.advantages, self._log_std.numpy()
        apart = (batch.actions - layers[-1].numpy()) * np.exp(-log_std)
        log_ratio = log_probabilities(apart, log_std) - batch.log_probs
        ratio = np.exp(log_ratio)
        gain = advantages * ratio
        clipped = np.minimum(gain, advantages * np.clip(ratio, np.float32(1.0 - clip), np.float32(1.0 + clip)))
        # Where the clipped term is the smaller one, it does not depend on the policy.
        weight = np.where(clipped < gain, np.float32(0.0), gain) * np.float32(-1.0 / n)
        self.actor.backward(layers, torch.from_numpy(apart * np.exp(-log_std) * weight[:, None]))
        valued = self.critic.activations(observations)
        error = valued[-1].numpy()[:, 0] - batch.returns
        self.critic.backward(valued, torch.from_numpy((error * np.float32(2.0 * self._value_weight / n))[:, None]))
        return StepLosses(
            -float(clipped.mean()),
            float(np.dot(error, error)) / n,
            float((ratio - 1.0 - log_ratio).mean()),
            np.count_nonzero(np.abs(ratio - 1.0) > clip) / n,
        )

    def _adopt_optimizer(self) -> None:
        """Let the optimiser's own state, which is saved and loaded, be views of the moments here.

        Loading a checkpoint gives the optimiser tensors of its own: these are copied in.
        """
        state = self._optimizer.state
        for parameter, first, second in zip(self.flat.parameters, *map(self.flat.views, self._moments), strict=True):
            slots = state[parameter]
            if not slots:
                self._steps.zero_()
            for name, view in (("exp_avg", first), ("exp_avg_sq", second)):
                if name not in slots:
                    view.zero_()
                elif slots[name].data_ptr() != view.data_ptr():
                    view.copy_(slots[name])
                slots[name] = view
            self._steps.copy_(slots.get("step", self._steps))
            slots["step"] = self._steps


def log_probabilities(apart: Array32, log_std: Array32) -> Array32:
    """Logarithms of the densities of actions under a diagonal normal distribution, (n,).

    Args:
        apart: actions minus means, in standard deviations, (n, actions).
        log_std: logarithms of the standard deviations, (actions,).
    """
    constant = log_std.sum() + np.float32(0.5 * math.log(2.0 * math.pi) * len(log_std))
    densities: Array32 = np.einsum("na,na->n", apart, apart) * np.float32(-0.5) - constant
    return densities
