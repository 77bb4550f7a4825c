"""What a run needs to go on: weights and optimiser state as safetensors, which cannot run code when read."""

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
"""What a corrupt file, or one of another network, may raise."""


class State(NamedTuple):
    """How far a run had come: control steps, seconds of training, success of its best check (-1 before any)."""

    steps: int
    seconds: float
    best_success: float


def save_state(path: Path, model: PPO, state: State) -> None:
    """Write weights, optimiser state and progress in one atomic file."""
    tensors = {f"policy.{name}": value for name, value in model.policy.state_dict().items()}
    for index, slots in model.policy.optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer.{index}.{name}": torch.as_tensor(value) for name, value in slots.items()}
    metadata = {"pipenav": json.dumps(state._asdict())}
    contiguous = {name: value.detach().contiguous().clone() for name, value in tensors.items()}
    atomic_write(path, save(contiguous, metadata))


def load_state(path: Path, model: PPO) -> State:
    """Bring a fresh model to where a run stopped.

    Raises:
        PipenavError: a file that is corrupt or of another network.
    """
    try:
        state, tensors = _load_policy(path, model)
        _load_optimizer(model, tensors)
    except UNREADABLE as error:
        raise PipenavError(f"{path} cannot be resumed from: {error}.") from error
    model.num_timesteps = state.steps
    return state


def load_weights(path: Path, model: PPO) -> None:
    """Give a fresh model what another run has learned, policy and value function, and nothing else of it.

    Raises:
        PipenavError: a file that is corrupt or of another network.
    """
    try:
        _load_policy(path, model)
    except UNREADABLE as error:
        raise PipenavError(f"{path} cannot be started from: {error}.") from error


def _load_policy(path: Path, model: PPO) -> tuple[State, dict[str, torch.Tensor]]:
    with safe_open(path, framework="pt") as file:
        state = State(**json.loads(file.metadata()["pipenav"]))
        tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118  # safe_open is no dict
    weights = {name.removeprefix("policy."): t for name, t in tensors.items() if name.startswith("policy.")}
    model.policy.load_state_dict(weights)
    return state, tensors


def _load_optimizer(model: PPO, tensors: dict[str, torch.Tensor]) -> None:
    whole = model.policy.optimizer.state_dict()
    slots: dict[int, dict[str, torch.Tensor]] = {}
    for name, value in tensors.items():
        if name.startswith("optimizer."):
            _, index, slot = name.split(".", 2)
            slots.setdefault(int(index), {})[slot] = value
    whole["state"] = slots
    model.policy.optimizer.load_state_dict(whole)
