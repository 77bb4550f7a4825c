"""The callback of a training: exploration noise, counting, checks, saving, and stopping when something goes wrong."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from pipenav.arrays import Floats
from pipenav.backends.simulators import SimulatorSettings
from pipenav.evaluation.passage import run_task
from pipenav.learning.checkpoint import NO_CHECK, Checkpoint, save_checkpoint
from pipenav.learning.checks import read_checks, write_checks
from pipenav.learning.divergence import Seen, TrainingDiverged, is_sound, write_cause
from pipenav.learning.figures import write_training_plot
from pipenav.learning.html_report import write_training_page
from pipenav.learning.progress import TrainingProgress
from pipenav.learning.schedule import noise_at
from pipenav.learning.stages import TrainingStage
from pipenav.learning.training_folder import TrainingFolder
from pipenav.policies.header import PolicyHeader, header_for
from pipenav.policies.named import PolicyController
from pipenav.policies.policy import Policy, load_policy, save_policy
from pipenav.robots.robot import load_robot
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.registry import task_of

SAVE_EVERY_S = 10.0
"""Time between two savings, which is the most that a killed training loses [s]."""

CHECK_SEED = 1_000_003
"""Number added to the training's seed for checks: not the seed of an evaluation that anybody is likely to type."""


@dataclass
class _Counts:
    """Episodes and steps since the last report."""

    episodes: int = 0
    successes: int = 0
    episode_steps: int = 0
    min_range: float = 0.0
    reward: float = 0.0
    samples: int = 0


class _CheckStopped(Exception):
    """A check was given up, because the training was asked to stop."""


class _WatchedController(PolicyController):
    """A policy that has something done at every control step."""

    def __init__(self, policy: Policy, at_step: Callable[[], None]) -> None:
        super().__init__(policy)
        self._at_step = at_step

    def act(self, observation: Floats) -> Floats:
        self._at_step()
        return super().act(observation)


