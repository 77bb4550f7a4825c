"""Episodes drawn at random in random pipes, for training."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pipenav.arrays import Ints
from pipenav.pipes.pipe import Pipe
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach import episode


def random_episodes(
    robot: RobotSpec,
    config: Any,
    sets: Sequence[Sequence[Pipe]],
    rng: np.random.Generator,
    stock: int = 1,
    sample: Callable[..., Any] = episode.sample,
) -> Callable[[Ints], Any]:
    """Episodes with random starts and targets in random pipes: first a set is drawn, each alike, then a pipe of it.

    They are drawn at least `stock` at a time and then dealt out, since hundreds cost hardly more to draw than one;
    those too few for the robots that ask next are dropped.

    Args:
        robot, config: what the episodes are for.
        sets: the pipes.
        rng: of all that is random.
        stock: how many episodes are drawn at least.
        sample: draws one episode of the task in each of some pipes.
    """
    sizes = np.array([len(pipes) for pipes in sets])

    def draw(k: int) -> Any:
        chosen = rng.integers(len(sets), size=k)
        places = rng.integers(sizes[chosen])
        pipes = [sets[i][j] for i, j in zip(chosen.tolist(), places.tolist(), strict=True)]
        return sample(robot, config, pipes, rng)

    held, dealt = draw(0), 0

    def source(indices: Ints) -> Any:
        nonlocal held, dealt
        if dealt + len(indices) > len(held.pipes):
            held, dealt = draw(max(len(indices), stock)), 0
        dealt += len(indices)
        return held.part(slice(dealt - len(indices), dealt))

    return source
