"""The corner task as a Stable-Baselines3 VecEnv: a thin adapter over CornerBatch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv

from pipenav.batch import CornerBatch
from pipenav.task.episode import Verdict


class CornerVecEnv(VecEnv):  # type: ignore[misc]  # Stable-Baselines3 is imported untyped
    """n corner episodes; an ended one starts anew at once, its last observation is in `info["terminal_observation"]`."""

    def __init__(self, batch: CornerBatch) -> None:
        self.batch = batch
        size, joints = batch.observation_size, len(batch.robot.joints)
        observation = spaces.Box(-np.inf, np.inf, (size,), np.float32)
        super().__init__(batch.n, observation, spaces.Box(-1.0, 1.0, (joints,), np.float32))
        self._returns = np.zeros(batch.n)

    def reset(self) -> np.ndarray:
        self._returns[:] = 0.0
        return self.batch.reset().astype(np.float32)

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        result = self.batch.step(self._actions)
        observation = result.observation.astype(np.float32)
        self._returns += result.reward
        done = result.verdict != Verdict.RUNNING
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        ended = np.flatnonzero(done)
        for i in ended:
            verdict = Verdict(result.verdict[i])
            infos[i] = {
                "terminal_observation": observation[i],
                "TimeLimit.truncated": verdict is Verdict.TIMEOUT,
                "is_success": verdict is Verdict.REACHED,
                "verdict": verdict.label,
                "episode": {"r": float(self._returns[i]), "l": int(self.batch.steps[i])},
            }
        if len(ended):
            self._returns[ended] = 0.0
            observation = self.batch.reset(ended).astype(np.float32)
        return observation, result.reward.astype(np.float32), done, infos

    def close(self) -> None:
        self.batch.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise AttributeError(f"{attr_name} cannot be set: all robots share one backend")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        raise AttributeError(f"there is no method {method_name} of a single robot: all share one backend")

    def env_is_wrapped(self, wrapper_class: Callable[..., Any], indices: Any = None) -> list[bool]:
        return [False] * len(list(self._get_indices(indices)))

    def seed(self, seed: int | None = None) -> Sequence[None | int]:
        """Seeds belong to the episode source, which the batch was built with."""
        return [None] * self.num_envs
