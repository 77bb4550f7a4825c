"""Episodes drawn at random in random pipes, for training."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipenav.arrays import Ints
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.task import EpisodeSource, EpisodesT, Task


def random_episodes(
    task: Task[Any, EpisodesT],
    robot: RobotSpec,
    sets: Sequence[Sequence[Pipe]],
    rng: np.random.Generator,
    stock: int = 1,
) -> EpisodeSource[EpisodesT]:
    """A source of random episodes: first a set of pipes is drawn, each with the same chance, then a pipe of it.

    At least `stock` episodes are drawn at a time and then dealt out, since hundreds cost hardly more to draw than one.
    A rest that is too small for the next request is dropped.

    Args:
        task: the task that the episodes are for.
        robot: the robot.
        sets: the sets of pipes.
        rng: source of all randomness.
        stock: least number of episodes to draw at a time.
    """
    sizes = np.array([len(pipes) for pipes in sets])

    def draw(k: int) -> EpisodesT:
        chosen = rng.integers(len(sets), size=k)
        members = rng.integers(sizes[chosen])
        pipes = [sets[i][j] for i, j in zip(chosen.tolist(), members.tolist(), strict=True)]
        return task.sample(robot, pipes, rng)

    held, dealt = draw(0), 0

    def source(indices: Ints) -> EpisodesT:
        nonlocal held, dealt
        if dealt + len(indices) > len(held.pipes):
            held, dealt = draw(max(len(indices), stock)), 0
        dealt += len(indices)
        return held.part(slice(dealt - len(indices), dealt))

    return source
