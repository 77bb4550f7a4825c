"""Environments of several shares whose robots live through the same episodes however they are divided."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from pipenav.arrays import Ints
from pipenav.backends.backend import Simulator
from pipenav.backends.messages import Command
from pipenav.envs.sb3_env import TaskVecEnv
from pipenav.pipes.corner_sets import parse_corners
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes, sample
from pipenav.tasks.task import EpisodeSource
from pipenav.testing import KinematicBackend, KinematicOptions

ROBOT = load_robot("basic")
PIPES = parse_corners(["thesis-train"])
CONFIG = ReachConfig(max_steps=7)


def own_episodes(first: int, n: int, seed: int) -> EpisodeSource[ReachEpisodes]:
    """A source in which each robot draws from its own generator, whatever the others do.

    Args:
        first: number of the first robot.
        n: number of robots.
        seed: seed of all episodes.
    """
    generators = [np.random.default_rng([seed, first + i]) for i in range(n)]

    def source(indices: Ints) -> ReachEpisodes:
        drawn = [
            sample(ROBOT, CONFIG, [PIPES[generators[i].integers(len(PIPES))]], generators[i]) for i in indices.tolist()
        ]
        pipes = tuple(one.pipes[0] for one in drawn)
        return ReachEpisodes(pipes, *(np.concatenate(column) for column in list(zip(*drawn, strict=True))[1:]))

    return source


class Dawdling(KinematicBackend):
    """Robots that take some time to move, each step another one."""

    def __init__(self, n: int, delays: Callable[[], float] = lambda: 0.0) -> None:
        super().__init__(ROBOT, n, KinematicOptions())
        self._delays = delays

    def step(self, command: Command) -> None:
        time.sleep(self._delays())
        super().step(command)


def env_of(
    sizes: Sequence[int], seed: int = 0, simulator: Callable[[int], Simulator] = Dawdling, config: ReachConfig = CONFIG
) -> TaskVecEnv:
    """An environment of shares of these sizes."""
    firsts = np.cumsum([0, *sizes]).tolist()
    return TaskVecEnv(
        *(
            ReachBatch(ROBOT, config, simulator(n), n, own_episodes(first, n, seed))
            for n, first in zip(sizes, firsts, strict=False)
        )
    )
