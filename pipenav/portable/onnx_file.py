"""A policy as an ONNX model: scaling, the perceptron and clipping as operators, names and units as metadata."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipenav.errors import PipenavError
from pipenav.policies.file import Array32
from pipenav.policies.policy import Policy
from pipenav.portable.interface import ACTION, METADATA_KEY, OBSERVATION, PHYSICAL_ACTION, action_scale, metadata

OPSET, IR_VERSION = 13, 7
"""Versions of the operators and of the file that are written: those of 2020, which every runtime of today reads."""

BATCH = "n"
"""Name of the model's free dimension: the number of robots."""

INSTALL = "pip install 'pipenav[export]'"
"""Advice where the libraries are missing."""


def onnx_bytes(policy: Policy) -> bytes:
    """The policy as an ONNX model; the same bytes for the same policy.

    Its input `observation`, (n, size) float32, is unscaled. Its outputs are `action`, (n, action_size) in [-1, 1], and
    `physical_action`, the same in physical units.

    Raises:
        PipenavError: onnx is not installed.
    """
    helper, numpy_helper = _onnx("onnx.helper"), _onnx("onnx.numpy_helper")
    constants: dict[str, Array32] = {
        "observation_scale": policy.observation_scale,
        "low": np.array(-1, np.float32),
        "high": np.array(1, np.float32),
        "action_scale": action_scale(policy.header),
    }
    nodes = [helper.make_node("Div", [OBSERVATION, "observation_scale"], ["x0"], "scale")]
    for i, (weight, bias) in enumerate(policy.layers):
        constants |= {f"weight{i}": weight, f"bias{i}": bias}
        nodes.append(helper.make_node("Gemm", [f"x{i}", f"weight{i}", f"bias{i}"], [f"sum{i}"], f"layer{i}"))
        if i < len(policy.layers) - 1:
            nodes.append(helper.make_node("Tanh", [f"sum{i}"], [f"x{i + 1}"], f"tanh{i}"))
    nodes.append(helper.make_node("Clip", [f"sum{len(policy.layers) - 1}", "low", "high"], [ACTION], "clip"))
    nodes.append(helper.make_node("Mul", [ACTION, "action_scale"], [PHYSICAL_ACTION], "to_physical"))
    graph = helper.make_graph(
        nodes,
        "policy",
        [_tensor(OBSERVATION, len(policy.observation_scale))],
        [_tensor(name, len(policy.header.action)) for name in (ACTION, PHYSICAL_ACTION)],
        [numpy_helper.from_array(np.ascontiguousarray(array), name) for name, array in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], producer_name="pipenav")
    model.ir_version = IR_VERSION
    helper.set_model_props(model, {METADATA_KEY: metadata(policy)})
    _onnx("onnx.checker").check_model(model, full_check=True)
    content: bytes = model.SerializeToString(deterministic=True)
    return content


def onnx_runner(content: bytes) -> Callable[[Array32], Array32]:
    """The model as a function of unscaled observations, (n, size) float32, run by onnxruntime on one thread.

    Raises:
        PipenavError: onnxruntime is not installed.
    """
    runtime = _onnx("onnxruntime")
    options = runtime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = runtime.InferenceSession(content, options, providers=["CPUExecutionProvider"])

    def act(observation: NDArray[np.float32]) -> Array32:
        (actions,) = session.run([ACTION], {OBSERVATION: observation})
        return np.asarray(actions, np.float32)

    return act


def _tensor(name: str, size: int) -> Any:
    return _onnx("onnx.helper").make_tensor_value_info(name, _onnx("onnx").TensorProto.FLOAT, [BATCH, size])


def _onnx(module: str) -> Any:
    """A module of the extra `export`."""
    from importlib import import_module

    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise PipenavError(f"{error.name} is not installed, which ONNX needs: {INSTALL}.") from error
