"""The reach task under a controller."""

from __future__ import annotations

import numpy as np

from pipenav.pipes.corner import PipeCorner
from pipenav.policies.controller import AnyController, actions_of
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.registry import task_of
from pipenav.tasks.sampling import random_episodes


def reach_batch(controller: AnyController, pipes: list[PipeCorner], n: int, seed: int = 0) -> ReachBatch:
    """The controller's task on MuJoCo, with random episodes in some pipes."""
    from pipenav_mujoco.backend import MujocoBackend, MujocoOptions

    segments = max(len(pipe.segments) for pipe in pipes)
    backend = MujocoBackend(controller.robot, n, MujocoOptions(threads=1), segments)
    source = random_episodes(task_of(controller.task), controller.robot, [pipes], np.random.default_rng(seed))
    return ReachBatch(controller.robot, controller.task, backend, n, source)


def first_outcomes(controller: AnyController, pipes: list[PipeCorner], n: int) -> list[str]:
    """Outcome of the first episode of each of n robots."""
    batch = reach_batch(controller, pipes, n)
    observation = batch.reset()
    first = np.zeros(n, int)
    while not first.all():
        action = actions_of(controller, observation, batch)
        assert action.shape == (n, len(controller.robot.joints))
        assert np.abs(action).max() <= 1.0
        result = batch.step(action)
        observation = result.observation
        first = np.where(first == Outcome.RUNNING, result.outcome, first)
        if (ended := np.flatnonzero(result.outcome)).size:
            observation = batch.reset(ended)
    batch.close()
    return [Outcome(outcome).label for outcome in first]
