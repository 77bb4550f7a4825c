"""The tasks that environments are made of, and the picture of each from above."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from pipenav.drawing.scene import Scene
from pipenav.errors import ConfigError, PipenavError
from pipenav.robots import frames
from pipenav.robots.robot import RobotSpec
from pipenav.tasks.reach.batch import ReachBatch
from pipenav.tasks.reach.config import ReachConfig
from pipenav.tasks.reach.episode import ReachEpisodes
from pipenav.tasks.traverse.batch import TraverseBatch
from pipenav.tasks.traverse.config import TraverseConfig
from pipenav.tasks.traverse.episode import TraverseEpisodes

CORNER_ID, TRAVERSE_ID = "pipenav/Corner-v0", "pipenav/Traverse-v0"
"""Names by which Gymnasium makes the environments."""


class EnvTask(NamedTuple):
    """A task as the environments need it.

    Attributes:
        name: value of the key `kind` in the task's settings.
        config: class of the task's settings.
        scene: function that gives the picture of robot i, from the batch, the robot's episode of k = 1, and i.
        around: distance from the tip to the picture's edges [m].
    """

    name: str
    config: type[ReachConfig] | type[TraverseConfig]
    scene: Callable[[Any, Any, int], Scene]
    around: float

    def settings(self, given: ReachConfig | TraverseConfig | Mapping[str, Any] | None) -> ReachConfig | TraverseConfig:
        """Settings of the task, from a table of some of them.

        Raises:
            ConfigError: an unknown key, or a value that does not fit.
        """
        if isinstance(given, self.config):
            return given
        try:
            table = {} if given is None else dict(given)
            return self.config.model_validate({"kind": self.name, **table})
        except ValidationError as error:
            reward = self.config.model_validate({"kind": self.name}).reward
            known = [*self.config.model_fields, *(f"reward.{key}" for key in type(reward).model_fields)]
            raise ConfigError.from_validation("task", error, known) from error

    def check_robot(self, robot: RobotSpec) -> None:
        """Refuse a robot of the other task.

        Raises:
            PipenavError: the robot is for the other environment.
        """
        if robot.free and self.name == "reach":
            raise PipenavError(f"robot {robot.name!r} stands free, and {CORNER_ID} moves an arm: make {TRAVERSE_ID}.")
        if not robot.free and self.name == "traverse":
            raise PipenavError(
                f"robot {robot.name!r} hangs on a mount, and {TRAVERSE_ID} moves a whole robot: make {CORNER_ID}."
            )


def _corner_scene(batch: ReachBatch, episodes: ReachEpisodes, i: int) -> Scene:
    turn_sign, base = float(episodes.turn_sign[0]), float(episodes.base[0])
    ranges = batch.snapshot.ranges[i, :: int(turn_sign)]  # the canonical frame mirrors right turns
    target = frames.canonical_to_pipe(episodes.target[0], turn_sign, base)
    return Scene(episodes.pipes[0], batch.robot, base, batch.q[i], ranges, target)


def _traverse_scene(batch: TraverseBatch, episodes: TraverseEpisodes, i: int) -> Scene:
    pipe, base, ranges = episodes.pipes[0], float(episodes.base[0]), np.array(batch.ranges[i])
    return Scene(pipe, batch.robot, base, batch.q[i], ranges, gravity=episodes.gravity[0])


CORNER = EnvTask("reach", ReachConfig, _corner_scene, 0.4)
TRAVERSE = EnvTask("traverse", TraverseConfig, _traverse_scene, 0.7)