class TrainingCallback(BaseCallback):  # type: ignore[misc]  # Stable-Baselines3 is imported untyped
    """Sets the noise, counts, checks, saves; stops on request and on non-finite values.

    Args:
        stage: stage that is trained.
        folder: folder of the training.
        checkpoint: progress at the beginning.
        report: called after each update.
        should_stop: asked at every step.
    """

    def __init__(
        self,
        stage: TrainingStage,
        folder: TrainingFolder,
        checkpoint: Checkpoint,
        report: Callable[[TrainingProgress], None] | None,
        should_stop: Callable[[], bool],
    ) -> None:
        super().__init__()
        self._stage, self._folder = stage, folder
        self._report, self._should_stop = report, should_stop
        self.best_success = checkpoint.best_success if checkpoint.stage >= stage.checked_since else NO_CHECK
        self.stopped = False
        self._check_success, self._check_steps, self._check_seconds = math.nan, 0, math.nan
        self._earlier_seconds = checkpoint.seconds
        self._started = self._last_time = time.monotonic()
        self._last_steps = checkpoint.steps
        self._next_check = checkpoint.steps + stage.config.check.every
        self._counts = _Counts()
        self._checks = read_checks(folder.checks)

    @property
    def seconds(self) -> float:
        return self._earlier_seconds + time.monotonic() - self._started

    def _on_rollout_start(self) -> None:
        self.model.policy.log_std.data.fill_(math.log(self._noise()))
        if self.n_calls:
            self._after_update()

    def _noise(self) -> float:
        return noise_at(self._stage.config.learner, self._stage.schedule, self.num_timesteps)

    def _on_step(self) -> bool:
        env, counts = self.training_env, self._counts
        rewards, observations = self.locals["rewards"], self.locals["new_obs"]
        if not (np.isfinite(observations).all() and np.isfinite(rewards).all()):
            self._diverge()
        counts.min_range += float(env.min_range.sum())
        counts.reward += float(rewards.sum())
        counts.samples += len(rewards)
        ended = self.locals["ended"]
        counts.episodes += len(ended.robots)
        counts.successes += int(np.count_nonzero(ended.outcome == Outcome.REACHED))
        counts.episode_steps += int(ended.steps.sum())
        self.stopped = self.stopped or self._should_stop()
        return not self.stopped

    def _after_update(self) -> None:
        """Check, report and save after an update, when the policy is whole."""
        self.require_sound()
        self._report_progress()
        if self.num_timesteps >= self._next_check:
            self._next_check += self._stage.config.check.every
            self.save()
            self.check()
            self.save()
            write_training_plot(self._folder.plot, self._folder.progress)
        else:
            self._save_when_due()

    def _on_training_start(self) -> None:
        self.save()  # from here on there is a training to resume, whatever happens
        if self._stage.config.recordings.folders and not self.num_timesteps:
            self.check()  # what the supervised start has taught
            self.save()

    def finish(self) -> None:
        """Leave the folder whole. A training that was asked to stop is not checked: that may take long.

        Nor is the end of a stage that another one follows: its checks go on.
        """
        self.require_sound()
        self._report_progress()
        self.save()
        if self.stopped or self._stage.last:
            self._conclude()

    def _conclude(self) -> None:
        if not self.stopped:
            self.check()
        if not self._folder.best.exists():
            save_policy(self._folder.best, self.model, self._header())
        self.save()
        write_training_plot(self._folder.plot, self._folder.progress)
        write_training_page(self._folder.path)

    def _report_progress(self) -> None:
        now, steps, counts = time.monotonic(), self.num_timesteps, self._counts
        if steps == self._last_steps:
            return
        progress = TrainingProgress(
            stage=self._stage.label,
            steps=steps,
            steps_per_s=(steps - self._last_steps) / max(now - self._last_time, 1e-9),
            success=counts.successes / counts.episodes if counts.episodes else math.nan,
            min_range=counts.min_range / max(counts.samples, 1),
            check_success=self._check_success,
            check_steps=self._check_steps,
            check_seconds=self._check_seconds,
        )
        self._add_row(progress)
        self._last_time, self._last_steps = now, steps
        self._counts = _Counts()
        if self._report is not None:
            self._report(progress)

    def _add_row(self, progress: TrainingProgress) -> None:
        """Add the row of progress.csv that belongs to a report."""
        counts, losses = self._counts, self.model.losses
        self._folder.add_progress(
            {
                "stage": self._stage.number,
                "steps": progress.steps,
                "seconds": f"{self.seconds:.2f}",
                "steps_per_s": f"{progress.steps_per_s:.0f}",
                "success": f"{progress.success:.4f}" if counts.episodes else "",
                "min_range_m": f"{progress.min_range:.5f}",
                "reward": f"{counts.reward / max(counts.samples, 1):.4f}",
                "episode_steps": f"{counts.episode_steps / counts.episodes:.2f}" if counts.episodes else "",
                "std": f"{float(self.model.policy.log_std.exp()[0]):.3f}",
                "policy_loss": "" if losses is None else f"{losses.policy_gradient_loss:.5g}",
                "value_loss": "" if losses is None else f"{losses.value_loss:.5g}",
                "check_success": "" if math.isnan(self._check_success) else f"{self._check_success:.4f}",
            }
        )

    def save(self) -> None:
        """Write last.zip, the checkpoint that `--resume` needs, and progress.csv."""
        folder, model = self._folder, self.model
        save_policy(folder.last, model, self._header())
        save_checkpoint(
            folder.checkpoint,
            model,
            Checkpoint(
                steps=model.num_timesteps,
                seconds=self.seconds,
                best_success=self.best_success,
                stage=self._stage.number,
            ),
        )
        folder.write_progress()
        self._last_saved = time.monotonic()

    def check(self) -> None:
        """Measure the policy in last.zip, without its noise, and keep it as best.zip if none was better."""
        steps, seconds = self.num_timesteps, self.seconds
        try:
            self._check_success = self._measure(steps, seconds)
        except _CheckStopped:
            self.stopped = True
            return
        self._check_steps, self._check_seconds = steps, seconds
        if self._check_success >= self.best_success:  # of equals the later one, which explored less
            self.best_success = self._check_success
            save_policy(self._folder.best, self.model, self._header())

    def _measure(self, steps: int, seconds: float) -> float:
        """Success of the noise-free policy on episodes spread evenly over the stage's pipes, kept pipe by pipe."""
        config, check = self._stage.checked, self._stage.checked.check
        pipes = task_of(config.task).parse_training_pipes(config.pipes)
        chosen = [pipes[i] for i in np.linspace(0, len(pipes) - 1, min(check.episodes, len(pipes))).astype(int)]
        each = math.ceil(check.episodes / len(chosen))
        controller = _WatchedController(load_policy(self._folder.last), self._during_check)
        simulator = SimulatorSettings(config.backend, config.options)
        results = run_task(controller, chosen, each, config.seed + CHECK_SEED, simulator, config.randomise)
        self._checks = self._checks.with_check(
            chosen, results.outcome, steps=steps, seconds=round(seconds, 2), stage=self._stage.number
        )
        write_checks(self._folder.checks, self._checks)
        return float((results.outcome == Outcome.REACHED).mean())

    def _during_check(self) -> None:
        """Save on time and stop on request, at every control step of a check."""
        if self._should_stop():
            raise _CheckStopped
        self._save_when_due()

    def _save_when_due(self) -> None:
        if time.monotonic() - self._last_saved > SAVE_EVERY_S:
            self.save()

    def _header(self) -> PolicyHeader:
        stage, config = self._stage, self._stage.config
        training: dict[str, str | int | float | bool] = {
            "steps": self.num_timesteps,
            "seconds": round(self.seconds, 1),
            "seed": config.seed,
            "description": config.description,
        }
        if stage.record:
            training["stages"] = stage.record
        return header_for(load_robot(config.robot), config.task, stage.trained_pipes, training)

    def require_sound(self, rollout: bool = False, overflow: bool = False) -> None:
        """Make sure that the policy is finite.

        Args:
            rollout: look at what it answers to every observation of the last rollout, not only to the last ones.
            overflow: whether an update has ended at a number that is too large already.

        Raises:
            TrainingDiverged: it is not; the last control step has been saved.
        """
        seen = [np.asarray(self.model._last_obs)]
        if rollout:
            seen.append(self.model.rollout_buffer.observations.reshape(-1, seen[0].shape[-1]))
        if overflow or not is_sound(self.model.policy, np.concatenate(seen)):
            self._diverge()

    def _diverge(self) -> None:
        """Save the last control step and stop."""
        before, actions = np.asarray(self.model._last_obs), np.asarray(self.locals["actions"])
        seen = Seen(before, actions, self.locals["new_obs"], self.locals["rewards"])
        write_cause(self._folder, self.num_timesteps, seen, self.training_env.pipes)
        raise TrainingDiverged(self.num_timesteps, self._folder)
