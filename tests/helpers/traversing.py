"""Traverses of the robot `pirate-strong`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager

import numpy as np
from hypothesis import strategies as st

from pipenav.backends.simulators import open_simulator
from pipenav.pipes.corner import PipeCorner
from pipenav.robots.robot import load_robot
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import TraverseEpisodes, sample

ROBOT = load_robot("pirate-strong")


CONFIG = TraverseConfig(kind="traverse")


PIPES = [
    PipeCorner.of(70, 55),
    PipeCorner.of(120, 125, "right"),
    PipeCorner.of(90, 90),
    PipeCorner.of(100, 70, "right"),
]


seeds = st.integers(0, 2**32 - 1)


def episodes(config: TraverseConfig = CONFIG, seed: int = 0, pipes: list[PipeCorner] = PIPES) -> TraverseEpisodes:
    """Random traverses, one in each pipe."""
    return sample(ROBOT, config, pipes, np.random.default_rng(seed))


@contextmanager
def started(
    start: TraverseEpisodes, config: TraverseConfig = CONFIG, kind: type[TraverseBatch] = TraverseBatch
) -> Iterator[TraverseBatch]:
    """The episodes on MuJoCo, begun."""
    n, segments = len(start.pipes), max(len(pipe.segments) for pipe in start.pipes)
    simulator = open_simulator("mujoco", ROBOT, n, {"threads": 1}, segments)
    with closing(kind(ROBOT, config, simulator, n, lambda _: start)) as made:
        made.reset()
        yield made
