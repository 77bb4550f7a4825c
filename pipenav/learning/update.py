"""PPO's update with its loss, gradient and optimiser fused: the numbers of Stable-Baselines3's, in a fifth of the time.

Losses are those of Schulman et al., Proximal Policy Optimization Algorithms (2017), eq 7 and 9, without an entropy term;
advantages are normalised in each minibatch and the gradient's norm is bounded, as in Stable-Baselines3. The optimiser
is Adam (Kingma and Ba, 2015, algorithm 1), in PyTorch's order of operations.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import torch
from stable_baselines3 import PPO
from torch import Tensor

from pipenav.learning.perceptron import FlatParameters, Perceptron

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

    observations: Tensor
    actions: Tensor
    log_probs: Tensor
    advantages: Tensor
    returns: Tensor


class StepLosses(NamedTuple):
    """Losses of one gradient step, a number each, under the names that they have in TensorBoard."""

    policy_gradient_loss: Tensor
    value_loss: Tensor
    approx_kl: Tensor
    clip_fraction: Tensor


class FusedUpdate:
    """Networks and optimiser of a learner, and their gradient steps.

    Attributes:
        actor: network of the means of actions.
        critic: network of values.
    """

    def __init__(self, model: PPO) -> None:
        policy = model.policy
        self._policy, self._model = policy, model
        self._flat = FlatParameters([p for p in policy.parameters() if p.requires_grad])
        extractor = policy.mlp_extractor
        self.actor = Perceptron([*extractor.policy_net, policy.action_net], self._flat)
        self.critic = Perceptron([*extractor.value_net, policy.value_net], self._flat)
        self._moments = torch.zeros_like(self._flat.values), torch.zeros_like(self._flat.values)
        self._steps = torch.tensor(0.0)

    def run(self, minibatches: Iterable[Minibatch], clip: float) -> list[StepLosses]:
        """Make a gradient step with each minibatch.

        Args:
            minibatches: samples of each step.
            clip: clip range of the probability ratio.
        """
        self._adopt_optimizer()
        with torch.no_grad():
            return [self._step(minibatch, clip) for minibatch in minibatches]

    def _step(self, batch: Minibatch, clip: float) -> StepLosses:
        losses = self.gradients(batch, clip)
        flat, (first, second) = self._flat, self._moments
        flat.gradients.mul_((self._model.max_grad_norm / (flat.gradients.norm() + NORM_GUARD)).clamp_(max=1.0))
        group = self._policy.optimizer.param_groups[0]
        beta1, beta2 = group["betas"]
        steps = self._steps.add_(1.0).item()
        first.lerp_(flat.gradients, 1.0 - beta1)
        second.mul_(beta2).addcmul_(flat.gradients, flat.gradients, value=1.0 - beta2)
        denominator = second.sqrt().div_(math.sqrt(1.0 - beta2**steps)).add_(group["eps"])
        flat.values.addcdiv_(first, denominator, value=-group["lr"] / (1.0 - beta1**steps))
        return losses

    def gradients(self, batch: Minibatch, clip: float) -> StepLosses:
        """Compute the gradient of a minibatch's loss, and leave it with the parameters.

        Args:
            batch: the samples.
            clip: clip range of the probability ratio.
        """
        n, advantages = len(batch.returns), batch.advantages
        layers, valued = self.actor.activations(batch.observations), self.critic.activations(batch.observations)
        variance = torch.exp(2.0 * self._policy.log_std)
        apart = batch.actions - layers[-1]
        scaled = apart / variance
        log_ratio = log_probabilities(apart, self._policy.log_std) - batch.log_probs
        ratio = torch.exp(log_ratio)
        surrogate = torch.minimum(advantages * ratio, advantages * ratio.clamp(1.0 - clip, 1.0 + clip))
        # Where the clipped term is the smaller one, it does not depend on the policy.
        free = torch.where(advantages > 0, ratio <= 1.0 + clip, ratio >= 1.0 - clip)
        weight = torch.where(free, advantages * ratio, 0.0).mul_(-1.0 / n)
        self.actor.backward(layers, scaled.mul_(weight[:, None]))
        error = valued[-1][:, 0] - batch.returns
        self.critic.backward(valued, (error * (2.0 * self._model.vf_coef / n))[:, None])
        return StepLosses(
            -surrogate.mean(),
            (error**2).mean(),
            (ratio - 1.0 - log_ratio).mean(),
            ((ratio - 1.0).abs() > clip).float().mean(),
        )

    def _adopt_optimizer(self) -> None:
        """Let the optimiser's own state, which is saved and loaded, be views of the moments here.

        Loading a checkpoint gives the optimiser tensors of its own: these are copied in.
        """
        state = self._policy.optimizer.state
        for parameter, first, second in zip(
            self._flat.parameters, *map(self._flat.views, self._moments), strict=True
        ):
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


def log_probabilities(apart: Tensor, log_std: Tensor) -> Tensor:
    """Logarithms of the densities of actions under a diagonal normal distribution, (n,).

    Args:
        apart: actions minus means, (n, actions).
        log_std: logarithms of the standard deviations, (actions,).
    """
    scaled = apart * torch.exp(-log_std)
    constant = log_std.sum() + 0.5 * math.log(2.0 * math.pi) * len(log_std)
    return (scaled * scaled).sum(1).mul_(-0.5).sub_(constant)
