"""Tanh perceptrons whose outputs and gradients are computed by hand, in the order of operations of the layers.

Autograd and the layers' Python take four fifths of the time of an update of networks this small. The weights stay those
of Stable-Baselines3's policy: they only come to lie in one piece of memory, with their gradients in another.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor, nn

from pipenav.errors import PipenavError


class FlatParameters:
    """Parameters of a network in one piece of memory, where the optimiser goes over all of them at once.

    Args:
        parameters: the parameters, which are views of `values` from now on.

    Attributes:
        parameters: the parameters.
        values: all their values, (size,).
        gradients: place for the gradient of each, (size,).
    """

    def __init__(self, parameters: Sequence[nn.Parameter]) -> None:
        self.parameters = list(parameters)
        self.values = torch.cat([parameter.detach().flatten() for parameter in self.parameters])
        self.gradients = torch.zeros_like(self.values)
        for parameter, view in zip(self.parameters, self.views(self.values), strict=True):
            parameter.data = view
        self._gradients = dict(zip(map(id, self.parameters), self.views(self.gradients), strict=True))

    def views(self, flat: Tensor) -> list[Tensor]:
        """Parts of a tensor of all values, (size,), that belong to each parameter, in their shapes."""
        parts = torch.split(flat, [parameter.numel() for parameter in self.parameters])
        return [part.view_as(parameter) for part, parameter in zip(parts, self.parameters, strict=True)]

    def gradient(self, parameter: Tensor) -> Tensor:
        """Place for the gradient of one of the parameters, in its shape."""
        return self._gradients[id(parameter)]


class _Layer(NamedTuple):
    weight: Tensor
    bias: Tensor
    weight_gradient: Tensor
    bias_gradient: Tensor
    width: int


class Workspace:
    """Memory for what networks compute, kept from call to call: to get and return it takes longer than to fill it.

    Networks that are used one after the other share it, so that it stays in the processor's cache.
    """

    def __init__(self) -> None:
        self._kept: dict[tuple[str, int, int, int], Tensor] = {}

    def tensor(self, use: str, layer: int, n: int, width: int) -> Tensor:
        """The tensor (n, width) for a use in a layer, with whatever it holds from before."""
        key = use, layer, n, width
        if key not in self._kept:
            self._kept[key] = torch.empty(n, width)
        return self._kept[key]


class Perceptron:
    """Fully connected layers with tanh between them.

    Args:
        modules: linear layers and tanhs in turn, as Stable-Baselines3's policies hold them, and the linear output.
        flat: the parameters that those of the layers belong to.
        workspace: memory for outputs and gradients.

    Raises:
        PipenavError: layers of another kind.
    """

    def __init__(self, modules: Sequence[nn.Module], flat: FlatParameters, workspace: Workspace) -> None:
        linear = [module for module in modules if isinstance(module, nn.Linear)]
        kinds = [nn.Tanh if i % 2 else nn.Linear for i in range(len(modules))]
        if not (modules and [type(module) for module in modules] == kinds and isinstance(modules[-1], nn.Linear)):
            raise PipenavError("only fully connected tanh networks can be trained: leave the network to its settings.")
        self._workspace = workspace
        self._layers = [
            _Layer(m.weight.data, m.bias.data, flat.gradient(m.weight), flat.gradient(m.bias), m.out_features)
            for m in linear
        ]

    def __call__(self, inputs: Tensor) -> Tensor:
        """Outputs, (n, outputs), for inputs (n, inputs); see `activations` for how long they hold."""
        return self.activations(inputs)[-1]

    def activations(self, inputs: Tensor) -> list[Tensor]:
        """Inputs of each layer, and last the outputs, (n, width) each.

        They hold until a network of the same workspace is called with as many inputs.
        """
        values = [inputs]
        for i, layer in enumerate(self._layers):
            out = self._workspace.tensor("values", i, inputs.shape[0], layer.width)
            torch.addmm(layer.bias, values[i], layer.weight.t(), out=out)
            values.append(out.tanh_() if i + 1 < len(self._layers) else out)
        return values

    def backward(self, activations: Sequence[Tensor], gradient: Tensor) -> None:
        """Put the gradients of all weights and biases into their places.

        Args:
            activations: what `activations` returned; it is used up.
            gradient: gradient of a loss by the outputs, (n, outputs).
        """
        for i in range(len(self._layers) - 1, -1, -1):
            layer, below = self._layers[i], activations[i]
            torch.mm(gradient.t(), below, out=layer.weight_gradient)
            torch.sum(gradient, 0, out=layer.bias_gradient)
            if i:
                out = self._workspace.tensor("gradients", i, *below.shape)
                gradient = torch.mm(gradient, layer.weight, out=out)
                gradient.addcmul_(gradient, below.square_(), value=-1.0)  # tanh' = 1 - tanh^2
