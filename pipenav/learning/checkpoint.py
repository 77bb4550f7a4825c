"""The state that a training goes on from: weights and optimiser state as safetensors, which cannot run code."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from stable_baselines3 import PPO

from pipenav.errors import PipenavError
from pipenav.storage.atomic_files import atomic_write

UNREADABLE = (OSError, SafetensorError, RuntimeError, KeyError, TypeError, ValueError)
"""Exceptions that a corrupt file, or one of another network, may raise."""


class Checkpoint(NamedTuple):
    """Progress of a training, kept beside its weights.

    Attributes:
        steps: control steps.
        seconds: seconds of training.
        best_success: success of the best check; -1 before any.
    """

    steps: int = 0
    seconds: float = 0.0
    best_success: float = -1.0


def save_checkpoint(path: Path, model: PPO, checkpoint: Checkpoint) -> None:
    """Write weights, optimiser state and progress in one atomic file."""
    tensors = {f"policy.{name}": value for name, value in model.policy.state_dict().items()}
    for index, slots in model.policy.optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer.{index}.{name}": torch.as_tensor(value) for name, value in slots.items()}
    metadata = {"pipenav": json.dumps(checkpoint._asdict())}
    contiguous = {name: value.detach().contiguous().clone() for name, value in tensors.items()}
    atomic_write(path, save(contiguous, metadata))


def load_checkpoint(path: Path, model: PPO) -> Checkpoint:
    """Bring a fresh model to where a training stopped.

    Raises:
        PipenavError: a file that is corrupt or of another network.
    """
    try:
        checkpoint, tensors = _read(path)
        _load_policy(model, tensors)
        _load_optimizer(model, tensors)
    except UNREADABLE as error:
        raise PipenavError(f"{path} cannot be resumed from: {error}.") from error
    model.num_timesteps = checkpoint.steps
    return checkpoint


def load_weights(path: Path, model: PPO) -> None:
    """Give a fresh model what another training has learned, policy and value function, and nothing else of it.

    Raises:
        PipenavError: a file that is corrupt or of another network.
    """
    try:
        _load_policy(model, _read(path).tensors)
    except UNREADABLE as error:
        raise PipenavError(f"{path} cannot be started from: {error}.") from error


class _Contents(NamedTuple):
    checkpoint: Checkpoint
    tensors: dict[str, torch.Tensor]


def _read(path: Path) -> _Contents:
    with safe_open(path, framework="pt") as file:
        checkpoint = Checkpoint(**json.loads(file.metadata()["pipenav"]))
        tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118  # safe_open is no dict
    return _Contents(checkpoint, tensors)


def _load_policy(model: PPO, tensors: dict[str, torch.Tensor]) -> None:
    weights = {name.removeprefix("policy."): t for name, t in tensors.items() if name.startswith("policy.")}
    model.policy.load_state_dict(weights)


def _load_optimizer(model: PPO, tensors: dict[str, torch.Tensor]) -> None:
    whole = model.policy.optimizer.state_dict()
    slots: dict[int, dict[str, torch.Tensor]] = {}
    for name, value in tensors.items():
        if name.startswith("optimizer."):
            _, index, slot = name.split(".", 2)
            slots.setdefault(int(index), {})[slot] = value
    whole["state"] = slots
    model.policy.optimizer.load_state_dict(whole)
