"""Stable-Baselines3's vector environment: its checker, resets at once, and the rest of its contract."""

from __future__ import annotations

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor

from pipenav.backends.simulators import open_simulator
from pipenav.envs.sb3_env import TaskVecEnv
from pipenav.pipes.corner_sets import parse_corners
from pipenav.robots.robot import load_robot
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.task import ReachTask
from pipenav.tasks.sampling import random_episodes

SHORT = {"max_steps": 7}
FAST = {"timestep": 0.005, "threads": 1}


def sb3_env(n: int = 4, seed: int = 0, **task: Any) -> TaskVecEnv:
    robot, config, pipes = (
        load_robot("basic"),
        ReachConfig.model_validate(task or SHORT),
        parse_corners(["thesis-train"]),
    )
    source = random_episodes(ReachTask(config), robot, [pipes], np.random.default_rng(seed))
    return TaskVecEnv(ReachBatch(robot, config, open_simulator("mujoco", robot, n, FAST), n, source))


@pytest.mark.slow
def test_ppo_learns_on_the_vec_env() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model = PPO("MlpPolicy", sb3_env(), n_steps=64, batch_size=64, n_epochs=1, device="cpu", seed=1).learn(256)
        mean, _ = evaluate_policy(model, sb3_env(), n_eval_episodes=4)
    assert model.num_timesteps == 256
    assert np.isfinite(mean)


def test_the_vec_env_starts_anew_at_once_and_keeps_the_last_observation() -> None:
    env, untouched = sb3_env(), sb3_env(max_steps=100)
    assert np.array_equal(env.reset(), untouched.reset())
    still = np.zeros((4, 4), np.float32)
    total = np.zeros(4)
    for _ in range(SHORT["max_steps"]):
        observation, reward, done, infos = env.step(still)
        last, same_reward, *_ = untouched.step(still)
        assert np.array_equal(reward, same_reward)
        total += reward
    assert done.all()
    for i, info in enumerate(infos):
        assert np.array_equal(info["terminal_observation"], last[i])
        assert not np.array_equal(observation[i], last[i])
        assert info["TimeLimit.truncated"] is True
        assert info["outcome"] == "timeout"
        assert info["episode"]["l"] == SHORT["max_steps"]
        assert info["episode"]["r"] == pytest.approx(total[i], rel=1e-6)
    assert env.step(still)[0].dtype == np.float32
    assert not env.step(still)[2].any()


def test_the_vec_env_keeps_the_rest_of_the_contract() -> None:
    env = sb3_env()
    assert env.get_attr("render_mode") == [None] * 4
    assert env.get_attr("num_envs", [1, 2]) == [4, 4]
    assert env.env_is_wrapped(Monitor) == [True] * 4
    assert env.env_is_wrapped(gymnasium.Wrapper, 0) == [False]
    assert env.seed(3) == [None] * 4
    with pytest.raises(AttributeError, match="share one backend"):
        env.set_attr("target", 1)
    with pytest.raises(AttributeError, match="share one backend"):
        env.env_method("reset")
    env.close()
    env.close()
