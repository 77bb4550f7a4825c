"""Environments in routes that leave the plane."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from pipenav.env import TraverseEnv, TraverseVectorEnv
from pipenav.errors import PipenavError

PIPES = ["runs-rolled-train:1", "d=90,angle=90"]
SHORT, FAST = {"max_steps": 3}, {"timestep": 0.005, "threads": 1}


@pytest.mark.slow
def test_a_vector_env_in_space_is_n_single_ones() -> None:
    n, seed, rng = 3, 5, np.random.default_rng(0)
    singles = [TraverseEnv(pipes=PIPES, task=SHORT, options=FAST) for _ in range(n)]
    with closing(TraverseVectorEnv(n, pipes=PIPES, task=SHORT, options=FAST)) as vector:
        observation, _ = vector.reset(seed=seed)
        np.testing.assert_array_equal(observation, [env.reset(seed=seed + i)[0] for i, env in enumerate(singles)])
        for _ in range(4):
            actions = rng.uniform(-1, 1, vector.action_space.shape).astype(np.float32)
            observation, reward, *_ = vector.step(actions)
            seen, gained, *_ = zip(
                *(env.step(action) for env, action in zip(singles, actions, strict=True)), strict=True
            )
            np.testing.assert_array_equal(observation, seen)
            np.testing.assert_array_equal(reward, gained)
    for env in singles:
        env.close()


@pytest.mark.slow
def test_robots_in_space_have_no_picture_from_above() -> None:
    with closing(TraverseEnv(pipes=PIPES, task=SHORT, options=FAST, render_mode="rgb_array")) as env:
        env.reset(seed=0)
        with pytest.raises(PipenavError, match="a picture from above shows pipes in a plane: leave out render_mode"):
            env.render()
