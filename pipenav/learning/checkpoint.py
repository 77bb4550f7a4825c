"""The state that a training goes on from: weights and optimiser state as safetensors, which cannot run code."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import torch
from pydantic import Field
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from stable_baselines3 import PPO

from pipenav.arrays import Table
from pipenav.errors import PipenavError, shown
from pipenav.learning.stage_tables import MOST_STAGES, MOST_STEPS
from pipenav.storage.atomic_files import atomic_write
from pipenav.storage.text_files import parse_json, read_bytes

UNREADABLE = (PipenavError, OSError, SafetensorError, RuntimeError, LookupError, TypeError, ValueError)
"""Exceptions that a corrupt file, or one of another network, may raise."""


INPUT_LAYERS = ("mlp_extractor.policy_net.0.weight", "mlp_extractor.value_net.0.weight")
"""Weights of the observation in the policy and in the value function, (width, observation)."""

LARGEST_FILE = 256 << 20
"""Largest checkpoint [bytes]: three times the weights and the optimiser's state of the largest networks."""


NO_CHECK = -1.0
"""Success of the best check before there is any."""


class Checkpoint(Table):
    """Progress of a training, kept beside its weights."""

    steps: int = Field(0, ge=0, le=MOST_STEPS, description="control steps")
    seconds: float = Field(0.0, ge=0, description="seconds of training")
    best_success: float = Field(NO_CHECK, ge=NO_CHECK, le=1, description="success of the best check; -1 before any")
    stage: int = Field(1, ge=1, le=MOST_STAGES, description="number of the stage that the training was in")


def save_checkpoint(path: Path, model: PPO, checkpoint: Checkpoint) -> None:
    """Write weights, optimiser state and progress in one atomic file."""
    tensors = {f"policy.{name}": value for name, value in model.policy.state_dict().items()}
    for index, slots in model.policy.optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer.{index}.{name}": torch.as_tensor(value) for name, value in slots.items()}
    metadata = {"pipenav": json.dumps(checkpoint.model_dump())}
    contiguous = {name: value.detach().contiguous().clone() for name, value in tensors.items()}
    atomic_write(path, save(contiguous, metadata))


def load_checkpoint(path: Path, model: PPO, stage: int = 1) -> Checkpoint:
    """Bring a fresh model to where a training stopped.

    Args:
        path: file of the checkpoint.
        model: the model.
        stage: number of the stage that goes on. Where it is a later one than the checkpoint's it may observe more at
            the end of the observation: the weights of that begin at 0, so that the policy begins as it was.

    Raises:
        PipenavError: a file that is corrupt or of another network.
    """
    try:
        checkpoint, tensors = _read(path)
        if checkpoint.stage < stage:
            tensors = _widened(tensors, model)
        _load_policy(model, tensors)
        _load_optimizer(model, tensors)
    except UNREADABLE as error:
        raise PipenavError(f"{path} cannot be resumed from: {_first_line(error)}.") from error
    model.num_timesteps = checkpoint.steps
    return checkpoint


def steps_done(path: Path) -> int:
    """Control steps that a training has done.

    Raises:
        PipenavError: a file that is corrupt.
    """
    try:
        return _read(path).checkpoint.steps
    except UNREADABLE as error:
        raise PipenavError(f"{path} cannot be resumed from: {_first_line(error)}.") from error


def load_weights(path: Path, model: PPO) -> None:
    """Give a fresh model what another training has learned, policy and value function, and nothing else of it.

    Raises:
        PipenavError: a file that is corrupt or of another network.
    """
    try:
        _load_policy(model, _read(path).tensors)
    except UNREADABLE as error:
        raise PipenavError(f"{path} cannot be started from: {_first_line(error)}.") from error


def _first_line(error: BaseException) -> str:
    """The problem in short: PyTorch names every tensor that does not fit."""
    text = " ".join(str(error).split())
    return shown(text, quoted=False, longest=300).rstrip(".")


class _Contents(NamedTuple):
    checkpoint: Checkpoint
    tensors: dict[str, torch.Tensor]


def _read(path: Path) -> _Contents:
    read_bytes(path, LARGEST_FILE)
    with safe_open(path, framework="pt") as file:
        metadata = parse_json((file.metadata() or {})["pipenav"], "its header")
        checkpoint = Checkpoint.model_validate(metadata)
        tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118  # safe_open is no dict
    for name, tensor in tensors.items():
        if tensor.dtype != torch.float32 or not torch.isfinite(tensor).all():
            raise ValueError(f"{shown(name)} holds numbers that are not finite or of another kind than float32")
    return _Contents(checkpoint, tensors)


def _widened(tensors: dict[str, torch.Tensor], model: PPO) -> dict[str, torch.Tensor]:
    """Tensors of a checkpoint with columns of zeros for what a model observes beyond the checkpoint's."""
    wider = dict(tensors)
    for index, (name, parameter) in enumerate(_trained_parameters(model)):
        if name not in INPUT_LAYERS:
            continue
        for key in (f"policy.{name}", f"optimizer.{index}.exp_avg", f"optimizer.{index}.exp_avg_sq"):
            if key in tensors and tensors[key].dim() == 2:
                more = max(parameter.shape[1] - tensors[key].shape[1], 0)
                wider[key] = torch.nn.functional.pad(tensors[key], (0, more))
    return wider


def _trained_parameters(model: PPO) -> list[tuple[str, torch.nn.Parameter]]:
    """Parameters of the optimiser with their names, in its order."""
    names = {id(parameter): name for name, parameter in model.policy.named_parameters()}
    return [(names[id(one)], one) for group in model.policy.optimizer.param_groups for one in group["params"]]


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
    _check_slots(slots, [parameter for _, parameter in _trained_parameters(model)])
    whole["state"] = slots
    model.policy.optimizer.load_state_dict(whole)


def _check_slots(slots: dict[int, dict[str, torch.Tensor]], parameters: list[torch.nn.Parameter]) -> None:
    """Refuse a state of the optimiser that is not that of these parameters.

    Raises:
        ValueError: with the first parameter whose state does not fit.
    """
    for index, given in slots.items():
        if not 0 <= index < len(parameters):
            raise ValueError(f"it holds the state of {index + 1} parameters, the network has {len(parameters)}")
        shapes = {name: tensor.shape for name, tensor in given.items()}
        moments, shape = ("exp_avg", "exp_avg_sq"), parameters[index].shape
        if shapes != {"step": torch.Size([])} | dict.fromkeys(moments, shape) or given["step"] < 0:
            raise ValueError(f"the state of parameter {index} does not fit the network")
        if (given["exp_avg_sq"] < 0).any():
            raise ValueError(f"the state of parameter {index} has a negative square")
