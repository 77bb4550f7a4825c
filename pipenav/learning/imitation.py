"""A supervised start: a policy learns to do what recordings show, before PPO goes on with it.

Behaviour cloning: the mean squared error of the actions' means, which is the likelihood of the recorded actions under
a normal distribution of fixed width (D. Pomerleau, "ALVINN" (1989), for the idea). The value function learns the
recordings' discounted rewards beside it, where the training is rewarded in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import torch
from torch import nn

from pipenav.learning.config import RecordingsConfig, TrainConfig
from pipenav.learning.learner import Learner
from pipenav.learning.progress import TrainingProgress
from pipenav.learning.recordings import Lessons

LABEL = "supervised start"
"""Words for it in reports."""


def imitate(
    model: Learner,
    lessons: Lessons,
    config: TrainConfig,
    report: Callable[[TrainingProgress], None] | None = None,
) -> None:
    """Fit a fresh model's policy, and its value function, to lessons; the optimiser of PPO stays as it is.

    Args:
        model: the model.
        lessons: the lessons.
        config: configuration of the training; its seed orders the lessons.
        report: called after each pass over them.
    """
    settings, policy = config.recordings, model.policy
    extractor = policy.mlp_extractor
    actor = nn.Sequential(extractor.policy_net, policy.action_net)
    critic = nn.Sequential(extractor.value_net, policy.value_net)
    observations, actions = torch.from_numpy(lessons.observations), torch.from_numpy(lessons.actions)
    returns = None if lessons.returns is None else torch.from_numpy(lessons.returns)[:, None]
    parameters = [*actor.parameters(), *([] if returns is None else critic.parameters())]
    optimizer = torch.optim.Adam(parameters, settings.learning_rate)
    rng = np.random.default_rng([config.seed, len(actions)])
    for epoch in range(settings.epochs):
        optimizer.param_groups[0]["lr"] = settings.learning_rate * (1.0 - epoch / settings.epochs)
        for rows in _batches(settings, rng, len(actions)):
            seen = observations[rows]
            loss = nn.functional.mse_loss(actor(seen), actions[rows])
            if returns is not None:
                loss = loss + nn.functional.mse_loss(critic(seen), returns[rows])
            optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]  # as PyTorch has it
            optimizer.step()
        if report is not None:
            report(_progress((epoch + 1) / settings.epochs))
    optimizer.zero_grad()


def _batches(settings: RecordingsConfig, rng: np.random.Generator, n: int) -> list[torch.Tensor]:
    """Rows of each gradient step of a pass, in a new order."""
    return list(torch.split(torch.from_numpy(rng.permutation(n)), settings.batch_size))


def _progress(share: float) -> TrainingProgress:
    return TrainingProgress(LABEL, 0, math.nan, math.nan, math.nan, math.nan, imitated=share)
