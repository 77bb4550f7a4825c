"""The tasks as Gymnasium environments: `pipenav/Corner-v0` of an arm, `pipenav/Traverse-v0` of the whole robot.

Importing this module registers them: `gymnasium.make("pipenav.env:pipenav/Corner-v0")` does both at once. Beside the
arguments of `CornerEnv` and `TraverseEnv`, `make` and `make_vec` take `preset`, the name of a training preset.
"""

from __future__ import annotations

from typing import Any

import gymnasium

from pipenav.envs.env_tasks import CORNER_ID, TRAVERSE_ID
from pipenav.envs.gymnasium_env import CornerEnv, TraverseEnv
from pipenav.envs.vector_env import CornerVectorEnv, TraverseVectorEnv

__all__ = [
    "ENV_ID",
    "TRAVERSE_ID",
    "CornerEnv",
    "CornerVectorEnv",
    "TraverseEnv",
    "TraverseVectorEnv",
]

ENV_ID = CORNER_ID

_EnvClass = type[CornerEnv] | type[TraverseEnv] | type[CornerVectorEnv] | type[TraverseVectorEnv]


class Maker:
    """Maker of the environments of a class, which starts from a preset where one is named.

    Args:
        made: class of the environments.
    """

    def __init__(self, made: _EnvClass) -> None:
        self._made, self.metadata = made, made.metadata

    def __call__(self, *, preset: str | None = None, **given: Any) -> Any:
        """An environment of the arguments given, and for all others of the preset.

        Args:
            preset: name of a training preset, whose robot, pipes, backend, options and task are taken; see
                `pipenav presets`.
            given: arguments of the class.

        Raises:
            PipenavError: an argument is unknown or impossible, or the preset is no preset of this task.
        """
        if preset is not None:
            from pipenav.learning.env_arguments import preset_arguments

            given = preset_arguments(preset, self._made.env_task.name) | given
        return self._made(**given)


make_corner, make_corners = Maker(CornerEnv), Maker(CornerVectorEnv)
make_traverse, make_traverses = Maker(TraverseEnv), Maker(TraverseVectorEnv)

gymnasium.register(CORNER_ID, entry_point=f"{__name__}:make_corner", vector_entry_point=f"{__name__}:make_corners")
gymnasium.register(
    TRAVERSE_ID, entry_point=f"{__name__}:make_traverse", vector_entry_point=f"{__name__}:make_traverses"
)
