"""The learner: Stable-Baselines3's PPO, half of whose robots move while it attends to the other half.

The shares of the robots take turns (`pipenav.envs.shares`). They stand still during updates: robots that moved on with
actions of the policy before the update, an eighth of a rollout, learned measurably slower.
"""

from __future__ import annotations

import inspect
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.utils import explained_variance

from pipenav.envs.sb3_env import TaskVecEnv
from pipenav.envs.shares import Ended, RobotShare, joined
from pipenav.learning.rollouts import Decision, DrivenRollouts
from pipenav.learning.update import FusedUpdate, StepLosses, log_probabilities


class _CutOff(NamedTuple):
    """Episodes that the time limit cut off in one step of a rollout: row, robots (k,), last observations (k, size)."""

    row: int
    robots: np.ndarray
    observations: np.ndarray


class _Adam(torch.optim.Adam):
    """PyTorch's Adam, whose book-keeping does not load PyTorch's compiler only to tell it to keep away: 1.5 s."""

    add_param_group = inspect.unwrap(torch.optim.Adam.add_param_group)
    state_dict = inspect.unwrap(torch.optim.Adam.state_dict)
    load_state_dict = inspect.unwrap(torch.optim.Adam.load_state_dict)


class Learner(PPO):  # type: ignore[misc]  # Stable-Baselines3 is imported untyped
    """PPO on a `TaskVecEnv`. It writes and reads the files of Stable-Baselines3's own PPO."""

    rollout_buffer: DrivenRollouts

    _last_obs: np.ndarray
    _last_episode_starts: np.ndarray

    def _setup_model(self) -> None:
        # Files of this learner name no class of ours, so that Stable-Baselines3 alone can read them.
        self.policy_kwargs |= {"optimizer_class": _Adam}
        super()._setup_model()
        del self.policy_kwargs["optimizer_class"]
        self.rollout_buffer = DrivenRollouts(self)
        self._decisions: dict[int, Decision] = {}

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "_decisions", "_update"]

    @cached_property
    def _update(self) -> FusedUpdate:
        """Networks and optimiser; made when it is first needed, after others have set the policy up."""
        return FusedUpdate(self)

    def collect_rollouts(
        self, env: TaskVecEnv, callback: BaseCallback, rollout_buffer: DrivenRollouts, n_rollout_steps: int
    ) -> bool:
        """Fill the buffer with control steps of all robots, as Stable-Baselines3 does, one share after the other."""
        rollout_buffer.reset()
        callback.on_rollout_start()
        for share in env.shares:
            if not share.moving:  # an earlier call may have been stopped in mid-rollout
                self._act(share, self._last_obs[share.rows])
        cut_offs: list[_CutOff] = []
        for row in range(n_rollout_steps):
            rollout_buffer.episode_starts[row] = self._last_episode_starts
            observation, done = np.empty_like(self._last_obs), np.empty(env.num_envs, bool)
            endings = []
            for share in env.shares:
                step = env.receive(share)
                rollout_buffer.put(row, share, self._decisions[share.rows.start], step)
                observation[share.rows], done[share.rows] = step.observation, step.done
                endings.append(step.ended)
                if row + 1 < n_rollout_steps:
                    self._act(share, step.observation)
            ended = joined(env.shares, endings)
            self.num_timesteps += env.num_envs
            seen = {"actions": rollout_buffer.actions[row], "rewards": rollout_buffer.rewards[row].copy()}
            callback.update_locals(seen | {"new_obs": observation, "dones": done, "ended": ended})
            if not callback.on_step():
                return False
            self._count_episodes(ended)
            late = np.flatnonzero(ended.cut_off)
            cut_offs.append(_CutOff(row, ended.robots[late], ended.observation[late]))
            self._last_obs, self._last_episode_starts = observation, done
        self._estimate(cut_offs)
        callback.on_rollout_end()
        return True

    def _act(self, share: RobotShare, observation: np.ndarray) -> None:
        """Draw actions for a share's robots and let them move, unless their observations are not finite.

        Raises:
            ValueError: the policy's answers are not finite.
        """
        with torch.no_grad():
            means = self._update.actor(torch.from_numpy(observation)).numpy()
            log_std, drawn = self.policy.log_std.numpy(), torch.randn(means.shape).numpy()
        actions, log_probs = means + np.exp(log_std) * drawn, log_probabilities(drawn, log_std)
        if not np.isfinite(actions).all():
            if np.isfinite(observation).all():
                raise ValueError("the policy's actions are not finite")
            return  # whoever counts the steps sees the observations
        self._decisions[share.rows.start] = Decision(observation, actions, log_probs)
        share.send(np.clip(actions, self.action_space.low, self.action_space.high))

    def _count_episodes(self, ended: Ended) -> None:
        """Take episodes into Stable-Baselines3's means over the last hundred."""
        for reward, steps in zip(ended.reward.tolist(), ended.steps.tolist(), strict=True):
            self.ep_info_buffer.append({"r": reward, "l": steps})

    def _estimate(self, cut_offs: list[_CutOff]) -> None:
        """Estimate values, returns and advantages of the whole rollout, all with the critic as it is now.

        An episode that the time limit cut off would have gone on from its last observation: its value is added to the
        last reward.
        """
        buffer, robots = self.rollout_buffer, self.n_envs
        late = np.concatenate([cut.observations for cut in cut_offs])
        seen = np.concatenate([buffer.observations.reshape(-1, late.shape[1]), self._last_obs, late])
        with torch.no_grad():
            values = self._update.critic(torch.from_numpy(seen))[:, 0]
        inside, last, beyond = torch.split(values, [buffer.values.size, robots, len(late)])
        buffer.values[:] = inside.numpy().reshape(buffer.values.shape)
        rows = np.concatenate([np.full(len(cut.robots), cut.row) for cut in cut_offs])
        buffer.rewards[rows, np.concatenate([cut.robots for cut in cut_offs])] += self.gamma * beyond.numpy()
        buffer.compute_returns_and_advantage(last, self._last_episode_starts)

    def train(self) -> None:
        """Update the policy from the rollout."""
        self._update_learning_rate(self.policy.optimizer)
        clip = self.clip_range(self._current_progress_remaining)
        minibatches = self.rollout_buffer.minibatches(self.batch_size, self.n_epochs)
        losses = self._update.run(minibatches, clip)
        self._n_updates += self.n_epochs
        self._log(losses, clip)

    def _log(self, losses: list[StepLosses], clip: float) -> None:
        """Write the losses under the names of Stable-Baselines3."""
        record: Any = self.logger.record
        for name, column in zip(StepLosses._fields, zip(*losses, strict=True), strict=True):
            record(f"train/{name}", float(np.mean(column)))
        buffer = self.rollout_buffer
        record("train/explained_variance", explained_variance(buffer.values.flatten(), buffer.returns.flatten()))
        record("train/std", self.policy.log_std.exp().mean().item())
        record("train/n_updates", self._n_updates, exclude="tensorboard")
        record("train/clip_range", clip)
