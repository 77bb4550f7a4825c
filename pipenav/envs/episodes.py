"""Episodes of the reach task for environments: each robot draws its own from a seeded generator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from pipenav.arrays import Ints
from pipenav.errors import ConfigError, PipenavError
from pipenav.pipes.corner_sets import parse_corners
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig, RewardConfig
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.reach.task import ReachTask
from pipenav.tasks.sampling import random_episodes


class CornerSettings(NamedTuple):
    """Arguments of an environment, as `CornerEnv` documents them."""

    robot: str
    pipes: Sequence[str]
    backend: str
    task: ReachConfig | Mapping[str, Any] | None
    options: Mapping[str, Any] | None


class SeededEpisodes:
    """n robots of one batch, each drawing its episodes from a generator of its own.

    So robot i of many lives through the same episodes as a single robot with the same seed.

    Args:
        n: number of robots.
        settings: the environment's arguments.

    Attributes:
        batch: the robots.
        generators: generator of each robot, n of them; they must be set before the batch is reset.
        episodes: running episode of each robot, as `ReachEpisodes` of k = 1.

    Raises:
        PipenavError: an argument is unknown or impossible.
    """

    def __init__(self, n: int, settings: CornerSettings) -> None:
        from pipenav.backends.simulators import open_simulator

        self.generators: list[np.random.Generator] = []
        self.episodes: dict[int, ReachEpisodes] = {}
        self._robot, self._config = load_robot(settings.robot), _task_config(settings.task)
        texts = [settings.pipes] if isinstance(settings.pipes, str) else settings.pipes
        self._sets = [parse_corners([text]) for text in texts]
        if not self._sets:
            raise PipenavError("no pipes given: name a pipe set, a TOML file, or a pipe such as d=90,angle=60.")
        slots = max(len(pipe.segments) for pipes in self._sets for pipe in pipes)
        simulator = open_simulator(settings.backend, self._robot, n, dict(settings.options or {}), slots)
        self.batch = ReachBatch(self._robot, self._config, simulator, n, self._draw)

    def _draw(self, indices: Ints) -> ReachEpisodes:
        for i in indices:
            draw = random_episodes(ReachTask(self._config), self._robot, self._sets, self.generators[i])
            self.episodes[int(i)] = draw(np.array([i]))
        pipes, *arrays = zip(*(self.episodes[int(i)] for i in indices), strict=True)
        return ReachEpisodes(tuple(pipe for (pipe,) in pipes), *map(np.concatenate, arrays))


def _task_config(task: ReachConfig | Mapping[str, Any] | None) -> ReachConfig:
    if isinstance(task, ReachConfig):
        return task
    try:
        return ReachConfig.model_validate(dict(task or {}))
    except ValidationError as error:
        known = [*ReachConfig.model_fields, *(f"reward.{key}" for key in RewardConfig.model_fields)]
        raise ConfigError.from_validation("task", error, known) from error
