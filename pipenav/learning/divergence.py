"""The end of a training at a value that is not finite, and what is kept of it."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import torch

from pipenav.errors import PipenavError
from pipenav.learning.training_folder import TrainingFolder
from pipenav.pipes.pipe import Pipe
from pipenav.storage.atomic_files import atomic_write


class TrainingDiverged(PipenavError):
    """A value became infinite or not a number; the state that caused it was saved."""

    def __init__(self, steps: int, folder: TrainingFolder) -> None:
        super().__init__(
            f"training stopped after {steps} steps at a value that is not finite: the state that caused "
            f"it is in {folder.diverged}, the last sound policy in {folder.last} if there is one."
        )


class Seen(NamedTuple):
    """A control step of all robots, as the learner saw it.

    Attributes:
        before: observations that the actions answer, (n, size).
        actions: actions, (n, size).
        observations: observations after the step, (n, size).
        rewards: rewards of the step, (n,).
    """

    before: np.ndarray
    actions: np.ndarray
    observations: np.ndarray
    rewards: np.ndarray


def is_sound(policy: Any, observations: np.ndarray) -> bool:
    """Whether all weights of an actor-critic policy are finite, and what it answers to some observations.

    Args:
        policy: policy of Stable-Baselines3.
        observations: scaled observations, (k, size).
    """
    with torch.no_grad():
        weights = torch.nn.utils.parameters_to_vector(policy.parameters())
        actor, critic = policy.mlp_extractor(torch.as_tensor(observations, dtype=torch.float32))
        answers = (policy.action_net(actor), policy.value_net(critic))
        return all(bool(torch.isfinite(values).all()) for values in (weights, *answers))


def write_cause(folder: TrainingFolder, steps: int, seen: Seen, pipes: Sequence[Pipe | None]) -> None:
    """Write the state of the robots with values that are not finite, or of all where each is, as diverged.json."""
    bad = ~(np.isfinite(seen.observations).all(axis=1) & np.isfinite(seen.rewards))
    indices = (np.flatnonzero(bad) if bad.any() else np.arange(len(seen.rewards))).tolist()
    cause = {
        "steps": steps,
        "robots": indices,
        "pipes": [pipe.name if (pipe := pipes[i]) else "" for i in indices],
        "observations": _printable(seen.observations[indices]),
        "rewards": _printable(seen.rewards[indices]),
        "observations_before": _printable(seen.before[indices]),
        "actions": _printable(seen.actions[indices]),
    }
    atomic_write(folder.diverged, json.dumps(cause, indent=1) + "\n")


def _printable(values: np.ndarray) -> list[Any]:
    """Nested lists in which non-finite numbers are strings, since JSON has none."""
    return [
        _printable(value) if isinstance(value, np.ndarray) else float(value) if math.isfinite(value) else str(value)
        for value in values
    ]
