"""A task as a Stable-Baselines3 VecEnv: a thin adapter over its batches."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import accumulate
from typing import Any

import numpy as np
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv

from pipenav.arrays import Floats
from pipenav.envs.shares import RobotShare, ShareStep
from pipenav.envs.spaces import action_space, observation_space, one_info, step_info
from pipenav.pipes.pipe import Pipe
from pipenav.tasks.batch import TrainingBatch


class TaskVecEnv(VecEnv):  # type: ignore[misc]  # Stable-Baselines3 is imported untyped
    """n episodes of a task. An ended episode starts anew at once; `terminal_observation` holds its last observation.

    Args:
        batches: the robots; those of one batch move in a thread while the other batches are attended to. A single
            batch moves in the caller's thread.

    Attributes:
        shares: the robots of each batch.
        min_range: smallest laser reading of each robot after the last step, (n,) [m].
    """

    render_mode: str | None = None

    def __init__(self, *batches: TrainingBatch) -> None:
        self._threads = ThreadPoolExecutor(1, "robots") if len(batches) > 1 else None
        firsts = accumulate((batch.n for batch in batches), initial=0)
        self.shares = [RobotShare(batch, first, self._threads) for batch, first in zip(batches, firsts, strict=False)]
        n = sum(batch.n for batch in batches)
        super().__init__(n, observation_space(batches[0]), action_space(batches[0]))
        self.min_range = np.zeros(n)

    @property
    def pipes(self) -> list[Pipe | None]:
        """Pipe of each robot; None before its first reset."""
        return [pipe for share in self.shares for pipe in share.batch.pipes]

    def stagger(self, rng: np.random.Generator) -> None:
        """Let the next episodes start at random ages, so that their time-outs do not all fall into one step."""
        for share in self.shares:
            share.batch.stagger(rng)

    def reset(self) -> np.ndarray:
        return np.concatenate([share.reset() for share in self.shares])

    def receive(self, share: RobotShare) -> ShareStep:
        """End the control step that a share's robots have begun."""
        step = share.receive()
        self.min_range[share.rows] = step.result.min_range
        return step

    def step_async(self, actions: Floats) -> None:
        for share in self.shares:
            share.send(actions[share.rows])

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        steps = [self.receive(share) for share in self.shares]
        observation, reward, done = (
            np.concatenate(parts) for parts in zip(*((s.observation, s.reward, s.done) for s in steps), strict=True)
        )
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for share, step in zip(self.shares, steps, strict=True):
            self._describe(step, infos[share.rows])
        return observation, reward, done, infos

    @staticmethod
    def _describe(step: ShareStep, infos: list[dict[str, Any]]) -> None:
        """Fill in the infos of a share's robots whose episodes ended."""
        ended, info = step.ended, step_info(step.result, step.ended.robots)
        for k, i in enumerate(ended.robots.tolist()):
            infos[i] |= one_info(info, k) | {
                "terminal_observation": ended.observation[k],
                "TimeLimit.truncated": ended.cut_off[k].item(),
                "episode": {"r": ended.reward[k].item(), "l": ended.steps[k].item()},
            }

    def close(self) -> None:
        for share in self.shares:
            share.close()
        if self._threads is not None:
            self._threads.shutdown()

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
