"""Spaces and `info` of a task's batch, which all environments share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from pipenav.arrays import Ints
from pipenav.tasks.batch import StepResult, TaskBatch
from pipenav.tasks.outcome import Outcome

Float32s = NDArray[np.float32]

OUTCOME_LABELS = np.array([outcome.label for outcome in Outcome])
"""Labels of the outcomes, by their numbers."""


def observation_space(batch: TaskBatch) -> spaces.Space[Float32s]:
    """Space of one robot's observations. It is unbounded: no sensor limits what an impact does to a joint's speed."""
    return cast("spaces.Space[Float32s]", spaces.Box(-np.inf, np.inf, (batch.observation_size,), np.float32))


def action_space(batch: TaskBatch) -> spaces.Space[Float32s]:
    """Space of one robot's actions: a share in [-1, 1] for every actuator."""
    return cast("spaces.Space[Float32s]", spaces.Box(-1.0, 1.0, (batch.action_size,), np.float32))


def step_info(result: StepResult, indices: Ints | slice = slice(None)) -> dict[str, NDArray[Any]]:
    """Contents of `info` after a step, one array for each key, (k,).

    Args:
        result: result of the step.
        indices: which robots, (k,); all by default.
    """
    outcome = result.outcome[indices]
    return {
        "outcome": OUTCOME_LABELS[outcome],
        "is_success": outcome == Outcome.REACHED.value,
        "min_range_m": result.min_range[indices],
        "contact_force_n": result.truth.contact_force[indices],
        "penetration_m": result.truth.penetration[indices],
    }


def one_info(info: Mapping[str, NDArray[Any]], i: int) -> dict[str, Any]:
    """Part of `step_info` for robot i, in Python's own types."""
    return {key: column[i].item() for key, column in info.items()}
