"""Speed of the default preset, as ratios measured in one go: `python benchmarks/throughput.py`.

(a) bare physics: the same model in MuJoCo's Batch on all cores, nothing else
(b) the vector environment: laser, reward and resets as well, in turns of two shares as in (c)
(c) training with the first stage of the default preset, updates included
(d) Stable-Baselines3's default PPO on one Gymnasium environment under DummyVecEnv

They are measured alternately, several times, and the medians are compared, since the machine may be shared. Then (c)
and (d) are trained until 99 % of held-out episodes succeed.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"  # before numpy is imported; physics has the cores

import gymnasium
import mujoco.batch
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import DummyVecEnv

import pipenav.env  # noqa: F401  # registers the environment
from pipenav.backends.simulators import open_simulator
from pipenav.backends.wall_boxes import wall_boxes
from pipenav.envs.sb3_env import TaskVecEnv
from pipenav.learning.config import TrainConfig, load_config
from pipenav.learning.schedule import Schedule, noise_at
from pipenav.learning.stages import training_stages
from pipenav.learning.train import new_model, training_env
from pipenav.pipes.corner_sets import parse_corners
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach import episode
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.registry import task_of

HELD_OUT = [f"d={d},angle={a},turn={t}" for d in (76, 93, 114) for a in (58, 78, 98, 118) for t in ("left", "right")]
"""Pipes that are in no training set."""


def make_env(config: TrainConfig, seed: int) -> TaskVecEnv:
    """Robots of a training with this configuration."""
    sets = [task_of(config.task).parse_training_pipes([name]) for name in config.pipes]
    slots = max(len(pipe.segments) for pipes in sets for pipe in pipes)
    for pipes in sets:  # computed once for each pipe, in the first seconds of a training
        wall_boxes(pipes, slots, np.zeros(len(pipes)))
    return training_env(config, np.random.default_rng(seed))


class Rates(NamedTuple):
    """Control steps per second of bare physics (a) and of the vector environment (b)."""

    bare: float
    full: float


class Moment(NamedTuple):
    """Everything that decides how the robots move in one control step.

    Attributes:
        states: states of the simulations with the controls of this step, (n, size).
        walls: sizes of all geoms, (n, geoms, 3) [m].
        actions: actions of the step, (n, actions).
    """

    states: np.ndarray
    walls: np.ndarray
    actions: np.ndarray


class SideBySide:
    """Measures (a) and (b) on the same robots, states and actions.

    A first environment goes ahead, with the learner of (c) acting, so that contacts are as frequent as in training.
    Then bare physics repeats its control steps one by one, and a second environment with the same episodes repeats
    them in turns of its shares, as the learner has them.
    """

    def __init__(self, config: TrainConfig, actor: PPO) -> None:
        self.ahead, self.behind, self.actor = make_env(config, seed=1), make_env(config, seed=1), actor
        self.observation = self.ahead.reset()
        assert np.array_equal(self.observation, self.behind.reset())
        self.simulators = [share.batch._simulator for share in self.ahead.shares]
        first = self.simulators[0]
        self.physics = mujoco.batch.Batch(first._model, self.ahead.num_envs)
        for name in ("actuator_gainprm", "actuator_biasprm"):  # servos of one kind of robot, the same for all
            self.physics.expand(name)
        self.walls = self.physics.expand("geom_size")

    def rates(self, steps: int) -> Rates:
        """Measure both over so many control steps."""
        moments = [self._go_ahead() for _ in range(steps)]
        bare = sum(self._bare_seconds(moment) for moment in moments)
        started = time.perf_counter()
        for k, moment in enumerate(moments):
            for share in self.behind.shares:
                step = self.behind.receive(share) if k else None
                share.send(moment.actions[share.rows])
        steps_seen = [self.behind.receive(share) for share in self.behind.shares]
        full = time.perf_counter() - started
        assert step is None or np.array_equal(
            np.concatenate([step.observation for step in steps_seen]), self.observation
        )
        samples = steps * self.ahead.num_envs
        return Rates(samples / bare, samples / full)

    def _go_ahead(self) -> Moment:
        actions, _ = self.actor.predict(self.observation)
        states = [simulator._batch.state.copy() for simulator in self.simulators]
        walls = [simulator._batch.expand("geom_size").copy() for simulator in self.simulators]
        self.observation, *_ = self.ahead.step(actions)
        for simulator, state in zip(self.simulators, states, strict=True):
            controls, now = simulator._batch.bind("ctrl").copy(), simulator._batch.state.copy()
            simulator._batch.state[:] = state
            simulator._batch.bind("ctrl")[:] = controls
            state[:] = simulator._batch.state
            simulator._batch.state[:] = now
        return Moment(np.concatenate(states), np.concatenate(walls), actions)

    def _bare_seconds(self, moment: Moment) -> float:
        """Time of bare physics for one control step of all robots [s]."""
        servos = self.simulators[0]
        self.physics.expand("actuator_gainprm")[:] = servos._gain[0]
        self.physics.expand("actuator_biasprm")[:] = servos._bias[0]
        self.physics.state[:], self.walls[:] = moment.states, moment.walls
        started = time.perf_counter()
        self.physics.step(nstep=servos._substeps)
        return time.perf_counter() - started


def rate(action: Callable[[], object], samples: int) -> float:
    """Samples per second of an action that takes so many."""
    started = time.perf_counter()
    action()
    return samples / (time.perf_counter() - started)


def baseline_env(config: TrainConfig) -> gymnasium.Env:
    """Gymnasium environment of (d)."""
    options = dict(config.options)
    return gymnasium.make("pipenav/Corner-v0", pipes=list(config.pipes), task=config.task, options=options)


class UntilSolved(BaseCallback):
    """Ends a training at 99 % success on held-out pipes, or at a time limit.

    Args:
        config: configuration of the training.
        every: control steps from one evaluation to the next.
        limit_s: longest time of training, without its evaluations [s].
        set_noise: whether the exploration noise follows the configuration, as in pipenav's own training.
    """

    def __init__(self, config: TrainConfig, every: int, limit_s: float, set_noise: bool) -> None:
        super().__init__()
        self.config, self.every, self.limit_s, self.set_noise = config, every, limit_s, set_noise
        self.next, self.outside, self.seconds, self.success = every, 0.0, float("nan"), 0.0
        self.started = time.perf_counter()

    def _on_rollout_start(self) -> None:
        if self.set_noise:
            self.model.policy.log_std.data.fill_(
                np.log(noise_at(self.config.learner, Schedule(0, self.config.steps), self.num_timesteps))
            )

    def _on_step(self) -> bool:
        if self.num_timesteps < self.next:
            return True
        self.next += self.every
        before = time.perf_counter()
        self.success = held_out_success(self.model, self.config)
        self.outside += time.perf_counter() - before
        self.seconds = time.perf_counter() - self.started - self.outside
        return self.success < 0.99 and self.seconds < self.limit_s


def held_out_success(model: PPO, config: TrainConfig, each: int = 10) -> float:
    """Success rate of a model on the held-out pipes, with `each` episodes in each, at the default physics step."""
    robot = load_robot(config.robot)
    pipes = [pipe for pipe in parse_corners(HELD_OUT) for _ in range(each)]
    rng = np.random.default_rng(3)
    episodes = episode.sample(robot, config.task, pipes, rng)
    backend = open_simulator(config.backend, robot, len(pipes), {})
    batch = ReachBatch(robot, config.task, backend, len(pipes), lambda _: episodes)
    observation, ended = batch.reset(), np.zeros(len(pipes), np.int8)
    while not ended.all():
        actions, _ = model.predict(observation.astype(np.float32), deterministic=True)
        step = batch.step(actions)
        observation = step.observation
        ended = np.where(ended == Outcome.RUNNING, step.outcome, ended)
    return float((ended == Outcome.REACHED).mean())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--preset", help="another preset of an arm")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--limit", type=float, default=240.0, help="seconds that (d) may train for")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    config = training_stages(load_config(arguments.preset))[0].config
    print(json.dumps(measure_rates(config, arguments.repeats) | measure_times(config, arguments.limit), indent=1))


def measure_rates(config: TrainConfig, repeats: int) -> dict[str, float]:
    """Rates of (a) to (d) and their ratios, by their names in the output."""
    n, steps = config.learner.robots, config.learner.rollout_steps
    ours = new_model(config, make_env(config, seed=4))
    plain = PPO("MlpPolicy", DummyVecEnv([partial(baseline_env, config)]), device="cpu", seed=0)
    ours.learn(10 * n * steps)  # past the first flailing
    plain.learn(256)
    side_by_side = SideBySide(config, ours)
    side_by_side.rates(steps)
    rates: dict[str, list[float]] = {key: [] for key in "abcd"}
    for _ in range(repeats):
        measured = side_by_side.rates(2 * steps)
        rates["a"].append(measured.bare)
        rates["b"].append(measured.full)
        rates["c"].append(rate(lambda: ours.learn(4 * n * steps, reset_num_timesteps=False), 4 * n * steps))
        rates["d"].append(rate(lambda: plain.learn(2048, reset_num_timesteps=False), 2048))
    median = {key: statistics.median(values) for key, values in rates.items()}
    return {
        "bare physics [control steps/s]": round(median["a"]),
        "vector env [control steps/s]": round(median["b"]),
        "training [control steps/s]": round(median["c"]),
        "SB3 default [control steps/s]": round(median["d"]),
        "b/a": round(median["b"] / median["a"], 3),
        "c/a": round(median["c"] / median["a"], 3),
        "c/d": round(median["c"] / median["d"], 2),
    }


def measure_times(config: TrainConfig, limit: float) -> dict[str, float]:
    """Training times of (c) and (d), by their names in the output."""
    ours = new_model(config, make_env(config, seed=5))
    fast = UntilSolved(config, 4096, limit, set_noise=True)
    ours.learn(config.steps, callback=fast)
    plain = PPO("MlpPolicy", DummyVecEnv([partial(baseline_env, config)]), device="cpu", seed=0)
    slow = UntilSolved(config, 8192, limit, set_noise=False)
    plain.learn(10_000_000, callback=slow)
    return {
        "training, seconds to 99 % held-out": round(fast.seconds, 1),
        "training, held-out success reached": fast.success,
        "SB3 default, seconds to 99 % held-out (or the limit)": round(slow.seconds, 1),
        "SB3 default, held-out success reached": slow.success,
    }


if __name__ == "__main__":
    main()
