"""The environment adapters: the libraries' own checkers, seeds, automatic resets."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from stable_baselines3.common import env_checker as sb3_checker

from pipenav.env import CornerEnv, CornerVectorEnv, TraverseEnv, TraverseVectorEnv
from pipenav.envs.threads import CHOSEN_BY
from pipenav.errors import ConfigError, PipenavError, UnknownName
from pipenav.learning.config import load_config
from pipenav.learning.stages import training_stages

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


IDS = ["pipenav/Corner-v0", "pipenav/Traverse-v0"]


@pytest.mark.parametrize("name", IDS)
def test_gymnasium_checks_it_without_a_warning(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(name, render_mode="rgb_array", options=FAST).unwrapped)


@pytest.mark.parametrize("task", ["basic", "history", "relative", "relative-history"])
def test_no_reading_of_a_sound_simulation_reaches_a_bound(task: str) -> None:
    """Robots that are driven as hard as can be, into walls and stops."""
    settings = {"observation": task, "max_steps": 60}
    _drive_hard(CornerVectorEnv(16, pipes=("working-range",), task=settings, options=FAST))


def test_no_reading_of_a_sound_whole_robot_reaches_a_bound() -> None:
    _drive_hard(TraverseVectorEnv(8, task={"inclination_deg": (0.0, 360.0)}, options=FAST))


def _drive_hard(vector: CornerVectorEnv | TraverseVectorEnv) -> None:
    high, rng = vector.single_observation_space.high, np.random.default_rng(0)
    assert np.isfinite(high).all()
    observation, _ = vector.reset(seed=0)
    seen = np.abs(observation).max(axis=0)
    for step in range(120):
        if step % 10 == 0:
            action = rng.choice([-1.0, 1.0], vector.action_space.shape).astype(np.float32)
        observation = vector.step(action)[0]
        seen = np.maximum(seen, np.abs(observation).max(axis=0))
    assert (seen[high > 1] < high[high > 1] / 1.5).all()
    assert (seen <= high).all()
    vector.close()


@pytest.mark.parametrize("name", IDS)
def test_an_action_that_is_no_number_is_an_error(name: str) -> None:
    env, vector = gymnasium.make(name, options=FAST), gymnasium.make_vec(name, num_envs=3, options=FAST)
    env.reset(seed=1), vector.reset(seed=1)
    action = np.zeros(env.action_space.shape, np.float32)
    action[2] = np.nan
    with pytest.raises(PipenavError, match=r"^action\[2\] is not a number \(NaN\): give numbers from -1 to 1\.$"):
        env.step(action)
    with pytest.raises(PipenavError, match=r"^action\[1\]\[2\] is not a number \(NaN\)"):
        vector.step(np.stack([np.zeros_like(action), action, np.zeros_like(action)]))
    with pytest.raises(PipenavError, match=r"an action of shape \(2,\) was given: give one of shape"):
        env.unwrapped.step(np.zeros(2))


def test_the_action_of_a_robot_that_starts_anew_is_ignored_even_where_it_is_no_number() -> None:
    one, other = (CornerVectorEnv(2, task={"max_steps": 1}, options=FAST) for _ in range(2))
    for vector in (one, other):
        vector.reset(seed=1)
        vector.step(np.zeros((2, 4), np.float32))
    ignored = one.step(np.full((2, 4), np.nan, np.float32))[0]
    np.testing.assert_array_equal(ignored, other.step(np.zeros((2, 4), np.float32))[0])


@pytest.mark.parametrize(
    ("name", "preset"), [(IDS[0], "high-fidelity"), (IDS[0], "arm"), (IDS[1], "pirate-strong-gravity")]
)
def test_a_preset_gives_every_argument_that_is_not_given(name: str, preset: str) -> None:
    config = training_stages(load_config(preset))[-1].config
    options = dict(config.options)
    told = gymnasium.make(
        name, robot=config.robot, pipes=config.pipes, task=config.task, backend=config.backend, options=options
    )
    named = gymnasium.make(name, preset=preset)
    np.testing.assert_array_equal(named.reset(seed=3)[0], told.reset(seed=3)[0])
    one = gymnasium.make_vec(name, num_envs=2, preset=preset, pipes=["d=100,angle=90"])
    assert {pipe.angle for pipe in one.reset(seed=3) and one.batch.pipes} == {np.pi / 2}


def test_presets_of_another_kind_are_refused() -> None:
    with pytest.raises(UnknownName, match="unknown preset 'priate': did you mean 'pirate'"):
        gymnasium.make(IDS[1], preset="priate")
    with pytest.raises(PipenavError, match="preset 'arm' is of the task 'reach': choose one of pirate"):
        gymnasium.make(IDS[1], preset="arm")
    with pytest.raises(PipenavError, match="preset 'robust' disturbs the robot, which environments cannot do: choose"):
        gymnasium.make(IDS[0], preset="robust")
    with pytest.raises(PipenavError, match="moves an arm: make pipenav/Traverse-v0"):
        gymnasium.make(IDS[0], robot="pirate")
    with pytest.raises(PipenavError, match="moves a whole robot: make pipenav/Corner-v0"):
        gymnasium.make(IDS[1], robot="basic")


@pytest.mark.parametrize("name", IDS)
def test_every_robot_of_a_vector_env_has_a_picture(name: str) -> None:
    vector = gymnasium.make_vec(name, num_envs=2, options=FAST, render_mode="rgb_array")
    with pytest.raises(PipenavError, match="nothing to draw before the first reset"):
        vector.render()
    vector.reset(seed=1)
    pictures = vector.render()
    assert [picture.shape for picture in pictures] == [(480, 480, 3)] * 2
    assert not np.array_equal(*pictures)
    blind = gymnasium.make_vec(name, num_envs=2, options=FAST)
    blind.reset(seed=1)
    assert blind.render() is None
    with pytest.raises(TypeError, match="unexpected keyword argument 'rendr_mode'"):
        gymnasium.make_vec(name, num_envs=2, rendr_mode="rgb_array")


@pytest.mark.slow
@pytest.mark.parametrize("name", IDS)
def test_gymnasium_records_films_of_one_robot_and_of_several(name: str, tmp_path: Path) -> None:
    pytest.importorskip("moviepy")
    made = {"options": FAST, "render_mode": "rgb_array"}
    one = gymnasium.wrappers.RecordVideo(gymnasium.make(name, **made), str(tmp_path / "one"), video_length=3)
    several = gymnasium.wrappers.vector.RecordVideo(
        gymnasium.make_vec(name, num_envs=2, **made), str(tmp_path / "several"), video_length=3
    )
    for env in (one, several):
        env.reset(seed=1)
        for _ in range(4):
            env.step(env.action_space.sample())
        env.close()
    assert all(list((tmp_path / folder).glob("*.mp4")) for folder in ("one", "several"))


@pytest.mark.slow
@pytest.mark.parametrize(("chosen", "threads"), [({}, "1 2"), ({"OMP_NUM_THREADS": "2"}, "2 2")])
def test_torch_has_one_thread_unless_somebody_chose_more(chosen: dict[str, str], threads: str) -> None:
    """Plain Stable-Baselines3 on one environment: a thread per core makes it wait, for any environment."""
    code = (
        "import torch, gymnasium, pipenav.env; torch.set_num_threads(2) if torch.get_num_threads() < 2 else None;"
        "env = gymnasium.make('pipenav/Corner-v0'); env.reset(seed=1); first = torch.get_num_threads();"
        "torch.set_num_threads(2); env.reset(); print(first, torch.get_num_threads())"
    )
    kept = {key: value for key, value in os.environ.items() if key not in CHOSEN_BY}
    done = subprocess.run([sys.executable, "-c", code], env=kept | chosen, check=True, capture_output=True, text=True)
    assert done.stdout.strip() == threads


def test_one_robot_is_stepped_by_the_thread_that_asks() -> None:
    code = (
        "import os, gymnasium, pipenav.env;"
        "count = lambda: len(os.listdir('/proc/self/task'));"
        "before = count(); env = gymnasium.make('pipenav/Corner-v0'); env.reset(seed=1);"
        "env.step(env.action_space.sample()); print(count() - before)"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "0"


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


@pytest.mark.parametrize(("name", "single"), [(IDS[0], CornerEnv), (IDS[1], TraverseEnv)])
def test_a_vector_env_is_n_single_ones(name: str, single: type[CornerEnv] | type[TraverseEnv]) -> None:
    n, seed = 3, 11
    vector = gymnasium.make_vec(name, num_envs=n, task=SHORT, options=FAST)
    singles = [single(task=SHORT, options=FAST) for _ in range(n)]
    assert isinstance(vector, CornerVectorEnv | TraverseVectorEnv)
    assert vector.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    observation, _ = vector.reset(seed=seed)
    assert np.array_equal(observation, [env.reset(seed=seed + i)[0] for i, env in enumerate(singles)])
    assert vector.observation_space.contains(observation)
    ended, rng = [False] * n, np.random.default_rng(0)
    for _ in range(3 * SHORT["max_steps"]):
        actions = rng.uniform(-1, 1, vector.action_space.shape).astype(np.float32)
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
