"""The environment adapters: the libraries' own checkers, seeds, automatic resets."""

from __future__ import annotations

import subprocess
import sys
import warnings
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from stable_baselines3.common import env_checker as sb3_checker

from pipenav.env import CornerEnv, CornerVectorEnv
from pipenav.errors import ConfigError, PipenavError, UnknownName

SHORT = {"max_steps": 7}
FAST = {"timestep": 0.005, "threads": 1}


@pytest.fixture
def env() -> Iterator[CornerEnv]:
    env = CornerEnv(task=SHORT, options=FAST)
    yield env
    env.close()


def rollout(env: CornerEnv, seed: int, steps: int = 30) -> list[tuple[Any, ...]]:
    """Everything that random actions give, over several episodes."""
    rng = np.random.default_rng(0)
    seen: list[tuple[Any, ...]] = [env.reset(seed=seed)]
    for _ in range(steps):
        step = env.step(rng.uniform(-1, 1, 4).astype(np.float32))
        seen.append(step)
        if step[2] or step[3]:
            seen.append(env.reset())
    return seen


def same(one: list[tuple[Any, ...]], two: list[tuple[Any, ...]]) -> bool:
    return all(np.array_equal(a[0], b[0]) and a[1:] == b[1:] for a, b in zip(one, two, strict=True))


def test_gymnasium_checks_it() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(gymnasium.make("pipenav/Corner-v0", render_mode="rgb_array", options=FAST).unwrapped)
    # An impact may give a joint any speed, so the space has no bounds; the checker would like some.
    assert [str(w.message) for w in caught if "infinity" not in str(w.message)] == []


def test_stable_baselines_checks_it(env: CornerEnv) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sb3_checker.check_env(env)


@pytest.mark.slow
def test_the_module_syntax_registers_it() -> None:
    code = (
        "import sys, pipenav; assert 'gymnasium' not in sys.modules;"
        "import gymnasium; gymnasium.make('pipenav.env:pipenav/Corner-v0').reset(seed=1);"
        "assert not {'torch', 'stable_baselines3', 'matplotlib'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_same_seed_gives_the_same_trajectory(env: CornerEnv) -> None:
    first, again, other = rollout(env, 3), rollout(env, 3), rollout(env, 4)
    assert same(first, again)
    assert not np.array_equal(first[0][0], other[0][0])
    anew = CornerEnv(task=SHORT, options=FAST)
    assert same(first, rollout(anew, 3))


def test_episodes_differ_without_a_new_seed(env: CornerEnv) -> None:
    first, second = env.reset(seed=3)[0], env.reset()[0]
    assert not np.array_equal(first, second)


def test_time_out_is_truncation(env: CornerEnv) -> None:
    env.reset(seed=1)
    for _ in range(SHORT["max_steps"] - 1):
        assert env.step(np.zeros(4, np.float32))[2:4] == (False, False)
    _, _, terminated, truncated, info = env.step(np.zeros(4, np.float32))
    assert (terminated, truncated) == (False, True)
    assert info["outcome"] == "timeout"
    assert info["is_success"] is False


def test_a_joint_limit_is_termination(env: CornerEnv) -> None:
    env = CornerEnv(task={"max_steps": 100}, options=FAST)
    env.reset(seed=1)
    back = np.array([-1, 0, 0, 0], np.float32)
    *_, reward, terminated, truncated, info = next(step for step in map(env.step, [back] * 50) if step[2] or step[3])
    assert (terminated, truncated, info["outcome"], reward) == (True, False, "limit", -1000.0)
    assert set(info) == {"outcome", "is_success", "min_range_m", "contact_force_n", "penetration_m"}


def test_a_vector_env_is_n_single_ones() -> None:
    n, seed = 3, 11
    vector = gymnasium.make_vec("pipenav/Corner-v0", num_envs=n, task=SHORT, options=FAST)
    singles = [CornerEnv(task=SHORT, options=FAST) for _ in range(n)]
    assert isinstance(vector, CornerVectorEnv)
    assert vector.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    observation, _ = vector.reset(seed=seed)
    assert np.array_equal(observation, [env.reset(seed=seed + i)[0] for i, env in enumerate(singles)])
    assert vector.observation_space.contains(observation)
    ended, rng = [False] * n, np.random.default_rng(0)
    for _ in range(3 * SHORT["max_steps"]):
        actions = rng.uniform(-1, 1, (n, 4)).astype(np.float32)
        observation, reward, terminated, truncated, info = vector.step(actions)
        for i, env in enumerate(singles):
            # The step after an end starts anew: its action is ignored and it rewards nothing.
            step = (*(env.reset()[0], 0.0, False, False), {}) if ended[i] else env.step(actions[i])
            assert np.array_equal(observation[i], step[0])
            assert (reward[i], terminated[i], truncated[i]) == step[1:4]
            assert info["_outcome"][i] == (not ended[i])
            assert not step[4] or {key: info[key][i] for key in step[4]} == step[4]
            ended[i] = step[2] or step[3]
    vector.close()


def test_wrong_arguments_are_named() -> None:
    with pytest.raises(UnknownName, match="did you mean 'thesis-train'"):
        CornerEnv(pipes=("thesis-trian",))
    with pytest.raises(ConfigError, match=r"task: unknown key 'max_step': did you mean 'max_steps'"):
        CornerEnv(task={"max_step": 5})
    with pytest.raises(ConfigError, match=r"did you mean 'reward\.penetration'"):
        CornerEnv(task={"reward": {"penetratoin": 5}})
    with pytest.raises(PipenavError, match="no pipes given"):
        CornerEnv(pipes=())
    with pytest.raises(PipenavError, match="2 seeds given for 3 robots"):
        CornerVectorEnv(3, options=FAST).reset(seed=[1, 2])


def test_both_turns_render() -> None:
    for turn in ("left", "right"):
        env = CornerEnv(pipes=f"d=100,angle=60,turn={turn}", options=FAST, render_mode="rgb_array")
        env.reset(seed=1)
        picture = env.render()
        assert picture is not None
        assert (picture.shape, picture.dtype) == ((480, 480, 3), np.uint8)
        turned_to = {"left": picture[:160], "right": picture[320:]}  # the second leg is above or below
        assert turned_to[turn].min() < 128
        assert turned_to["right" if turn == "left" else "left"].min() == 255
