"""Training: Stable-Baselines3's PPO on a batched task, with a training folder that survives anything.

A stage of a training begins as a resumed training goes on: from the checkpoint, with new robots in new episodes. So a
training that is stopped between two stages, and resumed, computes what an uninterrupted one computes.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from stable_baselines3.common.logger import configure

from pipenav.envs.sb3_env import TaskVecEnv
from pipenav.learning.callback import TrainingCallback
from pipenav.learning.checkpoint import Checkpoint, load_checkpoint, load_weights, steps_done
from pipenav.learning.config import TrainConfig
from pipenav.learning.environment import open_training_batches
from pipenav.learning.imitation import imitate
from pipenav.learning.learner import Learner
from pipenav.learning.progress import TrainingProgress
from pipenav.learning.recordings import load_lessons
from pipenav.learning.schedule import LearningRate
from pipenav.learning.stages import TrainingStage, stage_at, training_stages
from pipenav.learning.training_folder import TrainingFolder
from pipenav.robots.robot import load_robot
from pipenav.tasks.registry import task_of
from pipenav.tasks.sampling import random_episodes

EPISODE_STOCK = 512
"""Episodes that are drawn at a time."""


class TrainingSummary(NamedTuple):
    """End of a training.

    Attributes:
        steps: control steps, of all robots together.
        seconds: seconds of training, without the pauses between resumptions.
        stopped: whether it was asked to stop before its last step.
        check_success: success of the best check.
    """

    steps: int
    seconds: float
    stopped: bool
    check_success: float


def train(
    config: TrainConfig,
    folder: TrainingFolder,
    resumed: bool = False,
    report: Callable[[TrainingProgress], None] | None = None,
    should_stop: Callable[[], bool] = lambda: False,
    start: Path | None = None,
) -> TrainingSummary:
    """Run PPO to `config.steps`, or until `should_stop`; then the folder holds best.zip, last.zip and the rest.

    Args:
        config: configuration of the training.
        folder: folder of this training.
        resumed: go on from the folder's checkpoint.
        report: called after each update.
        should_stop: asked at every step, and once before the first.
        start: folder of another training, from whose weights this one starts.

    Raises:
        TrainingDiverged: a non-finite value; best.zip and last.zip stay those of the last sound update.
        PipenavError: anything a user can mend.
    """
    torch.set_num_threads(1)  # physics has the cores; torch on one thread is 1.3 times faster for nets this small
    stages = training_stages(config)
    first = stage_at(stages, steps_done(folder.checkpoint)) if resumed else stages[0]
    if resumed:
        folder.write_config(config)  # its number of steps may have changed
    for stage in stages[first.number - 1 :]:
        going_on = resumed or stage is not first
        summary = _train_stage(_Beginning(stage, folder, going_on, None if going_on else start), report, should_stop)
        if summary.stopped:
            break
    return summary


class _Beginning(NamedTuple):
    """A stage of a training that is about to begin, or to go on.

    Attributes:
        stage: the stage.
        folder: folder of the training.
        resumed: go on from the folder's checkpoint, as each stage but the first does.
        start: folder of another training, from whose weights this one starts.
    """

    stage: TrainingStage
    folder: TrainingFolder
    resumed: bool
    start: Path | None


def _train_stage(
    beginning: _Beginning, report: Callable[[TrainingProgress], None] | None, should_stop: Callable[[], bool]
) -> TrainingSummary:
    """Run PPO to the end of a stage, or until `should_stop`."""
    stage, folder, resumed, start = beginning
    config = stage.config
    rng = np.random.default_rng(config.seed)
    env = training_env(config, rng)
    try:
        model = new_model(config, env, stage.learning_rate)
        checkpoint = load_checkpoint(folder.checkpoint, model, stage.number) if resumed else Checkpoint()
        if start is not None:
            load_weights(TrainingFolder.open(start).folder.checkpoint, model)
        if config.recordings.folders and not resumed:
            imitate(model, load_lessons(config), config, report)
        if resumed:  # other episodes than those that the training has had already
            rng.bit_generator.state = np.random.default_rng([config.seed, checkpoint.steps]).bit_generator.state
        should_stop()  # who is asked knows from here on that a stop is saved
        model.set_logger(configure(str(folder.path), ["tensorboard"]))
        callback = TrainingCallback(stage, folder, checkpoint, report, should_stop)
        env.stagger(rng)
        try:
            model.learn(max(stage.end - checkpoint.steps, 0), callback=callback, reset_num_timesteps=False)
        except (
            ValueError,
            RuntimeError,
        ) as error:  # what is not finite is refused by a distribution, or by the learner
            callback.require_sound(rollout=True, overflow="overflow" in str(error))
            raise
        callback.finish()
        return TrainingSummary(model.num_timesteps, callback.seconds, callback.stopped, callback.best_success)
    finally:
        env.close()


def training_env(config: TrainConfig, rng: np.random.Generator) -> TaskVecEnv:
    """The robots that a training steps together, in episodes that `rng` draws."""
    starting = task_of(config.randomise.starts(config.task))
    sets = [starting.parse_training_pipes([name]) for name in config.pipes]
    source = random_episodes(starting, load_robot(config.robot), sets, rng, EPISODE_STOCK)
    return TaskVecEnv(*open_training_batches(config, config.learner.robots, source))


def new_model(config: TrainConfig, env: TaskVecEnv, learning_rate: LearningRate | None = None) -> Learner:
    """A fresh learner, as the configuration says; its learning rate falls over its whole training if not given."""
    learner = config.learner
    model = Learner(
        "MlpPolicy",
        env,
        n_steps=learner.rollout_steps,
        batch_size=learner.batch_size,
        n_epochs=learner.epochs,
        learning_rate=learning_rate or LearningRate(learner.learning_rate),
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
