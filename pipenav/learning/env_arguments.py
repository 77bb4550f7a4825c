"""Training presets as arguments of Gymnasium environments."""

from __future__ import annotations

from typing import Any

from pipenav.disturbances.disturbance import UNDISTURBED
from pipenav.errors import PipenavError
from pipenav.learning.config import TrainConfig, load_config, preset_names
from pipenav.learning.stages import training_stages


def preset_arguments(preset: str, kind: str) -> dict[str, Any]:
    """Robot, pipes, backend, options and task of a preset's last stage, by the names of an environment's arguments.

    Args:
        preset: name of a training preset.
        kind: kind of the environment's task.

    Raises:
        UnknownName: no such preset.
        PipenavError: a preset of another task, or one whose trainings disturb the robot, as environments do not.
    """
    config = _aim(preset)
    if not _fits(config, kind):
        fitting = ", ".join(name for name in preset_names() if _fits(_aim(name), kind))
        other = config.task.kind != kind
        why = f"is of the task {config.task.kind!r}" if other else "disturbs the robot, which environments cannot do"
        raise PipenavError(f"preset {preset!r} {why}: choose one of {fitting}.")
    return {
        "robot": config.robot,
        "pipes": config.pipes,
        "backend": config.backend,
        "options": config.options,
        "task": config.task,
    }


def _aim(preset: str) -> TrainConfig:
    """The configuration that a preset's training ends with."""
    return training_stages(load_config(preset))[-1].config


def _fits(config: TrainConfig, kind: str) -> bool:
    return config.task.kind == kind and config.randomise == UNDISTURBED
