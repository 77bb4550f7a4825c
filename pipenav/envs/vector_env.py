"""Tasks as Gymnasium vector environments: n robots of one batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, TypedDict, Unpack

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from pipenav.envs.env_tasks import CORNER, TRAVERSE, EnvTask
from pipenav.envs.episodes import EnvSettings, SeededEpisodes, TaskSettings
from pipenav.envs.spaces import Float32s, action_space, bounded_space, checked_action, step_info, within
from pipenav.envs.threads import bound_torch_threads
from pipenav.errors import PipenavError
from pipenav.tasks.outcome import Outcome


class Rendering(TypedDict, total=False):
    """Arguments about pictures.

    Attributes:
        render_mode: None, or `rgb_array` for a top view of each robot.
    """

    render_mode: str | None


class TaskVectorEnv(VectorEnv[Float32s, Float32s, NDArray[Any]]):
    """n episodes of a task in one batch. An ended episode starts anew in the next step."""

    metadata: dict[str, Any] = {  # noqa: RUF012
        "render_modes": ["rgb_array"],
        "render_fps": 10,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }
    env_task: ClassVar[EnvTask]

    def __init__(self, num_envs: int, settings: EnvSettings, rendering: Rendering) -> None:
        if unknown := rendering.keys() - Rendering.__annotations__.keys():
            raise TypeError(f"{type(self).__name__}() got an unexpected keyword argument {min(unknown)!r}")
        self.num_envs, self.render_mode = num_envs, rendering.get("render_mode")
        self._episodes = SeededEpisodes(self.env_task, num_envs, settings)
        self.batch = self._episodes.batch
        self._space, actions = bounded_space(self._episodes.layout), action_space(self.batch)
        self.single_observation_space, self.single_action_space = self._space, actions
        self.observation_space = batch_space(self._space, num_envs)
        self._actions = batch_space(actions, num_envs)
        self.action_space = self._actions
        self._ended = np.zeros(num_envs, bool)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002
    ) -> tuple[Float32s, dict[str, Any]]:
        bound_torch_threads()
        self._seed(seed)
        self._ended = np.zeros(self.num_envs, bool)
        return within(self._space, self.batch.reset()), {}

    def _seed(self, seed: int | Sequence[int | None] | None) -> None:
        """Seed the robots: by an int, robot i with seed + i; a robot without a seed keeps its generator."""
        seeds = [seed] * self.num_envs if seed is None else seed
        seeds = [seeds + i for i in range(self.num_envs)] if isinstance(seeds, int) else list(seeds)
        if len(seeds) != self.num_envs:
            raise PipenavError(
                f"{len(seeds)} seeds given for {self.num_envs} robots: give one for each, or one number."
            )
        old = self._episodes.generators or [seeding.np_random()[0] for _ in seeds]
        self._episodes.generators = [
            generator if new is None else seeding.np_random(new)[0] for new, generator in zip(seeds, old, strict=True)
        ]

    def step(self, actions: Float32s) -> tuple[Float32s, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        anew, result = self._ended, self.batch.step(checked_action(self._actions, actions, self._ended))
        outcome = np.where(anew, Outcome.RUNNING, result.outcome)
        reward = np.where(anew, 0.0, result.reward)
        truncated = outcome == Outcome.TIMEOUT
        self._ended = outcome != Outcome.RUNNING
        observation = self.batch.reset(np.flatnonzero(anew)) if anew.any() else result.observation
        info = step_info(result)
        valid = {f"_{key}": ~anew for key in info}
        return within(self._space, observation), reward, self._ended & ~truncated, truncated, info | valid

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        return None if self.render_mode is None else tuple(map(self._episodes.picture, range(self.num_envs)))

    def close_extras(self, **kwargs: Any) -> None:  # noqa: ARG002
        self.batch.close()


class CornerVectorEnv(TaskVectorEnv):
    """n episodes of the reach task in one batch. An ended episode starts anew in the next step.

    Robot i of `reset(seed=s)` lives through the episodes of a `CornerEnv` with seed s + i. `info` holds the keys of
    `CornerEnv` as arrays, with `_<key>` false for the robots that started anew, whose actions were ignored.

    Args:
        num_envs: number of robots.
        robot, pipes, backend, task, options, render_mode: as for `CornerEnv`.
    """

    env_task = CORNER

    def __init__(
        self,
        num_envs: int = 1,
        robot: str = "basic",
        pipes: Sequence[str] = ("thesis-train",),
        backend: str = "mujoco",
        task: TaskSettings = None,
        options: Mapping[str, Any] | None = None,
        **rendering: Unpack[Rendering],
    ) -> None:
        super().__init__(num_envs, EnvSettings(robot, pipes, backend, task, options), rendering)


class TraverseVectorEnv(TaskVectorEnv):
    """n episodes of the traverse task in one batch, as `CornerVectorEnv` has them of the reach task.

    Args:
        num_envs: number of robots.
        robot, pipes, backend, task, options, render_mode: as for `TraverseEnv`.
    """

    env_task = TRAVERSE

    def __init__(
        self,
        num_envs: int = 1,
        robot: str = "pirate",
        pipes: Sequence[str] = ("working-range-train",),
        backend: str = "mujoco",
        task: TaskSettings = None,
        options: Mapping[str, Any] | None = None,
        **rendering: Unpack[Rendering],
    ) -> None:
        super().__init__(num_envs, EnvSettings(robot, pipes, backend, task, options), rendering)
