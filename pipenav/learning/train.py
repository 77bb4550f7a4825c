"""Training: Stable-Baselines3's PPO on a batched task, with a run folder that survives anything."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.logger import configure

from pipenav.backends.simulators import open_simulator
from pipenav.disturbances.disturbed_backend import disturbed
from pipenav.envs.sb3_env import TaskVecEnv
from pipenav.learning import checkpoint
from pipenav.learning.callback import Progress, TrainingCallback
from pipenav.learning.config import TrainConfig
from pipenav.learning.schedule import LearningRate
from pipenav.learning.training_folder import TrainingFolder
from pipenav.robots.robot import load_robot
from pipenav.tasks.registry import task_of
from pipenav.tasks.sampling import random_episodes

EPISODE_STOCK = 512
"""How many episodes are drawn at a time."""


class TrainingSummary(NamedTuple):
    """How a run ended."""

    steps: int
    seconds: float
    stopped: bool
    check_success: float


def train(
    config: TrainConfig,
    folder: TrainingFolder,
    resumed: bool = False,
    report: Callable[[Progress], None] | None = None,
    should_stop: Callable[[], bool] = lambda: False,
    start: Path | None = None,
) -> TrainingSummary:
    """Run PPO to `config.steps`, or until `should_stop`; then the folder holds best.zip, last.zip and the rest.

    Args:
        config: what to compute.
        folder: of this run.
        resumed: go on with what the folder holds.
        report: told of each update.
        should_stop: asked at every step.
        start: folder of another run, whose weights a new one starts from.

    Raises:
        TrainingDiverged: a non-finite value; best.zip and last.zip stay those of the last sound update.
        PipenavError: anything a user can mend.
    """
    torch.set_num_threads(1)  # physics has the cores; torch on one thread is 1.3 times faster for nets this small
    robot = load_robot(config.robot)
    task = task_of(config.task)
    sets = [task.parse_training_pipes([name]) for name in config.pipes]
    n = config.learner.robots
    segments = max(len(pipe.segments) for pipes in sets for pipe in pipes)
    rng = np.random.default_rng(config.seed)
    simulator = open_simulator(config.backend, robot, n, config.options, segments)
    backend = disturbed(simulator, robot, n, config.randomise, config.seed)
    starting = task_of(config.randomise.starts(config.task))
    batch = task.batch(robot, backend, n, random_episodes(starting, robot, sets, rng, EPISODE_STOCK))
    env = TaskVecEnv(batch)
    try:
        model = new_model(config, env)
        state = checkpoint.load_state(folder.resume, model) if resumed else checkpoint.State(0, 0.0, -1.0)
        if start is not None:
            checkpoint.load_weights(TrainingFolder.open(start)[0].resume, model)
        if resumed:  # other episodes than those that the run has had already
            rng.bit_generator.state = np.random.default_rng([config.seed, state.steps]).bit_generator.state
        model.set_logger(configure(str(folder.path), ["tensorboard"]))
        watch = TrainingCallback(config, folder, state, report, should_stop)
        batch.stagger(rng)
        model.learn(max(config.steps - state.steps, 0), callback=watch, reset_num_timesteps=False)
        watch.finish()
        return TrainingSummary(model.num_timesteps, watch.seconds, watch.stopped, watch.best_success)
    finally:
        env.close()


def new_model(config: TrainConfig, env: TaskVecEnv) -> PPO:
    """A fresh learner, as the configuration says."""
    learner = config.learner
    model = PPO(
        "MlpPolicy",
        env,
        n_steps=learner.rollout_steps,
        batch_size=learner.batch_size,
        n_epochs=learner.epochs,
        learning_rate=LearningRate(learner.learning_rate),
        gamma=learner.gamma,
        gae_lambda=learner.gae_lambda,
        clip_range=learner.clip,
        seed=config.seed,
        device="cpu",
        policy_kwargs={
            "net_arch": {"pi": list(config.network.policy), "vf": list(config.network.value)},
            "activation_fn": torch.nn.Tanh,
        },
    )
    model.policy.log_std.requires_grad_(False)  # the schedule of the configuration sets it
    return model
