"""The policy file `best.zip`: a Stable-Baselines3 zip with two members that pipenav itself runs policies from.

`pipenav.json` says what the policy was made for, `policy.safetensors` holds the actor's weights. Loading reads these
two and nothing else of the file, so the pickles that Stable-Baselines3 stores beside them never run: a policy from a
stranger cannot execute code. `docs/formats/policy-file.md` describes the format.
"""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray

from pipenav.errors import PipenavError, UnknownName
from pipenav.policies.file import HEADER_MEMBER, MAX_FILE, WEIGHTS_MEMBER, Array32, Layer, PolicyFileError, parse
from pipenav.policies.header import PolicyHeader, action_parts, header_for, robot_difference
from pipenav.robots.robot import RobotSpec
from pipenav.storage import shipped
from pipenav.storage.atomic_files import atomic_write
from pipenav.tasks.registry import TaskConfig, task_of

if TYPE_CHECKING:
    from stable_baselines3 import PPO

__all__ = [
    "Policy",
    "PolicyFileError",
    "PolicyHeader",
    "header_for",
    "load_policy",
    "policy_names",
    "resolve_policy",
    "save_policy",
]

TRANSIENT = ("_last_obs", "_last_episode_starts", "ep_info_buffer", "ep_success_buffer", "lr_schedule", "start_time")
"""Attributes that Stable-Baselines3 would store although it makes them anew on loading."""


class Policy:
    """A trained actor.

    Attributes:
        path: file that it came from.
        header: the robot and the task that it was made for, and how it was trained.
        observation_scale: numbers that each value of an observation must be divided by before `act`, (size,). A
            `TaskBatch` gives divided observations.
        layers: linear layers in order, tanh after each but the last.
    """

    def __init__(self, path: Path, header: PolicyHeader, observation_scale: Array32, layers: Sequence[Layer]) -> None:
        self.path, self.header, self.observation_scale = path, header, observation_scale
        self.layers = tuple(layers)

    def act(self, observation: NDArray[np.floating]) -> Array32:
        """Deterministic actions in [-1, 1], (n, action_size).

        A row's result does not depend on the other rows or on their number: BLAS picks its order of summation by the
        shape of the whole, einsum sums each row in the order of its inputs.

        Args:
            observation: scaled observations, as a `TaskBatch` gives them, (n, size).
        """
        x = np.asarray(observation, np.float32)
        for weight, bias in self.layers[:-1]:
            x = np.tanh(np.einsum("ni,io->no", x, weight) + bias)
        weight, bias = self.layers[-1]
        actions: Array32 = np.clip(np.einsum("ni,io->no", x, weight) + bias, -1.0, 1.0)
        return actions

    def require(self, robot: RobotSpec | None = None, task: TaskConfig | None = None) -> None:
        """Check that the policy was made for this robot and for these observations and actions.

        Raises:
            PolicyFileError: the policy was made for others; the message names the first difference. Prose in the
                robot's description may differ.
        """
        own, task = self.header, task or self.header.task
        train = "or train a policy for this one with pipenav train"
        if robot is not None and robot.name != own.robot.name:
            problem = f"was made for robot {own.robot.name!r}, not {robot.name!r}"
            raise PolicyFileError(self.path, problem, f"use that robot, {train} --robot")
        if robot is not None and (difference := robot_difference(own.robot, robot)):
            problem = f"was made for another robot of the name {robot.name!r}; there, {difference}"
            raise PolicyFileError(self.path, problem, f"use that description, {train} --robot")
        for key in ("kind", "observation", "control"):
            made, asked = getattr(own.task, key), getattr(task, key)
            if made != asked:
                problem = f"was made for {key} {made!r}, not {asked!r}"
                raise PolicyFileError(self.path, problem, f"use {key} {made!r}, {train} --set task.{key}={asked}")
        if own.action != action_parts(own.robot, task):
            problem = "was made for another size of a position step than the task's alpha and slide_unit give"
            raise PolicyFileError(self.path, problem, f"use the policy's own task, {train}")


