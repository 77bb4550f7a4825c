"""Contents of a policy file, which may come from a stranger: two members, checked in every respect before use."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from pipenav.errors import ConfigError, PipenavError, dotted, first_problem
from pipenav.policies.header import FORMAT_VERSION, RATE_HZ, PolicyHeader, action_parts, observation_parts
from pipenav.storage.text_files import as_text, checked_json, shown_path
from pipenav.tasks.registry import task_of

Array32 = NDArray[np.float32]

HEADER_MEMBER, WEIGHTS_MEMBER = "pipenav.json", "policy.safetensors"
MAX_FILE, MAX_HEADER, MAX_WEIGHTS = 16 << 20, 1 << 20, 8 << 20
"""Largest sizes in bytes: a hundred times what an arm's policy takes, and small enough to read whole."""

NEW_COPY = "get a new copy from its author"
"""Advice about a file that is damaged."""


class PolicyFileError(PipenavError):
    """A policy file that cannot be used: the message names the file, the problem and the remedy."""

    def __init__(self, path: Path, problem: str, remedy: str) -> None:
        # The text may quote the file, and the file may come from a stranger: no control characters, no flood.
        shown = "".join(c if c.isprintable() else "?" for c in problem)
        shown = shown if len(shown) <= 300 else f"{shown[:300]}..."
        super().__init__(f"policy file {shown_path(path)} {shown}: {remedy}.")


class Layer(NamedTuple):
    """A linear layer: weight (inputs, outputs), bias (outputs,)."""

    weight: Array32
    bias: Array32


class Contents(NamedTuple):
    """Contents of a policy file.

    Attributes:
        header: header of the file.
        observation_scale: numbers that observations are divided by, (size,).
        layers: linear layers of the actor, in order.
    """

    header: PolicyHeader
    observation_scale: Array32
    layers: list[Layer]


class _Members(NamedTuple):
    """Bytes of the two members that pipenav reads."""

    header: bytes
    weights: bytes


def parse(path: Path, content: bytes) -> Contents:
    """Contents of a policy file.

    Args:
        path: the file, for messages only.
        content: its bytes.

    Raises:
        PolicyFileError: something is wrong with the file.
    """
    if len(content) > MAX_FILE:
        raise PolicyFileError(path, f"is larger than {MAX_FILE >> 20} MiB", "policies are smaller; give the right file")
    members = _read_members(path, content)
    header = _parse_header(path, members.header)
    tensors = _parse_weights(path, members.weights)
    layers = _chain(path, header, tensors)  # also checks that the scale is there
    return Contents(header, tensors["observation_scale"], layers)


def _read_members(path: Path, content: bytes) -> _Members:
    damaged, get_whole = "is damaged or cut short", "copy it again, or save it again"
    if not content:
        raise PolicyFileError(path, "is empty", get_whole)
    if not content.startswith(b"PK"):
        raise PolicyFileError(path, "is not a zip file", "give a best.zip that `pipenav train` wrote")
    try:
        archive = zipfile.ZipFile(io.BytesIO(content))
        names = [info.filename for info in archive.infolist()]
        if len(set(names)) < len(names):
            raise PolicyFileError(path, "holds two members of one name", f"do not trust it; {NEW_COPY}")
        if HEADER_MEMBER not in names and WEIGHTS_MEMBER not in names:
            sb3 = "_stable_baselines3_version" in names
            problem = "was made by Stable-Baselines3 alone" if sb3 else "is a zip, but not of a policy"
            problem += f" and lacks {HEADER_MEMBER} and {WEIGHTS_MEMBER}"
            raise PolicyFileError(path, problem, "train it with `pipenav train`")
        header = _read_member(path, archive, HEADER_MEMBER, MAX_HEADER)
        weights = _read_member(path, archive, WEIGHTS_MEMBER, MAX_WEIGHTS)
    except PolicyFileError:
        raise
    except Exception as error:  # zipfile raises errors of many types on a broken file
        raise PolicyFileError(path, f"{damaged} ({type(error).__name__})", get_whole) from error
    return _Members(header, weights)


def _read_member(path: Path, archive: zipfile.ZipFile, name: str, limit: int) -> bytes:
    info = archive.getinfo(name)
    # Other methods than these two can unpack a few bytes to more memory than the limit before they give any out.
    if info.file_size > limit or info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        problem = f"holds a {name} that is larger than {limit >> 20} MiB or is packed unlike a policy"
        raise PolicyFileError(path, problem, f"do not trust it; {NEW_COPY}")
    with archive.open(info) as member:
        return member.read(limit + 1)


