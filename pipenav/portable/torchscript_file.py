"""A policy as a TorchScript module, which PyTorch runs from C++ too: scaling, the perceptron and clipping inside."""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipenav.policies.file import Array32
from pipenav.policies.policy import Policy
from pipenav.portable.interface import METADATA_KEY, action_scale, metadata

if TYPE_CHECKING:
    import torch

EXTRA_FILE = f"{METADATA_KEY}.json"
"""Name of the member that holds the text of `metadata`; `torch.jit.load(..., _extra_files=...)` gives it."""


def torchscript_bytes(policy: Policy) -> bytes:
    """The policy as a TorchScript module.

    It takes unscaled observations, (n, size) float32, and gives two tensors: actions, (n, action_size) in [-1, 1], and
    the same in physical units.
    """
    import torch

    buffer = io.BytesIO()
    with _quiet():
        example = torch.zeros((2, len(policy.observation_scale)), dtype=torch.float32)
        traced = torch.jit.trace(_module(policy), example)  # type: ignore[no-untyped-call]
        torch.jit.save(traced, buffer, _extra_files={EXTRA_FILE: metadata(policy)})
    return buffer.getvalue()


def torchscript_runner(content: bytes) -> Callable[[Array32], Array32]:
    """The module as a function of unscaled observations, (n, size) float32: only for bytes that were just written."""
    import torch

    with _quiet():
        module = torch.jit.load(io.BytesIO(content))  # type: ignore[no-untyped-call]

    def act(observation: NDArray[np.float32]) -> Array32:
        with torch.no_grad():
            actions, _ = module(torch.from_numpy(observation))
        return np.asarray(actions.numpy(), np.float32)

    return act


def _module(policy: Policy) -> torch.nn.Module:
    """The policy as a module of PyTorch."""
    import torch

    class Actor(torch.nn.Module):
        observation_scale: torch.Tensor
        action_scale: torch.Tensor

        def __init__(self) -> None:
            super().__init__()
            self.register_buffer("observation_scale", torch.tensor(policy.observation_scale))
            self.register_buffer("action_scale", torch.tensor(action_scale(policy.header)))
            steps: list[torch.nn.Module] = []
            for weight, bias in policy.layers:
                linear = torch.nn.Linear(*weight.shape)
                linear.weight, linear.bias = (torch.nn.Parameter(torch.tensor(x)) for x in (weight.T.copy(), bias))
                steps += [linear, torch.nn.Tanh()]
            self.layers = torch.nn.Sequential(*steps[:-1])

        def forward(self, observation: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
            action = self.layers(observation / self.observation_scale).clamp(-1.0, 1.0)
            return action, action * self.action_scale

    return Actor().eval().requires_grad_(False)


class _quiet(warnings.catch_warnings):
    """Without PyTorch's advice to export by other means, which give no file that C++ alone can run."""

    def __enter__(self) -> None:
        super().__enter__()
        warnings.simplefilter("ignore", DeprecationWarning)
        warnings.simplefilter("ignore", FutureWarning)
