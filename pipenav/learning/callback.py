"""Watching a training run: exploration noise, counting, checks, saving, and stopping when something goes wrong."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import torch
from stable_baselines3.common.callbacks import BaseCallback

from pipenav.backends.simulators import SimulatorSettings
from pipenav.errors import PipenavError
from pipenav.evaluation.passage import run_task
from pipenav.learning import checkpoint
from pipenav.learning.config import TrainConfig
from pipenav.learning.figures import write_training_plot
from pipenav.learning.training_folder import TrainingFolder
from pipenav.policies.header import PolicyHeader, header_for
from pipenav.policies.named import PolicyController
from pipenav.policies.policy import load_policy, save_policy
from pipenav.robots.robot import load_robot
from pipenav.storage.atomic_files import atomic_write
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.registry import task_of

NOISE_SETTLED = 0.9
"""Share of the steps after which the exploration noise stays at its last value."""

SAVE_EVERY_S = 10.0
"""What a killed run may lose [s]."""

CHECK_SEED = 1_000_003
"""Added to the run's seed for checks: not the seed of an evaluation that anybody is likely to type."""


class Progress(NamedTuple):
    """What a run reports after each update.

    Attributes:
        steps: control steps so far.
        steps_per_s: since the last report.
        success: share of the episodes since the last report that reached their target; NaN without any.
        min_range: mean over steps of the smallest laser reading [m].
        check_success: success of the last noise-free check; NaN before the first.
    """

    steps: int
    steps_per_s: float
    success: float
    min_range: float
    check_success: float


class TrainingDiverged(PipenavError):
    """A value became infinite or not a number; the state that caused it was saved."""


def noise_at(config: TrainConfig, steps: int) -> float:
    """Standard deviation of exploration after so many control steps."""
    done = min(steps / (NOISE_SETTLED * config.steps), 1.0)
    return config.learner.noise_start + (config.learner.noise_stop - config.learner.noise_start) * done


