"""Small policy files, whole and taken apart."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from pipenav.policies.file import PolicyFileError
from pipenav.policies.header import header_for
from pipenav.policies.policy import load_policy
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.registry import task_of

ROBOT = load_robot("basic")


TASK = ReachConfig(observation="relative")


SIZE = len(task_of(TASK).observation_scale(ROBOT))


JOINTS = len(ROBOT.joints)


Members = dict[str, bytes]


class Still(gymnasium.Env):
    """Spaces of the right size, and nothing that moves."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (SIZE,), np.float32)
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (JOINTS,), np.float32)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:  # noqa: ARG002
        return np.zeros(SIZE, np.float32), {}

    def step(self, action: Any) -> Any:  # noqa: ARG002
        return np.zeros(SIZE, np.float32), 0.0, False, False, {}


def untrained_ppo(**settings: Any) -> Any:
    """PPO with small networks, whose actions lie well inside and well outside of [-1, 1]."""
    import torch
    from stable_baselines3 import PPO

    torch.set_num_threads(1)
    kwargs = {"activation_fn": torch.nn.Tanh, "net_arch": {"pi": [32, 16], "vf": [8]}, **settings}
    model = PPO("MlpPolicy", Still(), n_steps=8, batch_size=8, seed=1, device="cpu", policy_kwargs=kwargs)
    with torch.no_grad():  # actions well inside and well outside of [-1, 1]
        model.policy.action_net.weight.mul_(100.0)
    return model


def some_header() -> Any:
    """The header of a policy that was trained for a moment."""
    return header_for(ROBOT, TASK, ["thesis-train"], {"steps": 8, "seconds": 0.5, "seed": 1, "preset": "arm"})


def members_of(path: Path) -> Members:
    """Contents of a zip's members, by name."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def zipped(path: Path, members: Members) -> Path:
    """Write a zip of these members."""
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


def refusal(path: Path) -> str:
    """The one sentence that the file is refused with."""
    with pytest.raises(PolicyFileError) as caught:
        load_policy(path)
    text = str(caught.value)
    assert str(path) in text
    assert text.endswith(".")
    assert "\n" not in text
    return text


def random_observations(count: int) -> np.ndarray:
    """Normally distributed observations, (count, size)."""
    return np.random.default_rng(0).normal(size=(count, SIZE)).astype(np.float32)