def policy_names() -> list[str]:
    """Names of the shipped policies."""
    return sorted(path.parent.name for path in shipped.policies_dir().glob("*/best.zip"))


def resolve_policy(name: str) -> Path:
    """File of a shipped policy by its name, or the path itself.

    Raises:
        UnknownName: the text is neither a shipped policy's name nor anything like a path.
    """
    if name in policy_names():
        return shipped.policies_dir() / name / "best.zip"
    path = Path(name)
    if path.suffix == ".zip" or len(path.parts) > 1 or os.path.exists(name):  # noqa: PTH110  # exact for any string
        return path
    raise UnknownName("policy", name, [*policy_names(), "FILE.zip"])


def save_policy(path: Path, model: PPO, header: PolicyHeader) -> None:
    """Write a policy file, whole or not at all: if anything goes wrong, an earlier file stays.

    Args:
        path: the file to write; its folder must exist.
        model: a Stable-Baselines3 PPO whose actor is a tanh perceptron.
        header: the robot and the task that the policy was made for.

    Raises:
        PolicyFileError: the weights could not be loaded again, as they are not finite, say.
        PipenavError: the actor is of another kind.
        FileProblem: the file cannot be written.
    """
    scale = task_of(header.task).observation_scale(header.robot).astype(np.float32)
    weights = safetensors.numpy.save({"observation_scale": scale, **_actor_weights(model)})
    saved, buffer = io.BytesIO(), io.BytesIO()
    model.save(saved, exclude=TRANSIENT)
    with zipfile.ZipFile(saved) as source, zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in source.namelist():
            if name != "system_info.txt":  # the training machine is nobody's business; the versions are in the header
                archive.writestr(name, source.read(name))
        archive.writestr(HEADER_MEMBER, header.model_dump_json(indent=1))
        archive.writestr(WEIGHTS_MEMBER, weights)
    parse(path, buffer.getvalue())
    atomic_write(path, buffer.getvalue())


def load_policy(path: Path | str) -> Policy:
    """Read a policy file, which may come from a stranger: only our two members, no pickles, sizes bounded.

    Raises:
        PolicyFileError: something is wrong with the file; the message is one sentence.
    """
    path = Path(path)
    again = "check its name"
    try:
        if path.is_dir():
            raise PolicyFileError(path, "is a folder", f"name the file in it, e.g. {path / 'best.zip'}")
        if path.exists() and not path.is_file():
            raise PolicyFileError(path, "is no regular file", again)
        with path.open("rb") as file:
            content = file.read(MAX_FILE + 1)
    except OSError as error:
        raise PolicyFileError(path, f"cannot be read, {error.strerror or error}", again) from error
    except ValueError as error:  # a name that no file system takes
        raise PolicyFileError(path, f"cannot be read, {error}", again) from error
    return Policy(path, *parse(path, content))


def _actor_weights(model: PPO) -> dict[str, Array32]:
    """Linear layers of the actor as `layer0.weight` (outputs, inputs), `layer0.bias` (outputs,), ..."""
    from torch import nn

    hidden = list(model.policy.mlp_extractor.policy_net)
    linear, activations = hidden[::2], hidden[1::2]
    plain = type(model.policy.features_extractor).__name__ == "FlattenExtractor" and not model.policy.squash_output
    known = all(isinstance(m, nn.Linear) for m in linear) and all(isinstance(m, nn.Tanh) for m in activations)
    if not (plain and known and len(linear) == len(activations)):
        raise PipenavError("this actor is not a plain tanh perceptron: train with MlpPolicy and activation Tanh.")
    weights = {}
    for i, layer in enumerate([*linear, model.policy.action_net]):
        for part in ("weight", "bias"):
            tensor = getattr(layer, part).detach().cpu().numpy()
            weights[f"layer{i}.{part}"] = np.ascontiguousarray(tensor, np.float32)
    return weights