class TrainingCallback(BaseCallback):  # type: ignore[misc]  # Stable-Baselines3 is imported untyped
    """Sets the noise, counts, checks, saves; stops on request and on non-finite values."""

    def __init__(
        self,
        config: TrainConfig,
        folder: TrainingFolder,
        state: checkpoint.State,
        report: Callable[[Progress], None] | None,
        should_stop: Callable[[], bool],
    ) -> None:
        super().__init__()
        self._config, self._folder = config, folder
        self._report, self._should_stop = report, should_stop
        self.best_success = state.best_success
        self.stopped = False
        self._check_success = math.nan
        self._earlier_seconds = state.seconds
        self._started = self._last_time = time.monotonic()
        self._last_steps = state.steps
        self._next_check = state.steps + config.check.every
        self._clear_counts()

    @property
    def seconds(self) -> float:
        return self._earlier_seconds + time.monotonic() - self._started

    def _clear_counts(self) -> None:
        self._episodes = self._successes = self._episode_steps = 0
        self._min_range, self._reward, self._samples = 0.0, 0.0, 0

    def _on_rollout_start(self) -> None:
        self.model.policy.log_std.data.fill_(math.log(noise_at(self._config, self.num_timesteps)))
        if self.n_calls:
            self._after_update()

    def _on_step(self) -> bool:
        env = self.training_env
        rewards, observations = self.locals["rewards"], self.locals["new_obs"]
        if not (np.isfinite(observations).all() and np.isfinite(rewards).all()):
            self._diverge(observations, rewards)
        self._min_range += float(env.min_range.sum())
        self._reward += float(rewards.sum())
        self._samples += len(rewards)
        for info in self.locals["infos"]:
            if info:
                self._episodes += 1
                self._successes += info["outcome"] == Outcome.REACHED.label
                self._episode_steps += info["episode"]["l"]
        self.stopped = self.stopped or self._should_stop()
        return not self.stopped

    def _after_update(self) -> None:
        """Between two rollouts the policy is a sound one: the moment to look at it and to save it."""
        self._require_finite_weights()
        self._report_progress()
        if self.num_timesteps >= self._next_check:
            self._next_check += self._config.check.every
            self.check()
            self.save()
            write_training_plot(self._folder.plot, self._folder.progress)
        elif time.monotonic() - self._last_saved > SAVE_EVERY_S:
            self.save()

    def _on_training_start(self) -> None:
        self.save()  # from here on there is a run to resume, whatever happens

    def finish(self) -> None:
        self._require_finite_weights()
        self._report_progress()
        if not self.stopped or not self._folder.best.exists():
            self.check()
        self.save()
        write_training_plot(self._folder.plot, self._folder.progress)

    def _report_progress(self) -> None:
        now = time.monotonic()
        steps = self.num_timesteps
        if steps == self._last_steps:
            return
        episodes = self._episodes
        row = Progress(
            steps=steps,
            steps_per_s=(steps - self._last_steps) / max(now - self._last_time, 1e-9),
            success=self._successes / episodes if episodes else math.nan,
            min_range=self._min_range / max(self._samples, 1),
            check_success=self._check_success,
        )
        self._folder.add_progress(
            {
                "steps": steps,
                "seconds": f"{self.seconds:.2f}",
                "steps_per_s": f"{row.steps_per_s:.0f}",
                "success": f"{row.success:.4f}" if episodes else "",
                "clearance_m": f"{row.min_range:.5f}",
                "reward": f"{self._reward / max(self._samples, 1):.4f}",
                "episode_steps": f"{self._episode_steps / episodes:.2f}" if episodes else "",
                "std": f"{float(self.model.policy.log_std.exp()[0]):.3f}",
                "check_success": "" if math.isnan(self._check_success) else f"{self._check_success:.4f}",
            }
        )
        self._last_time, self._last_steps = now, steps
        self._clear_counts()
        if self._report is not None:
            self._report(row)

    def save(self) -> None:
        """Write last.zip, what `--resume` needs, and progress.csv."""
        folder, model = self._folder, self.model
        save_policy(folder.last, model, self._header())
        checkpoint.save_state(
            folder.resume, model, checkpoint.State(model.num_timesteps, self.seconds, self.best_success)
        )
        folder.write_progress()
        self._last_saved = time.monotonic()

    def check(self) -> None:
        """Measure the policy without its noise, and keep it as best.zip if none was better."""
        save_policy(self._folder.last, self.model, self._header())
        self._check_success = self._measure()
        if self._check_success >= self.best_success:  # of equals the later one, which explored less
            self.best_success = self._check_success
            save_policy(self._folder.best, self.model, self._header())

    def _measure(self) -> float:
        """Success of the noise-free policy on episodes spread evenly over the training pipes."""
        check = self._config.check
        pipes = task_of(self._config.task).parse_training_pipes(self._config.pipes)
        chosen = [pipes[i] for i in np.linspace(0, len(pipes) - 1, min(check.episodes, len(pipes))).astype(int)]
        each = math.ceil(check.episodes / len(chosen))
        seed = self._config.seed + CHECK_SEED
        controller = PolicyController(load_policy(self._folder.last))
        config = self._config
        results = run_task(
            controller, chosen, each, seed, SimulatorSettings(config.backend, config.options), config.randomise
        )
        return float((results.outcome == Outcome.REACHED).mean())

    def _header(self) -> PolicyHeader:
        config = self._config
        training: dict[str, str | int | float | bool] = {
            "steps": self.num_timesteps,
            "seconds": round(self.seconds, 1),
            "seed": config.seed,
            "description": config.description,
        }
        return header_for(load_robot(config.robot), config.task, list(config.pipes), training)

    def _require_finite_weights(self) -> None:
        flat = torch.nn.utils.parameters_to_vector(self.model.policy.parameters())
        if not bool(torch.isfinite(flat).all()):
            self._diverge(self.locals["new_obs"], self.locals["rewards"])

    def _diverge(self, observations: np.ndarray, rewards: np.ndarray) -> None:
        """Save what was seen and stop."""
        bad = ~(np.isfinite(observations).all(axis=1) & np.isfinite(rewards))
        env = self.training_env
        robots = np.flatnonzero(bad) if bad.any() else np.arange(len(rewards))
        cause = {
            "steps": self.num_timesteps,
            "robots": robots.tolist(),
            "pipes": [pipe.name if (pipe := env.batch.pipes[i]) else "" for i in robots],
            "observations": _printable(observations[robots]),
            "rewards": _printable(rewards[robots]),
            "observations_before": _printable(np.asarray(self.model._last_obs)[robots]),
            "actions": _printable(np.asarray(self.locals["actions"])[robots]),
        }
        atomic_write(self._folder.diverged, json.dumps(cause, indent=1) + "\n")
        raise TrainingDiverged(
            f"training stopped after {self.num_timesteps} steps at a value that is not finite: the state that caused "
            f"it is in {self._folder.diverged}, the last sound policy in {self._folder.last} if there is one."
        )


def _printable(values: np.ndarray) -> list[Any]:
    """Nested lists in which non-finite numbers are strings, since JSON has none."""
    return [
        _printable(value) if isinstance(value, np.ndarray) else float(value) if math.isfinite(value) else str(value)
        for value in values
    ]