class _Stamp(BaseModel):
    """The part of the header that tells a newer file from a broken one."""

    format: str
    version: int


def _parse_header(path: Path, text: bytes) -> PolicyHeader:
    try:
        checked_json(as_text(text, "it"), "it")
        stamp = _Stamp.model_validate_json(text)
        if stamp.format == "pipenav-policy" and stamp.version > FORMAT_VERSION:
            problem = f"has policy format {stamp.version}; this pipenav reads format {FORMAT_VERSION}"
            raise PolicyFileError(path, problem, "update pipenav")
        header = PolicyHeader.model_validate_json(text)
        json.dumps(header.model_dump(), allow_nan=False)
    except ConfigError as error:
        problem = f"holds an unusable {HEADER_MEMBER}: {str(error).rstrip('.')}"
        raise PolicyFileError(path, problem, NEW_COPY) from error
    except ValidationError as error:
        first = first_problem(error)
        if first["type"] == "extra_forbidden":
            problem = f"holds the unknown key {dotted(first['loc'])!r} in {HEADER_MEMBER}"
        else:
            problem = f"holds an unusable {ConfigError.from_validation(HEADER_MEMBER, error)}".rstrip(".")
        raise PolicyFileError(path, problem, NEW_COPY) from error
    except ValueError as error:
        raise PolicyFileError(path, f"holds infinite numbers in {HEADER_MEMBER}", "save it again") from error
    same_meaning = (
        header.observation == observation_parts(header.robot, header.task)
        and header.action == action_parts(header.robot, header.task)
        and abs(header.rate_hz / RATE_HZ - 1) < 1e-6
    )
    if not same_meaning:
        made = header.versions.get("pipenav", "of unknown version")
        problem = f"was made by pipenav {made}, whose observation, action or rate differ from this one's"
        raise PolicyFileError(path, problem, "train it again with this version, or use that one")
    return header


def _parse_weights(path: Path, data: bytes) -> dict[str, Array32]:
    save_again = "save it again"
    try:
        tensors: dict[str, Array32] = safetensors.numpy.load(data)
    except Exception as error:  # a broken header surfaces as SafetensorError, an unknown number format as KeyError, ...
        raise PolicyFileError(path, f"holds an unreadable {WEIGHTS_MEMBER} ({error})", save_again) from error
    for name, tensor in tensors.items():
        if tensor.dtype != np.float32:
            raise PolicyFileError(path, f"holds {name} as {tensor.dtype} instead of float32", save_again)
        if not np.isfinite(tensor).all():
            raise PolicyFileError(path, f"holds numbers in {name} that are not finite", "train it again")
    return tensors


def _chain(path: Path, header: PolicyHeader, tensors: dict[str, Array32]) -> list[Layer]:
    """Layers in order, their shapes checked from the observation through to the action."""
    depth = (len(tensors) - 1) // 2
    expected = ["observation_scale", *(f"layer{i}.{part}" for i in range(depth) for part in ("weight", "bias"))]
    if depth < 1 or sorted(tensors) != sorted(expected):
        problem = (
            f"holds weights {', '.join(sorted(tensors)) or 'of no layer'} instead of layer0.weight, layer0.bias, ..."
        )
        raise PolicyFileError(path, problem, "save it again")
    size, actions = sum(part.size for part in header.observation), len(header.action)
    _check_shape(path, "observation_scale", tensors["observation_scale"], (size,))
    scale = task_of(header.task).observation_scale(header.robot)
    if not np.allclose(tensors["observation_scale"], scale, rtol=1e-5, atol=0.0):
        problem = "was made with another observation scale than this pipenav's"
        raise PolicyFileError(path, problem, "train it again with this version")
    layers = []
    inputs = size
    for i in range(depth):
        weight, bias = tensors[f"layer{i}.weight"], tensors[f"layer{i}.bias"]
        outputs = actions if i == depth - 1 else max(bias.size, 1)
        _check_shape(path, f"layer{i}.bias", bias, (outputs,))
        _check_shape(path, f"layer{i}.weight", weight, (outputs, inputs))
        layers.append(Layer(np.ascontiguousarray(weight.T), bias))
        inputs = outputs
    return layers


def _check_shape(path: Path, name: str, tensor: Array32, shape: tuple[int, ...]) -> None:
    if tensor.shape != shape:
        raise PolicyFileError(path, f"holds {name} of shape {tensor.shape} instead of {shape}", "save it again")
