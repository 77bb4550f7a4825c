"""The reach task as a Gymnasium environment and a vector environment: thin adapters over its batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from pipenav.drawing.scene import Scene, scene_pixels
from pipenav.envs.episodes import CornerSettings, SeededEpisodes
from pipenav.envs.spaces import Float32s, action_space, observation_space, one_info, step_info
from pipenav.errors import PipenavError
from pipenav.robots import frames
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes


class CornerEnv(gymnasium.Env[Float32s, Float32s]):
    """Bring the arm's tip to a target around the corner of a pipe.

    Observation, float32: each value is divided by a fixed physical number (`pipenav.tasks.reach.observation.layout`),
    and right turns are mirrored into left turns. For the 4 joints and 10 beams of the thesis's arm:

    | task.observation | values, in order | size |
    | --- | --- | --- |
    | `basic` (eq 3.1) | q 4, qd 4, tip xy 2, target xy 2, laser 10 | 22 |
    | `history` (eq 3.2) | q 4, qd 4, laser 10, these in the step before 18, last action 4, tip 2, target 2 | 44 |
    | `relative` | q 4, qd 4, laser 10, target seen from the tip 2, the same, scaled up near the tip 2 | 22 |
    | `relative-history` | `relative` 22, laser of the step before 10, last action 4 | 36 |

    | unit before scaling | values |
    | --- | --- |
    | rad, m | q: the slide [m], then the hinges [rad], positive to the left; qd the same per second |
    | m | tip, target: in the robot's frame (rear end at rest, x along the first leg) |
    | m | laser: from right to left |

    Action, float32 in [-1, 1], one value per joint in joint order:

    | task.control | meaning of 1 |
    | --- | --- |
    | `torque` (eq 3.3) | a duty of 1: the actuator's largest effort, forwards or to the left [N, N m] |
    | `position` (eq 3.4, 3.5) | a set-point alpha x 1 rad, or alpha x slide_unit, from the measured position |

    An episode terminates when the tip reaches the target, when a joint reaches its limit, or when the robot sinks into
    the wall; it is truncated after `task.max_steps`. `info` after each step holds `outcome`, `is_success`,
    `min_range_m` (the smallest laser reading), and the step's peaks `contact_force_n` and `penetration_m`.

    Args:
        robot: a shipped robot or the path of a `robot.toml`.
        pipes: texts that name pipe sets or pipes; each episode draws one text, then one of its pipes.
        backend: name of a simulator backend.
        task: settings of the task; None for the defaults.
        options: options of the backend.
        render_mode: None, or `rgb_array` for a top view.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012

    def __init__(
        self,
        robot: str = "basic",
        pipes: Sequence[str] = ("thesis-train",),
        backend: str = "mujoco",
        task: ReachConfig | Mapping[str, Any] | None = None,
        options: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
    ) -> None:
        self.render_mode = render_mode
        self._episodes = SeededEpisodes(1, CornerSettings(robot, pipes, backend, task, options))
        self.batch = self._episodes.batch
        self.observation_space = observation_space(self.batch)
        self.action_space = action_space(self.batch)

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002
    ) -> tuple[Float32s, dict[str, Any]]:
        super().reset(seed=seed)
        self._episodes.generators = [self.np_random]
        return self.batch.reset()[0].astype(np.float32), {}

    def step(self, action: Float32s) -> tuple[Float32s, float, bool, bool, dict[str, Any]]:
        result = self.batch.step(np.asarray(action, float)[None])
        outcome = Outcome(result.outcome[0])
        truncated = outcome is Outcome.TIMEOUT
        terminated = outcome is not Outcome.RUNNING and not truncated
        observation = result.observation[0].astype(np.float32)
        return observation, float(result.reward[0]), terminated, truncated, one_info(step_info(result), 0)

    def render(self) -> NDArray[np.uint8] | None:
        return None if self.render_mode is None else top_view(self.batch, self._episodes.episodes[0])

    def close(self) -> None:
        self.batch.close()


class CornerVectorEnv(VectorEnv[Float32s, Float32s, NDArray[Any]]):
    """n episodes of the reach task in one batch. An ended episode starts anew in the next step.

    Robot i of `reset(seed=s)` lives through the episodes of a `CornerEnv` with seed s + i. `info` holds the keys of
    `CornerEnv` as arrays, with `_<key>` false for the robots that started anew, whose actions were ignored.

    Args:
        num_envs: number of robots.
        robot, pipes, backend, task, options: as for `CornerEnv`.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        robot: str = "basic",
        pipes: Sequence[str] = ("thesis-train",),
        backend: str = "mujoco",
        task: ReachConfig | Mapping[str, Any] | None = None,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        self.num_envs = num_envs
        self._episodes = SeededEpisodes(num_envs, CornerSettings(robot, pipes, backend, task, options))
        self.batch = self._episodes.batch
        self.single_observation_space = observation_space(self.batch)
        self.single_action_space = action_space(self.batch)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._ended = np.zeros(num_envs, bool)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002
    ) -> tuple[Float32s, dict[str, Any]]:
        self._seed(seed)
        self._ended = np.zeros(self.num_envs, bool)
        return self.batch.reset().astype(np.float32), {}

    def _seed(self, seed: int | Sequence[int | None] | None) -> None:
        """Seed the robots: by an int, robot i with seed + i; a robot without a seed keeps its generator."""
        seeds = [seed] * self.num_envs if seed is None else seed
        seeds = [seeds + i for i in range(self.num_envs)] if isinstance(seeds, int) else list(seeds)
        if len(seeds) != self.num_envs:
            raise PipenavError(
                f"{len(seeds)} seeds given for {self.num_envs} robots: give one for each, or one number."
            )
        old = self._episodes.generators or [seeding.np_random()[0] for _ in seeds]
        self._episodes.generators = [
            generator if new is None else seeding.np_random(new)[0] for new, generator in zip(seeds, old, strict=True)
        ]

    def step(self, actions: Float32s) -> tuple[Float32s, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        anew, result = self._ended, self.batch.step(np.asarray(actions, float))
        outcome = np.where(anew, Outcome.RUNNING, result.outcome)
        reward = np.where(anew, 0.0, result.reward)
        truncated = outcome == Outcome.TIMEOUT
        self._ended = outcome != Outcome.RUNNING
        observation = self.batch.reset(np.flatnonzero(anew)) if anew.any() else result.observation
        info = step_info(result)
        valid = {f"_{key}": ~anew for key in info}
        return observation.astype(np.float32), reward, self._ended & ~truncated, truncated, info | valid

    def close_extras(self, **kwargs: Any) -> None:  # noqa: ARG002
        self.batch.close()


def top_view(batch: ReachBatch, episodes: ReachEpisodes, pixels: int = 480) -> NDArray[np.uint8]:
    """Picture of the first robot from above, (pixels, pixels, 3): walls, links, beams and target.

    Args:
        batch: the robots.
        episodes: episode of the first robot, k = 1.
        pixels: width and height of the picture.
    """
    turn_sign, base = float(episodes.turn_sign[0]), float(episodes.base[0])
    ranges = batch.snapshot.ranges[0, :: int(turn_sign)]  # the canonical frame mirrors right turns
    target = frames.robot_to_pipe(frames.canonical_to_robot(episodes.target[0], turn_sign), base)
    return scene_pixels(Scene(episodes.pipes[0], batch.robot, base, batch.q[0], ranges, target), pixels)
