"""The reach task as a Gymnasium environment and a vector environment: thin adapters over its batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray
from pydantic import ValidationError

from pipenav.arrays import Ints
from pipenav.drawing.scene import Scene, scene_pixels
from pipenav.errors import ConfigError, PipenavError
from pipenav.pipes.corner_sets import parse_corners
from pipenav.robots import frames
from pipenav.robots.robot import load_robot
from pipenav.tasks.batch import StepResult, TaskBatch
from pipenav.tasks.outcome import Outcome
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig, RewardConfig
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.reach.task import ReachTask
from pipenav.tasks.sampling import random_episodes

Float32s = NDArray[np.float32]

OUTCOME_LABELS = np.array([outcome.label for outcome in Outcome])


class SeededEpisodes:
    """n robots of one batch, each drawing its episodes from a generator of its own.

    So robot i of many lives through the same episodes as a single one with the same seed.

    Attributes:
        batch: the robots.
        generators: one for each robot; whoever resets the batch sets them first.
        episodes: each robot's running episode, as `ReachEpisodes` of k = 1.
    """

    def __init__(
        self,
        n: int,
        robot: str,
        pipes: Sequence[str],
        backend: str,
        task: ReachConfig | Mapping[str, Any] | None,
        options: Mapping[str, Any] | None,
    ) -> None:
        from pipenav.backends.simulators import open_simulator

        self.generators: list[np.random.Generator] = []
        self.episodes: dict[int, ReachEpisodes] = {}
        self._robot, self._config = load_robot(robot), _task_config(task)
        self._sets = [parse_corners([text]) for text in ([pipes] if isinstance(pipes, str) else pipes)]
        if not self._sets:
            raise PipenavError("no pipes given: name a pipe set, a TOML file, or a pipe such as d=90,angle=60.")
        slots = max(len(pipe.segments) for one in self._sets for pipe in one)
        opened = open_simulator(backend, self._robot, n, dict(options or {}), slots)
        self.batch = ReachBatch(self._robot, self._config, opened, n, self._draw)

    def _draw(self, indices: Ints) -> ReachEpisodes:
        for i in indices:
            draw = random_episodes(ReachTask(self._config), self._robot, self._sets, self.generators[i])
            self.episodes[int(i)] = draw(np.array([i]))
        pipes, *arrays = zip(*(self.episodes[int(i)] for i in indices), strict=True)
        return ReachEpisodes(tuple(one for (one,) in pipes), *map(np.concatenate, arrays))


def _task_config(task: ReachConfig | Mapping[str, Any] | None) -> ReachConfig:
    if isinstance(task, ReachConfig):
        return task
    try:
        return ReachConfig.model_validate(dict(task or {}))
    except ValidationError as error:
        known = [*ReachConfig.model_fields, *(f"reward.{key}" for key in RewardConfig.model_fields)]
        raise ConfigError.from_validation("task", error, known) from error


def observation_space(batch: TaskBatch) -> spaces.Space[Float32s]:
    """Of one robot. Unbounded: no sensor limits what an impact does to a joint's speed."""
    return cast("spaces.Space[Float32s]", spaces.Box(-np.inf, np.inf, (batch.observation_size,), np.float32))


def action_space(batch: TaskBatch) -> spaces.Space[Float32s]:
    """Of one robot: every actuator's share in [-1, 1]."""
    return cast("spaces.Space[Float32s]", spaces.Box(-1.0, 1.0, (batch.action_size,), np.float32))


def step_info(result: StepResult, indices: Ints | slice = slice(None)) -> dict[str, NDArray[Any]]:
    """What `info` says after a step, one array for each key, (k,) for k robots; of all by default."""
    outcome = result.outcome[indices]
    return {
        "outcome": OUTCOME_LABELS[outcome],
        "is_success": outcome == Outcome.REACHED.value,
        "min_range_m": result.min_range[indices],
        "contact_force_n": result.truth.contact_force[indices],
        "penetration_m": result.truth.penetration[indices],
    }


def one_info(info: Mapping[str, NDArray[Any]], i: int) -> dict[str, Any]:
    """Robot i's part of `step_info`, in Python's own types."""
    return {key: column[i].item() for key, column in info.items()}


