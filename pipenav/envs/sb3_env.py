"""A task as a Stable-Baselines3 VecEnv: a thin adapter over its batch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv

from pipenav.envs.spaces import action_space, observation_space, one_info, step_info
from pipenav.tasks.batch import TrainingBatch
from pipenav.tasks.outcome import Outcome


class TaskVecEnv(VecEnv):  # type: ignore[misc]  # Stable-Baselines3 is imported untyped
    """n episodes of a task. An ended episode starts anew at once; `terminal_observation` holds its last observation.

    Attributes:
        batch: the robots.
        min_range: smallest laser reading of each robot after the last step, (n,) [m].
    """

    render_mode: str | None = None

    def __init__(self, batch: TrainingBatch) -> None:
        self.batch = batch
        super().__init__(batch.n, observation_space(batch), action_space(batch))
        self._returns = np.zeros(batch.n)
        self.min_range = np.zeros(batch.n)

    def reset(self) -> np.ndarray:
        self._returns[:] = 0.0
        return self.batch.reset().astype(np.float32)

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        result = self.batch.step(self._actions)
        observation = result.observation.astype(np.float32)
        self._returns += result.reward
        self.min_range = result.min_range
        done = result.outcome != Outcome.RUNNING.value
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        ended = np.flatnonzero(done)
        info = step_info(result, ended)
        cut_off = result.cut_off[ended]
        for k, i in enumerate(ended.tolist()):
            infos[i] = one_info(info, k) | {
                "terminal_observation": observation[i],
                "TimeLimit.truncated": cut_off[k].item(),
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
        raise AttributeError(f"{attr_name} cannot be set to {value!r} for robots {indices}: all share one backend")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:  # noqa: ARG002
        raise AttributeError(f"there is no method {method_name} of a single robot: all share one backend")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """Claim to be wrapped in a Monitor, since `info["episode"]` is here already."""
        return [wrapper_class is Monitor] * len(list(self._get_indices(indices)))

    def seed(self, seed: int | None = None) -> Sequence[int | None]:  # noqa: ARG002
        """Do nothing: seeds belong to the episode source that the batch was built with."""
        return [None] * self.num_envs
