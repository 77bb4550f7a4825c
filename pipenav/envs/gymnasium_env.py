"""Tasks as Gymnasium environments of one robot: thin adapters over a batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, cast

import gymnasium
import numpy as np
from numpy.typing import NDArray

from pipenav.envs.env_tasks import CORNER, TRAVERSE, EnvTask
from pipenav.envs.episodes import EnvSettings, SeededEpisodes, TaskSettings
from pipenav.envs.spaces import Float32s, action_space, bounded_space, checked_action, one_info, step_info, within
from pipenav.envs.threads import bound_torch_threads
from pipenav.tasks.outcome import Outcome


class TaskEnv(gymnasium.Env[Float32s, Float32s]):
    """Environment of one robot; the subclasses say which task it is and which arguments it takes."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012
    env_task: ClassVar[EnvTask]

    def __init__(self, settings: EnvSettings, render_mode: str | None) -> None:
        self.render_mode = render_mode
        self._episodes = SeededEpisodes(self.env_task, 1, settings)
        self.batch = self._episodes.batch
        self._space = bounded_space(self._episodes.layout)
        self.observation_space = cast("gymnasium.spaces.Space[Float32s]", self._space)
        self._action_space = action_space(self.batch)
        self.action_space = self._action_space

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002
    ) -> tuple[Float32s, dict[str, Any]]:
        super().reset(seed=seed)
        bound_torch_threads()
        self._episodes.generators = [self.np_random]
        return within(self._space, self.batch.reset()[0]), {}

    def step(self, action: Float32s) -> tuple[Float32s, float, bool, bool, dict[str, Any]]:
        result = self.batch.step(checked_action(self._action_space, action)[None])
        outcome = Outcome(result.outcome[0])
        truncated = outcome is Outcome.TIMEOUT
        terminated = outcome is not Outcome.RUNNING and not truncated
        observation = within(self._space, result.observation[0])
        return observation, float(result.reward[0]), terminated, truncated, one_info(step_info(result), 0)

    def render(self) -> NDArray[np.uint8] | None:
        return None if self.render_mode is None else self._episodes.picture(0)

    def close(self) -> None:
        self.batch.close()


class CornerEnv(TaskEnv):
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

    The space bounds each scaled value generously: positions of joints by 2, speeds by 1000 (an impact turns a joint
    faster than its motor can), places by 100 (50 m), all others by 1. A value beyond, as of a simulation that fails, is
    cut.

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

    env_task = CORNER

    def __init__(
        self,
        robot: str = "basic",
        pipes: Sequence[str] = ("thesis-train",),
        backend: str = "mujoco",
        task: TaskSettings = None,
        options: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(EnvSettings(robot, pipes, backend, task, options), render_mode)


class TraverseEnv(TaskEnv):
    """Take the whole robot on its wheels around the corners of a pipe.

    Observation, float32: each value is divided by a fixed physical number
    (`pipenav.tasks.traverse.observation.layout`), and right turns are mirrored into left turns. For a robot with j
    bending joints, w wheels and b beams:

    | values, in order | unit before scaling | size | bound |
    | --- | --- | --- | --- |
    | q: joint positions | rad | j | 2 |
    | qd: joint speeds | rad/s | j | 1000 |
    | wheel speeds | rad/s | w | 1000 |
    | loads: duties of the motors | 1 | j + w | 1 |
    | laser, from right to left | m | b | 1 |
    | last action | 1 | j + w | 1 |
    | turns of the corners before and after, +1 for the same turn, 0 for none | 1 | 2 | 1 |
    | straight on, with `task.exit_told` only: 1 where the route goes straight on | 1 | 1 | 1 |
    | down, with `task.inclination_deg` only: share of the weight forwards and to the left | 1 | 2 | 1 |

    Action, float32 in [-1, 1]: for every bending joint the change of its set-point, in `task.alpha` [rad], then for
    every wheel its speed forwards, as a share of its no-load speed.

    An episode terminates when the tail is through the last corner, when the robot is stuck or slides back, or when it
    sinks into the wall; it is truncated after `task.max_steps` for each corner. `info` holds the keys of `CornerEnv`.

    Where any pipe leaves the plane, all episodes are in space and have no pictures. There the robot drives itself
    between corners, and actions are ignored; `batch.driven` says whether the last one counted.

    Args:
        robot: a shipped whole robot or the path of a `robot.toml`.
        pipes: texts that name pipe sets, routes or pipes; each episode draws one text, then one of its pipes.
        backend: name of a simulator backend.
        task: settings of the task; None for the defaults.
        options: options of the backend.
        render_mode: None, or `rgb_array` for a top view.
    """

    env_task = TRAVERSE

    def __init__(
        self,
        robot: str = "pirate",
        pipes: Sequence[str] = ("working-range-train",),
        backend: str = "mujoco",
        task: TaskSettings = None,
        options: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(EnvSettings(robot, pipes, backend, task, options), render_mode)