class CornerEnv(gymnasium.Env[Float32s, Float32s]):
    """Bring the arm's tip to a target around the corner of a pipe.

    Float32s, float32, each value divided by a fixed physical number (`pipenav.tasks.reach.observation.layout`); right
    turns are shown mirrored, as left turns. For the 4 joints and 10 beams of the thesis's arm:

    | task.observation | values, in order | size |
    | --- | --- | --- |
    | `basic` (eq 3.1) | q 4, qd 4, tip xy 2, target xy 2, laser 10 | 22 |
    | `history` (eq 3.2) | q 4, qd 4, laser 10, the same of the step before 18, last action 4, tip 2, target 2 | 44 |
    | `relative` | q 4, qd 4, laser 10, target seen from the tip 2, the same with its last centimetres wide 2 | 22 |
    | `relative-history` | `relative` 22, laser of the step before 10, last action 4 | 36 |

    | unit before scaling | values |
    | --- | --- |
    | rad, m | q: the slide [m], then the hinges [rad], positive to the left; qd the same per second |
    | m | tip, target: in the robot's frame (rear end at rest, x along the first leg) |
    | m | laser: from right to left |

    Action, float32 in [-1, 1], one value per joint in joint order:

    | task.control | 1 means |
    | --- | --- |
    | `torque` (eq 3.3) | the actuator's largest effort forwards or to the left [N, N m] |
    | `position` (eq 3.4, 3.5) | a set-point alpha x 1 rad, or alpha x slide_unit, from the measured position |

    An episode terminates when the tip reaches the target, a joint its limit, or the robot sinks into the wall; it is
    truncated after `task.max_steps`. `info` after each step: `outcome`, `is_success`, `min_range_m` (the smallest laser
    reading), `contact_force_n` and `penetration_m` (the step's peaks).

    Args:
        robot: a shipped robot or the path of a `robot.toml`.
        pipes: texts as `pipenav.pipes.parse_corners` takes them; each episode draws one text, then a pipe of it.
        backend: name of a simulator backend.
        task: the task's configuration; None for the defaults.
        options: the backend's own options.
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
        self._corners = SeededEpisodes(1, robot, pipes, backend, task, options)
        self.batch = self._corners.batch
        self.observation_space = observation_space(self.batch)
        self.action_space = action_space(self.batch)

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002
    ) -> tuple[Float32s, dict[str, Any]]:
        super().reset(seed=seed)
        self._corners.generators = [self.np_random]
        return self.batch.reset()[0].astype(np.float32), {}

    def step(self, action: Float32s) -> tuple[Float32s, float, bool, bool, dict[str, Any]]:
        result = self.batch.step(np.asarray(action, float)[None])
        outcome = Outcome(result.outcome[0])
        truncated = outcome is Outcome.TIMEOUT
        terminated = outcome is not Outcome.RUNNING and not truncated
        observation = result.observation[0].astype(np.float32)
        return observation, float(result.reward[0]), terminated, truncated, one_info(step_info(result), 0)

    def render(self) -> NDArray[np.uint8] | None:
        return None if self.render_mode is None else top_view(self.batch, self._corners.episodes[0])

    def close(self) -> None:
        self.batch.close()


class CornerVectorEnv(VectorEnv[Float32s, Float32s, NDArray[Any]]):
    """n corner episodes in one batch. An ended one starts anew in the next step, whose action it ignores.

    Robot i of `reset(seed=s)` lives through the episodes of a `CornerEnv` with seed s + i. `info` holds the keys of
    `CornerEnv` as arrays, with `_<key>` false for the robots that started anew. Arguments as for `CornerEnv`.
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
        self._corners = SeededEpisodes(num_envs, robot, pipes, backend, task, options)
        self.batch = self._corners.batch
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
        """An int seeds robot i with seed + i; a robot without a seed goes on with the generator it has."""
        seeds = [seed] * self.num_envs if seed is None else seed
        seeds = [seeds + i for i in range(self.num_envs)] if isinstance(seeds, int) else list(seeds)
        if len(seeds) != self.num_envs:
            raise PipenavError(
                f"{len(seeds)} seeds given for {self.num_envs} robots: give one for each, or one number."
            )
        old = self._corners.generators or [seeding.np_random()[0] for _ in seeds]
        self._corners.generators = [
            generator if one is None else seeding.np_random(one)[0] for one, generator in zip(seeds, old, strict=True)
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
    """A picture of the first robot from above, (pixels, pixels, 3): walls, links, beams and target.

    Args:
        batch: the robots.
        episodes: the first robot's episode, k = 1.
        pixels: width and height.
    """
    turn_sign, base = float(episodes.turn_sign[0]), float(episodes.base[0])
    ranges = batch.snapshot.ranges[0, :: int(turn_sign)]  # those of the canonical frame are mirrored for right turns
    target = frames.robot_to_pipe(frames.canonical_to_robot(episodes.target[0], turn_sign), base)
    return scene_pixels(Scene(episodes.pipes[0], batch.robot, base, batch.q[0], ranges, target), pixels)
