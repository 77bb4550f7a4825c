"""Episodes of a task for environments: each robot draws its own from a seeded generator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipenav.arrays import Ints
from pipenav.drawing.scene import scene_pixels
from pipenav.envs.env_tasks import EnvTask
from pipenav.errors import PipenavError
from pipenav.robots.robot import load_robot
from pipenav.tasks.batch import TrainingBatch
from pipenav.tasks.layout import ObservationField
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.registry import task_of
from pipenav.tasks.rolling.batch import check_in_space
from pipenav.tasks.sampling import random_episodes
from pipenav.tasks.traverse.config import TraverseConfig

TaskSettings = ReachConfig | TraverseConfig | Mapping[str, Any] | None
"""Settings of a task, or a table of some of them; None for the defaults."""


class EnvSettings(NamedTuple):
    """Arguments of an environment, as `CornerEnv` documents them."""

    robot: str
    pipes: Sequence[str]
    backend: str
    task: TaskSettings
    options: Mapping[str, Any] | None


class SeededEpisodes:
    """n robots of one batch, each drawing its episodes from a generator of its own.

    So robot i of many lives through the same episodes as a single robot with the same seed.

    Args:
        env_task: the task.
        n: number of robots.
        settings: the environment's arguments.

    Attributes:
        batch: the robots.
        generators: generator of each robot, n of them; they must be set before the batch is reset.
        episodes: running episode of each robot, k = 1 each.

    Raises:
        PipenavError: an argument is unknown or impossible.
    """

    def __init__(self, env_task: EnvTask, n: int, settings: EnvSettings) -> None:
        self.generators: list[np.random.Generator] = []
        self.episodes: dict[int, Any] = {}
        self._env_task, self._robot = env_task, load_robot(settings.robot)
        self._task = task_of(env_task.settings(settings.task))
        env_task.check_robot(self._robot)
        texts = [settings.pipes] if isinstance(settings.pipes, str) else settings.pipes
        self._sets = [self._task.parse_training_pipes([text]) for text in texts]
        if not self._sets:
            raise PipenavError("no pipes given: name a pipe set, a TOML file, or a pipe such as d=90,angle=60.")
        self._planar = not any(pipe.in_space for pipes in self._sets for pipe in pipes)
        self.batch: Any = self._open(n, settings.backend, dict(settings.options or {}))

    def _open(self, n: int, backend: str, options: Mapping[str, Any]) -> TrainingBatch:
        """The robots, in space where any pipe leaves the plane."""
        from pipenav.backends.simulators import open_simulator, open_space

        robot, task = self._robot, self._task
        if self._planar:
            slots = max(len(pipe.segments) for pipes in self._sets for pipe in pipes)
            return task.batch(robot, open_simulator(backend, robot, n, options, slots), n, self._draw)
        check_in_space(robot, backend)
        return task.batch_in_space(robot, open_space(backend, robot, n, options), n, self._draw)

    @property
    def layout(self) -> list[ObservationField]:
        """Parts of the observation, in order."""
        return self._task.layout(self._robot)

    def _draw(self, indices: Ints) -> Any:
        for i in indices:
            draw = random_episodes(self._task, self._robot, self._sets, self.generators[i])
            self.episodes[int(i)] = draw(np.array([i]))
        drawn = [self.episodes[int(i)] for i in indices]
        pipes, *arrays = zip(*drawn, strict=True)
        return type(drawn[0])(tuple(pipe for (pipe,) in pipes), *map(np.concatenate, arrays))

    def picture(self, i: int, pixels: int = 480) -> NDArray[np.uint8]:
        """Picture of robot i from above, (pixels, pixels, 3): walls, links, beams, and the target if it has one.

        Raises:
            PipenavError: there is nothing to see before the first reset, or the robots are in space.
        """
        if not self._planar:
            raise PipenavError(
                "a picture from above shows pipes in a plane: leave out render_mode for routes that leave the plane."
            )
        if i not in self.episodes:
            raise PipenavError("there is nothing to draw before the first reset: call reset first.")
        return scene_pixels(self._env_task.scene(self.batch, self.episodes[i], i), pixels, self._env_task.around)
