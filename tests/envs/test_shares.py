"""Shares of robots that take turns: they live through what one batch lives through, however long a step takes."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from typing import Any

import numpy as np
import pytest
from helpers.shares import ROBOT, Dawdling, env_of
from hypothesis import given, settings
from hypothesis import strategies as st
from pipenav_mujoco.backend import MujocoBackend, MujocoOptions

from pipenav.backends.messages import Command
from pipenav.envs.sb3_env import TaskVecEnv
from pipenav.envs.shares import joined

STEPS = 16


def lived(env: TaskVecEnv, actions: np.ndarray) -> list[Any]:
    """Everything that an environment answers to some actions, step by step."""
    with closing(env):
        answers: list[Any] = [env.reset()]
        for action in actions:
            *arrays, infos = env.step(action)
            answers.append((*arrays, env.min_range.copy(), infos))
    return answers


def lived_in_turns(env: TaskVecEnv, actions: np.ndarray) -> list[Any]:
    """The same, with each share sent on as soon as it was received, as the learner does it."""
    with closing(env):
        answers: list[Any] = [env.reset()]
        for share in env.shares:
            share.send(actions[0][share.rows])
        for following in [*actions[1:], None]:
            steps = []
            for share in env.shares:
                steps.append(env.receive(share))
                if following is not None:
                    share.send(following[share.rows])
            arrays = [np.concatenate(part) for part in zip(*(s[:3] for s in steps), strict=True)]
            answers.append((*arrays, env.min_range.copy(), joined(env.shares, [step.ended for step in steps])))
    return answers


def assert_same(a: Any, b: Any) -> None:
    if isinstance(a, np.ndarray):
        assert np.array_equal(a, b)
    elif isinstance(a, dict):
        assert a.keys() == b.keys()
        assert_same(list(a.values()), list(b.values()))
    elif isinstance(a, list | tuple):
        assert len(a) == len(b)
        for x, y in zip(a, b, strict=True):
            assert_same(x, y)
    else:
        assert a == b


def drawn(seed: int, n: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (STEPS, n, len(ROBOT.driven_actuators)))


@given(st.lists(st.integers(1, 4), min_size=1, max_size=3), st.integers(0, 1000))
@settings(max_examples=20)
def test_shares_live_through_what_one_batch_does(sizes: Sequence[int], seed: int) -> None:
    actions = drawn(seed, sum(sizes))
    alone = lived(env_of([sum(sizes)], seed), actions)
    assert any(step[2].any() for step in alone[1:])
    assert_same(lived(env_of(sizes, seed), actions), alone)


@given(st.integers(0, 1000))
@settings(max_examples=5, deadline=None)
def test_the_time_that_a_step_takes_changes_nothing(seed: int) -> None:
    actions, pause = drawn(seed, 5), np.random.default_rng(seed)
    prompt = lived_in_turns(env_of([3, 2], seed), actions)
    assert_same(
        lived_in_turns(env_of([3, 2], seed, lambda n: Dawdling(n, lambda: pause.uniform(0, 2e-3))), actions), prompt
    )
    plain = lived(env_of([5], seed), actions)
    for (*arrays, ended), (*same, infos) in zip(prompt[1:], plain[1:], strict=True):
        assert_same(arrays, same)
        told = {
            int(i): (int(n), bool(late)) for i, n, late in zip(ended.robots, ended.steps, ended.cut_off, strict=True)
        }
        assert told == {i: (info["episode"]["l"], info["TimeLimit.truncated"]) for i, info in enumerate(infos) if info}


@pytest.mark.parametrize("threads", [1, 3])
def test_mujoco_moves_in_turns_as_it_does_alone(threads: int) -> None:
    def simulator(n: int) -> MujocoBackend:
        return MujocoBackend(ROBOT, n, MujocoOptions(threads=threads, timestep=0.005))

    actions = drawn(1, 6)
    alone = lived_in_turns(env_of([6], 1, simulator), actions)
    assert_same(lived_in_turns(env_of([2, 4], 1, simulator), actions), alone)


def test_a_reset_gives_up_a_step_that_has_begun() -> None:
    env, untouched = env_of([2, 2]), env_of([2, 2])
    with closing(env), closing(untouched):
        env.reset()
        env.step_async(np.ones((4, 4)))
        again = env.reset()
        untouched.reset()
        assert np.array_equal(again, untouched.reset())
        assert not any(share.moving for share in env.shares)
        assert_same(env.step(np.zeros((4, 4))), untouched.step(np.zeros((4, 4))))


def test_what_goes_wrong_in_a_thread_reaches_the_caller() -> None:
    class Broken(Dawdling):
        def step(self, command: Command) -> None:  # noqa: ARG002
            raise ArithmeticError("broken")

    with closing(env_of([2, 2], simulator=Broken)) as env:
        env.reset()
        with pytest.raises(ArithmeticError, match="broken"):
            env.step(np.zeros((4, 4)))
